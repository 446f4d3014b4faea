//! A joint calibration as the board meets it: what was entered, and poses under a beacon.

use crate::inputs::Random;
use courier_sensor::calibration::joint::{
    Constraints, JointBuffer, JointConfig, JointSample, Layout, Priors, Unknown, Values,
    about_sensor, entered, foreseen_under_beacon,
};
use courier_sensor::calibration::{Planner, Sample};
use courier_sensor::frame::SEGMENTS;
use courier_sensor::math::sincos_turns;

/// Sizes of the drawn coefficients, and of the noise of each reading, metres.
const COEFFICIENT_M: f32 = 8.0e-6;
const NOISE_M: f32 = 0.3e-6;
/// Height and lever arm over what was entered.
const OFF: f32 = 1.03;

/// The paper's: 1000 poses to fit, 200 held out, coefficients of the own phase, height and lever arm off by 3 %.
pub struct Problem {
    /// As the session has them.
    pub constraints: Constraints,
    /// Where the fit starts.
    pub entered: Values,
    /// As the session has them.
    pub priors: Priors,
    truth: Values,
    config: JointConfig,
    random: Random,
}

impl Problem {
    /// Drawn from a seed.
    ///
    /// # Panics
    /// Never: equation (9) has as many terms as can be fitted.
    #[must_use]
    pub fn new(seed: u64) -> Self {
        let config = JointConfig::default();
        let Some(layout) = Layout::new(&config.model) else {
            unreachable!("equation (9) can be fitted")
        };
        let entered = entered(&layout, &config.model, &config.geometry);
        let (mut truth, mut random) = (entered, Random::new(seed));
        for (i, value) in truth.iter_mut().enumerate().take(layout.len()) {
            match layout.unknown(i) {
                Unknown::Coefficient { term, .. } if term.lateral_order == 0 => {
                    *value = COEFFICIENT_M * random.signed();
                }
                Unknown::Height | Unknown::Lever(_) => *value *= OFF,
                _ => {}
            }
        }
        let constraints = Constraints {
            geometry: config.geometry,
            layout,
            noise: config.noise,
            stated_noise: config.noise,
            weighting: config.weighting,
        };
        Self {
            constraints,
            entered,
            priors: config.priors,
            truth,
            config,
            random,
        }
    }

    /// Visits all poses.
    pub fn fill(&mut self, buffer: &mut JointBuffer) {
        let visits = self.config.visits;
        let mut planner = Planner::new(visits.range, visits.seed);
        for n in 0..visits.total() {
            if n == visits.poses {
                buffer.hold_out_rest();
            }
            let pose = about_sensor(self.config.geometry.lever_m, planner.centred(false));
            let (constraints, truth) = (&self.constraints, &self.truth);
            let seen = foreseen_under_beacon(constraints, truth, &Sample::ZERO, &pose);
            buffer.push(self.spoiled(seen));
        }
    }

    /// With the segments' errors and noise.
    fn spoiled(&mut self, mut sample: JointSample) -> JointSample {
        let pitch_m = self.config.geometry.pitch_m;
        let mut errors_m = [0.0; SEGMENTS];
        for (i, value) in self.truth.iter().enumerate() {
            if let Some((segment, share)) = self.share(i, &sample) {
                errors_m[segment] += value * share;
            }
        }
        for (fraction, error_m) in sample.fraction_turns.iter_mut().zip(errors_m) {
            *fraction -= (error_m + NOISE_M * self.random.signed()) / pitch_m;
        }
        let scale_m = self.config.geometry.height_m * self.config.geometry.tan_full_scale;
        for deflection in &mut sample.deflection {
            *deflection += NOISE_M * self.random.signed() / scale_m;
        }
        sample
    }

    /// Segment that an unknown coefficient is of, and its function at the sample.
    fn share(&self, index: usize, sample: &JointSample) -> Option<(usize, f32)> {
        let layout = &self.constraints.layout;
        let Unknown::Coefficient {
            segment,
            term,
            part,
        } = (index < layout.len()).then(|| layout.unknown(index))?
        else {
            return None;
        };
        let turns = f32::from(term.own_order) * sample.fraction_turns[segment];
        let (sine, cosine) = sincos_turns(turns);
        Some((segment, if part == 0 { sine } else { cosine }))
    }
}
