//! What another recording of the same motion is expected to show.

use super::fitted_effects::FittedEffects;
use crate::inference::bootstrap::other_course;
use crate::inference::residuals::Residuals;
use crate::linearization::recording::LatentDisplacement;
use crate::linearization::relinearized::RelinearizedFit;
use crate::transfer::model::is_time_bound;
use effects::effect::Transfer;
use effects::sensor::READINGS;
use effects::{Card, Detection};

impl FittedEffects<'_> {
    /// What the chosen model, and the baseline alone, leave on another recording of this motion.
    pub(super) fn claim(&mut self) {
        if let Some(after) = self.relinearized.left_out() {
            self.after = self.by_stated_noise(after);
        }
        self.transfer_residuals = super::wander_elsewhere::left(&self.relinearized)
            .map(|[left, folds]| [left, folds].map(|r| self.by_stated_noise(&r)));
        let model = self
            .transfer_residuals
            .as_ref()
            .map_or(self.relinearized.left_out(), |e| Some(&e[0]));
        self.without_beats =
            model.and_then(|left| super::wander_elsewhere::without_beats(&self.relinearized, left));
        let mut stated = self.design.linearized.moved(
            self.prepared.baseline.clone(),
            LatentDisplacement::default(),
        );
        stated.noise = [1.0; READINGS];
        let baseline = RelinearizedFit::new(&stated, self.prepared.point(), &[]);
        self.before_by_folds = baseline.residuals().clone();
        if let Some(before) = baseline.left_out() {
            self.before = before.clone();
        }
    }

    /// What another recording is expected to show.
    pub(super) fn prediction(&self) -> &Residuals {
        self.transfer_residuals
            .as_ref()
            .map_or(&self.after, |e| &e[0])
    }

    /// 95 % interval of what another recording is expected to show of a channel, m.
    pub(super) fn prediction_interval_m(&self, named: bool, channel: usize) -> [f64; 2] {
        let model = if named {
            self.prediction()
        } else {
            &self.before
        };
        let run = &self.prepared.observations.run;
        let [low, mut high] = model.predicted_rms_m(channel, self.folds_m(named, channel), run);
        if let Some(more) = self.without_beats.as_ref().filter(|_| named) {
            high = high.max(more.channel_rms_m(channel).0);
        }
        if !named || self.transfer_residuals.is_none() {
            return [low, high];
        }
        let known_m = self.after.channel_rms_m(channel).0;
        let [less, more] = other_course(model.channel_rms_m(channel).0, known_m);
        [low.min(less), high.max(more)]
    }

    /// What the model that [`Self::prediction`] speaks of, or the baseline alone, leaves of a channel on folds that it has not seen, m.
    fn folds_m(&self, named: bool, channel: usize) -> f64 {
        let by_folds = match &self.transfer_residuals {
            _ if !named => &self.before_by_folds,
            Some([_, folds]) => folds,
            None => self.relinearized.residuals(),
        };
        by_folds.channel_rms_m(channel).0
    }

    /// What must be said where a vibration beats.
    pub(super) fn beat_remark(&self) -> Option<String> {
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
        let inputs = &self.relinearized.linearized.inputs;
        let names = self.names();
        let mut cards = names.iter().filter_map(|name| effects::card(name));
        cards.find(|card| card.keeps_its_own_time() && !is_time_bound(card.name, inputs))
    }

    /// What must be said where the course of what is named is another one elsewhere.
    pub(super) fn time_bound_remark(&self) -> String {
        let floor = self.floor.white_square.sqrt();
        let names = self.names();
        let inputs = &self.relinearized.linearized.inputs;
        let own = |card: &&Card| match card.transfer {
            Transfer::ItsOwnTime => is_time_bound(card.name, inputs),
            _ => !card.its_own.is_empty(),
        };
        let cards = names.iter().filter_map(|name| effects::card(name));
        let mut there: Vec<&Card> = cards.filter(own).collect();
        there.sort_by_key(|card| !card.keeps_its_own_time());
        let selected = there
            .iter()
            .map(|card| format!("{}: {}", card.name, card.its_own));
        let what: Vec<String> = selected.collect();
        format!(
            "{} belongs to this recording's time and is known for this one alone; with it {:.2} times the floor is left here, without it {:.2}, which another recording is expected to show",
            what.join(" and "),
            self.after.white_rms() / floor,
            self.prediction().white_rms() / floor
        )
    }
}
