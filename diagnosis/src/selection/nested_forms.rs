//! Effects that are told by few unknowns as long as these leave no gap. Where they do, more of what each may be is told, and kept if it
//! leaves much less.

use super::selected::Told;
use super::{CLOSE, Judge, LITTLE, TRUSTED};
use crate::design::study::{Look, study};
use crate::linearization::relinearized::Refined;
use crate::trace::log;
use effects::sensor::{Channel, Fuller, Survey};

/// More of an effect is worth its unknowns if less than this share of the gap is left.
const LEAVES: f64 = 0.7;
/// The same of a few more that follow nothing but the temperature.
const LEAVES_OF_FEW: f64 = 0.9;

/// The same of one effect in the place of two: no more than these leave, give or take what two of many fits differ by.
const AS_MUCH: f64 = 1.1;

/// Standard deviations of a mean square that chance takes it by.
const CHANCE: f64 = 4.0;

/// What more there is to tell of an effect, where it may be, and what it must leave.
struct More {
    effect: &'static str,
    /// What it is found as while no more is told of it.
    found_as: &'static str,
    /// What stands in for it beside it.
    completed_by: Option<&'static str>,
    /// Share of the gap that what is found may leave: where it leaves more, what is told more of may not be what there is.
    beside: f64,
    /// Share of what is left that it must leave.
    leaves: f64,
    tell: fn(&mut Fuller),
}

impl More {
    const fn of(effect: &'static str, tell: fn(&mut Fuller)) -> Self {
        Self {
            effect,
            found_as: effect,
            completed_by: None,
            beside: TRUSTED,
            leaves: LEAVES,
            tell,
        }
    }
}

/// In the order in which they are tried; a further one is an entry here and a field of [`Fuller`].
const FULLER: [More; 12] = [
    More::of("velocity_lag", |told| told.lag_waves = true),
    More::of("hysteresis", |told| told.fades_at_rest = true),
    More::of("hysteresis", |told| told.memory_waves = true),
    More {
        // A direction alone takes half of what only a fast courier feels.
        beside: LITTLE,
        ..More::of("hysteresis", |told| told.softens = true)
    },
    More {
        // At two speeds a delay and its square are a direction.
        found_as: "velocity_lag",
        ..More::of("hysteresis", |told| {
            told.fades_at_rest = true;
            told.softens = true;
        })
    },
    More {
        leaves: LEAVES_OF_FEW,
        ..More::of("thermal_drift", |told| told.warms_slowly = true)
    },
    More::of("thermal_drift", |told| told.pairs_warm = true),
    More {
        // A pair that warms wanders.
        completed_by: Some("quadrature_drift"),
        leaves: AS_MUCH,
        ..More::of("thermal_drift", |told| told.pairs_warm = true)
    },
    More::of("angle_dependence", |told| {
        told.turns_with_theta = Some(Channel::Cosine)
    }),
    More::of("angle_dependence", |told| {
        told.turns_with_theta = Some(Channel::Sine)
    }),
    More::of("angle_dependence", |told| told.bends_with_theta = true),
    More::of("lateral_dependence", |told| told.lateral_mixes = true),
];

impl Judge<'_> {
    /// Compares all anew with more told of what is found, and keeps that where it leaves less: where most of the gap is its own.
    pub(super) fn tell_more_fully(&mut self) {
        for more in FULLER {
            let found = self.told.names(&self.study);
            let shows = self.ratio() >= CLOSE && self.told.found.rest < more.beside;
            let has = |name: &str| found.iter().any(|n| n == name);
            let other = more.found_as != more.effect;
            let may = !other || self.allowed(more.effect) && !has(more.effect);
            let complete = more.completed_by.is_none_or(has);
            if shows && may && has(more.found_as) && complete {
                self.tell_fully(&more, &found);
            }
        }
    }

    fn tell_fully(&mut self, more: &More, found: &[String]) {
        let (_, noise) = self.levels();
        let excess = |fine: &Refined| fine.residuals().white_rms().powi(2) - noise;
        let left = excess(&self.fine);
        let told_as = |name: &String| {
            if name == more.found_as {
                more.effect.into()
            } else {
                name.clone()
            }
        };
        let of_itself = |name: &&String| more.completed_by != Some(name.as_str());
        let names: Vec<String> = found.iter().filter(of_itself).map(told_as).collect();
        let fuller = self.fitted_telling(&names, &|survey: &mut Survey| {
            (more.tell)(&mut survey.fuller)
        });
        let leaves = excess(&fuller);
        log(&format!(
            "{} told more fully leaves {leaves:.4} of {left:.4}",
            more.effect
        ));
        // Less than the noise: at angles or ways that are seldom gone through, amounts run up until the slope of a reading takes its noise in.
        let least = -CHANCE * (2.0 / fuller.gram.total_rows() as f64).sqrt();
        let worth = |excess: f64| (least..more.leaves * left).contains(&excess);
        if !worth(leaves) {
            return;
        }
        let mut survey = self.study.scene.survey.clone();
        (more.tell)(&mut survey.fuller);
        let look = Look {
            as_in: Some(&survey),
            ..Look::default()
        };
        let again = study(self.prepared, self.options, &fuller.about, look);
        let told = Told::new(&again, self.noise.is_some());
        let fine = Refined::of(&again, &told);
        if worth(excess(&fine)) {
            self.take_fitted(again, told, fine);
        }
    }
}
