//! What another recording of the same motion is expected to show.

use super::ModelSelection;
use crate::inference::bootstrap::other_course;
use crate::inference::residuals::Residuals;
use crate::linearization::relinearized::RelinearizedFit;
use crate::linearization::scene::LatentDisplacement;
use crate::transfer::model::is_of_its_time;
use effects::effect::Transfer;
use effects::sensor::READINGS;
use effects::{Card, Detection};

impl ModelSelection<'_> {
    /// What the chosen model, and the baseline alone, leave on another recording of this motion.
    pub(super) fn claim(&mut self) {
        if let Some(after) = self.fine.left_out() {
            self.after = self.by_stated_noise(after);
        }
        self.elsewhere = super::wander_elsewhere::left(&self.fine)
            .map(|[left, folds]| [left, folds].map(|r| self.by_stated_noise(&r)));
        let model = self
            .elsewhere
            .as_ref()
            .map_or(self.fine.left_out(), |e| Some(&e[0]));
        self.without_beats =
            model.and_then(|left| super::wander_elsewhere::without_beats(&self.fine, left));
        let mut stated = self.study.scene.moved(
            self.prepared.baseline.clone(),
            LatentDisplacement::default(),
        );
        stated.noise = [1.0; READINGS];
        let baseline = RelinearizedFit::new(&stated, self.prepared.about(), &[]);
        self.before_by_folds = baseline.residuals().clone();
        if let Some(before) = baseline.left_out() {
            self.before = before.clone();
        }
    }

    /// What another recording is expected to show.
    pub(super) fn foretold(&self) -> &Residuals {
        self.elsewhere.as_ref().map_or(&self.after, |e| &e[0])
    }

    /// 95 % interval of what another recording is expected to show of a channel, m.
    pub(super) fn foretold_interval_m(&self, named: bool, channel: usize) -> [f64; 2] {
        let model = if named { self.foretold() } else { &self.before };
        let run = &self.prepared.observations.run;
        let [low, mut high] = model.foretold_m(channel, self.folds_m(named, channel), run);
        if let Some(more) = self.without_beats.as_ref().filter(|_| named) {
            high = high.max(more.channel_rms_m(channel).0);
        }
        if !named || self.elsewhere.is_none() {
            return [low, high];
        }
        let known_m = self.after.channel_rms_m(channel).0;
        let [less, more] = other_course(model.channel_rms_m(channel).0, known_m);
        [low.min(less), high.max(more)]
    }

    /// What the model that [`Self::foretold`] speaks of, or the baseline alone, leaves of a channel on folds that it has not seen, m.
    fn folds_m(&self, named: bool, channel: usize) -> f64 {
        let by_folds = match &self.elsewhere {
            _ if !named => &self.before_by_folds,
            Some([_, folds]) => folds,
            None => self.fine.residuals(),
        };
        by_folds.channel_rms_m(channel).0
    }

    /// What must be said where a vibration beats.
    pub(super) fn if_it_beats_otherwise(&self) -> Option<String> {
        let floor = self.floor.white_square.sqrt();
        let without = self.without_beats.as_ref()?;
        Some(format!(
            "{}: its level beats evenly all the time, and is taken to do so elsewhere; where it beats otherwise {:.2} times the floor is left",
            effects::name_of(Detection::ByLines),
            without.white_rms() / floor
        ))
    }

    /// The wander that was found and that any recording's counts show.
    pub(super) fn followed(&self) -> Option<&'static Card> {
        let inputs = &self.fine.scene.inputs;
        let names = self.told.names(&self.study);
        let mut cards = names.iter().filter_map(|name| effects::card(name));
        cards.find(|card| card.keeps_its_own_time() && !is_of_its_time(card.name, inputs))
    }

    /// What must be said where the course of what is named is another one elsewhere.
    pub(super) fn of_its_time(&self) -> String {
        let floor = self.floor.white_square.sqrt();
        let names = self.told.names(&self.study);
        let inputs = &self.fine.scene.inputs;
        let own = |card: &&Card| match card.transfer {
            Transfer::ItsOwnTime => is_of_its_time(card.name, inputs),
            _ => !card.its_own.is_empty(),
        };
        let cards = names.iter().filter_map(|name| effects::card(name));
        let mut there: Vec<&Card> = cards.filter(own).collect();
        there.sort_by_key(|card| !card.keeps_its_own_time());
        let told = there
            .iter()
            .map(|card| format!("{}: {}", card.name, card.its_own));
        let what: Vec<String> = told.collect();
        format!(
            "{} belongs to this recording's time and is known for this one alone; with it {:.2} times the floor is left here, without it {:.2}, which another recording is expected to show",
            what.join(" and "),
            self.after.white_rms() / floor,
            self.foretold().white_rms() / floor
        )
    }
}
