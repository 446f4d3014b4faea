//! Effects that are told by few unknowns as long as these leave no gap. Where they do, more of what each may be is told, and kept if it
//! leaves much less.

use super::explain::Told;
use super::{CLOSE, Judge, TRUSTED};
use crate::refine::Refined;
use crate::study::{Look, study};
use crate::trace::log;
use effects::sensor::{Fuller, Survey};

/// More of an effect is worth its unknowns if less than this share of the gap is left.
const LEAVES: f64 = 0.7;
/// The same of a few more that follow nothing but the temperature.
const LEAVES_OF_FEW: f64 = 0.9;

/// Standard deviations of a mean square that chance takes it by.
const CHANCE: f64 = 4.0;

/// What there is to tell of which effect, and what it must leave.
const FULLER: [(&str, f64, fn(&mut Fuller)); 6] = [
    ("velocity_lag", LEAVES, |told| told.lag_waves = true),
    ("hysteresis", LEAVES, |told| told.fades_at_rest = true),
    ("hysteresis", LEAVES, |told| told.memory_waves = true),
    ("thermal_drift", LEAVES_OF_FEW, |told| {
        told.warms_slowly = true
    }),
    ("angle_dependence", LEAVES, |told| {
        told.bends_with_theta = true
    }),
    ("lateral_dependence", LEAVES, |told| {
        told.lateral_mixes = true
    }),
];

impl Judge<'_> {
    /// Compares all anew with more told of what is found, and keeps that where it leaves less: where most of the gap is its own.
    pub(super) fn tell_more_fully(&mut self) {
        for (name, share, more) in FULLER {
            let found = self.told.names(&self.study);
            let shows = self.ratio() >= CLOSE && self.told.found.rest < TRUSTED;
            if shows && found.iter().any(|n| n == name) {
                self.tell_fully(name, &found, share, more);
            }
        }
    }

    fn tell_fully(&mut self, name: &str, found: &[String], share: f64, more: fn(&mut Fuller)) {
        let (_, noise) = self.levels();
        let excess = |fine: &Refined| fine.residuals.white_rms().powi(2) - noise;
        let left = excess(&self.fine);
        let fuller = self.fitted_telling(found, &|survey: &mut Survey| more(&mut survey.fuller));
        let leaves = excess(&fuller);
        log(&format!(
            "{name} told more fully leaves {leaves:.4} of {left:.4}"
        ));
        // Less than the noise: at angles or ways that are seldom gone through, amounts run up until the slope of a reading takes its noise in.
        let least = -CHANCE * (2.0 / fuller.gram.total_rows() as f64).sqrt();
        let worth = |excess: f64| (least..share * left).contains(&excess);
        if !worth(leaves) {
            return;
        }
        let mut survey = self.study.scene.survey.clone();
        more(&mut survey.fuller);
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
