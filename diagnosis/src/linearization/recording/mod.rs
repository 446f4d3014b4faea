//! One recording under one baseline: residual channels, their noise, and what the sensor knows at each sample.

mod amplitude;
mod amplitude_choice;
mod amplitude_shape;
mod amplitudes;
mod basis_inputs;
mod constrained_positions;
mod covariates;
mod explained;
mod flaws;
mod instruments;
mod mesh;
mod offsets;
mod quiet;
mod rows;
mod sample;
mod scope;
mod wander;
mod warmth;

pub use explained::Amplitudes;
pub use rows::{ROWS, SOURCES, SampleRows, TARGET};
pub use scope::scope;

use crate::data::motion::Motion;
use crate::data::observations::Observations;
use crate::linearization::baseline::{Baseline, Scope};
use effects::sensor::{BasisInputs, LAGS_S, READINGS};
use instruments::Instruments;
use rayon::prelude::*;
use serde::{Deserialize, Serialize};
use std::sync::Arc;
use warmth::behind_k;

/// A recording, linearised about a baseline.
pub struct LinearizedRecording<'a> {
    /// The recording.
    pub observations: &'a Observations,
    /// Parameters that it is linearised about.
    pub baseline: Baseline,
    /// What they can speak about.
    pub scope: Scope,
    /// Speeds and directions.
    pub motion: Arc<Motion>,
    /// What the recording offers, and what was told besides.
    pub inputs: BasisInputs,
    /// What the recording offers by itself.
    offered: Arc<BasisInputs>,
    /// Calibrated segment positions, m.
    pub calibrated_m: [Vec<f64>; 4],
    /// Samples in use; disturbed ones are not.
    pub mask: Vec<bool>,
    /// What "no effect" means for amplitude and temperature: from this recording, or from the one that a model is of.
    pub normal: ReferenceValues,
    /// What the effects found so far add to the readings.
    pub displacement: LatentDisplacement,
    /// True if residuals are those of late segments as aligned in time, and not as late as they came.
    pub aligned_in_time: bool,
    /// Noise of each reading over the stated one: 1, or what was found.
    pub noise: [f64; READINGS],
    gain: [Vec<f64>; 4],
    ln_amplitude: [Vec<f64>; 4],
    amplitudes: Arc<Amplitudes>,
    quiet_m: Arc<[Vec<f64>; 4]>,
    behind_k: Arc<Vec<[f64; LAGS_S.len()]>>,
    path_estimator: PathEstimator,
    steady: Instruments,
}

/// How the segments' ways are told where effects that remember them hide them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct PathEstimator {
    /// By each segment's own reading, and not by all together.
    pub own: bool,
    /// Noise that a way must stand out of, over the readings'.
    pub louder: f64,
}

impl Default for PathEstimator {
    fn default() -> Self {
        Self {
            own: false,
            louder: 1.0,
        }
    }
}

/// What the effects found so far add to the readings, m; empty where nothing is found. It moves the phases that shapes are
/// evaluated at, and not the residual.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct LatentDisplacement {
    /// Of all effects: a segment is where its calibrated position and this say.
    pub total_m: [Vec<f64>; 4],
    /// Of effects in the electronics: equation (3) is a function of what the pair would give without them.
    pub electronic_m: [Vec<f64>; 4],
    /// Of what does not move a segment, to g_p, g_x and g_y; empty where no effect remembers its way.
    pub channels_m: [Vec<f64>; 3],
}

/// Reference values that amounts are relative to.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ReferenceValues {
    /// Mean temperature, °C.
    pub temperature_c: f64,
    /// Lowest and highest temperature, °C, where it was measured.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub temperatures_c: Option<[f64; 2]>,
    /// Logarithm of each pair's amplitude as mean, sines and cosines of orders 1 to 8 of the own phase; empty without counts.
    pub ln_amplitude: [Vec<f64>; 4],
    /// Offset of sine and cosine, gain and angle of each pair that wanders, as that pattern lacks them: means over the time, which equation
    /// (3) holds. Empty where a pair does not wander.
    #[serde(default)]
    pub mean_flaws: [Vec<f64>; 4],
}

impl<'a> LinearizedRecording<'a> {
    /// Linearises a recording about a baseline.
    pub fn new(observations: &'a Observations, baseline: Baseline, mask: Vec<bool>) -> Self {
        Self::relative_to(observations, baseline, mask, None)
    }

    /// The same with amounts relative to another recording's normal values.
    pub fn relative_to(
        observations: &'a Observations,
        baseline: Baseline,
        mask: Vec<bool>,
        normal: Option<&ReferenceValues>,
    ) -> Self {
        let n = observations.len();
        let scope = scope(observations);
        let (calibrated_m, gain) = calibrated(
            observations,
            scope,
            &baseline,
            &LatentDisplacement::default(),
        );
        let motion = Self::motion(observations, scope, &calibrated_m);
        let known: Vec<f64> = observations
            .temperature_c
            .iter()
            .copied()
            .filter(|t| t.is_finite())
            .collect();
        let mean_temperature_c = known.iter().sum::<f64>() / known.len().max(1) as f64;
        let mut this = Self {
            observations,
            baseline,
            scope,
            motion: Arc::new(motion),
            inputs: BasisInputs::default(),
            offered: Arc::default(),
            calibrated_m,
            mask,
            displacement: LatentDisplacement::default(),
            aligned_in_time: false,
            noise: [1.0; READINGS],
            gain,
            ln_amplitude: Default::default(),
            amplitudes: Arc::default(),
            quiet_m: Arc::default(),
            behind_k: Arc::new(behind_k(&observations.t_s, &observations.temperature_c)),
            path_estimator: PathEstimator::default(),
            steady: Instruments::default(),
            normal: normal.cloned().unwrap_or(ReferenceValues {
                temperature_c: mean_temperature_c,
                temperatures_c: range(&known),
                ..ReferenceValues::default()
            }),
        };
        let mut patterns = std::mem::take(&mut this.normal.ln_amplitude);
        let mut excess: [Vec<f64>; 4] = Default::default();
        let segments = patterns.par_iter_mut().zip(&mut excess).enumerate();
        segments.for_each(|(segment, (pattern, excess))| {
            if pattern.is_empty() {
                *pattern = this.amplitude_pattern(segment);
            }
            *excess = this.amplitude_excess(segment, pattern);
        });
        (this.normal.ln_amplitude, this.ln_amplitude) = (patterns, excess);
        this.quiet_m = Arc::new(this.quiet());
        this.steady = this.steady();
        this.inputs = this.look_over(n, &known);
        this.offered = Arc::new(this.inputs.clone());
        this
    }

    /// The same recording about another baseline and other effects; speeds and amplitudes stay, what a segment remembers of its way
    /// follows from where it is known to be now.
    pub fn moved(&self, baseline: Baseline, displacement: LatentDisplacement) -> Self {
        self.moved_at(baseline, displacement, self.noise)
    }

    /// The same with another noise of each reading, over the stated one.
    pub fn moved_at(
        &self,
        baseline: Baseline,
        displacement: LatentDisplacement,
        noise: [f64; READINGS],
    ) -> Self {
        let (calibrated_m, gain) =
            calibrated(self.observations, self.scope, &baseline, &displacement);
        let mut this = Self {
            motion: Arc::clone(&self.motion),
            observations: self.observations,
            baseline,
            scope: self.scope,
            inputs: self.inputs.clone(),
            offered: Arc::clone(&self.offered),
            calibrated_m,
            mask: self.mask.clone(),
            normal: self.normal.clone(),
            displacement,
            aligned_in_time: self.aligned_in_time,
            noise,
            gain,
            ln_amplitude: self.ln_amplitude.clone(),
            amplitudes: Arc::clone(&self.amplitudes),
            quiet_m: Arc::clone(&self.quiet_m),
            behind_k: Arc::clone(&self.behind_k),
            path_estimator: self.path_estimator,
            steady: Instruments::default(),
        };
        this.retrace(&self.displacement);
        this.steady = this.steady();
        this
    }

    /// True if it is linearised about this.
    pub fn is_about(&self, baseline: &Baseline, displacement: &LatentDisplacement) -> bool {
        self.baseline == *baseline && self.displacement == *displacement
    }

    /// The same, before anything is told of it: as [`Self::new`] and [`Self::moved`] give it, with these samples in use, at a fifth of their cost.
    pub fn anew(&self, mask: Vec<bool>) -> Self {
        let mut this = self.moved(self.baseline.clone(), self.displacement.clone());
        this.inputs = (*self.offered).clone();
        this.mask = mask;
        this
    }

    /// Angle and deflection as the neighbours tell them; nothing without a beacon, whose equations alone need them.
    fn steady(&self) -> Instruments {
        if !self.scope.beacon {
            return Instruments::default();
        }
        let theta_rad: Vec<f64> = (0..self.len()).map(|i| self.refined_theta_rad(i)).collect();
        Instruments::of(&theta_rad, self.observations, &self.motion.smooth)
    }

    /// The same with its ways told otherwise from here on.
    pub fn with_paths_by(&self, path_estimator: PathEstimator) -> Self {
        let mut this = self.moved(self.baseline.clone(), self.displacement.clone());
        this.path_estimator = path_estimator;
        this
    }

    /// Takes over another's way at a sample: where its segments are, and what they remember.
    pub fn take_way(&mut self, other: &Self, i: usize) {
        let shifts = self
            .displacement
            .total_m
            .iter_mut()
            .zip(&other.displacement.total_m);
        for (own, other) in shifts.filter(|(own, other)| i < own.len().min(other.len())) {
            own[i] = other[i];
        }
        Arc::make_mut(&mut self.motion).take_way(&other.motion, i);
    }

    /// The ways of those segments whose places another shift than the one before moves. A reference's places are moved by none.
    fn retrace(&mut self, before: &LatentDisplacement) {
        if self.scope.reference || self.displacement == *before {
            return;
        }
        let remembers = !self.displacement.channels_m[0].is_empty() && !self.path_estimator.own;
        let constrained_positions = remembers.then(|| self.constrained_positions());
        let way = |segment: usize| {
            let (there, here) = (
                &self.displacement.total_m[segment],
                &before.total_m[segment],
            );
            if there == here {
                return None;
            }
            let (place_m, louder) = match &constrained_positions {
                Some(all) => (all.place_m[segment].clone(), all.louder[segment]),
                None => {
                    let own = self.calibrated_m[segment].iter().enumerate();
                    (own.map(|(i, p)| p + at(there, i)).collect(), 1.0)
                }
            };
            let louder = louder * self.path_estimator.louder;
            Some(
                self.motion
                    .retraced(segment, &place_m, louder, self.observations),
            )
        };
        let ways: Vec<_> = (0..4).into_par_iter().map(way).collect();
        let motion = Arc::make_mut(&mut self.motion);
        for (segment, way) in ways.into_iter().enumerate() {
            way.into_iter().for_each(|way| motion.follow(segment, way));
        }
    }

    /// Speeds, from the reference where there is one: it carries no error pattern.
    fn motion(observations: &Observations, scope: Scope, calibrated_m: &[Vec<f64>; 4]) -> Motion {
        if !scope.reference {
            return Motion::new(observations, calibrated_m);
        }
        let reference = std::array::from_fn(|s| {
            let samples = 0..if scope.segments[s] {
                observations.len()
            } else {
                0
            };
            samples.map(|i| observations.reference_m(s, i)).collect()
        });
        Motion::new(observations, &reference)
    }

    /// Number of samples.
    pub fn len(&self) -> usize {
        self.observations.len()
    }

    /// True without samples.
    pub fn is_empty(&self) -> bool {
        self.observations.is_empty()
    }
}

/// What is added at a sample; nothing where nothing is found.
fn at(list: &[f64], i: usize) -> f64 {
    list.get(i).copied().unwrap_or(0.0)
}

/// Least and largest; none of nothing.
pub fn range(values: &[f64]) -> Option<[f64; 2]> {
    let low = values.iter().copied().reduce(f64::min)?;
    Some([low, values.iter().copied().fold(low, f64::max)])
}

/// Calibrated positions, m, and the factors by which noise grows.
fn calibrated(
    observations: &Observations,
    scope: Scope,
    baseline: &Baseline,
    displacement: &LatentDisplacement,
) -> ([Vec<f64>; 4], [Vec<f64>; 4]) {
    let mut position_m: [Vec<f64>; 4] = Default::default();
    let mut gain: [Vec<f64>; 4] = Default::default();
    let segments = position_m.par_iter_mut().zip(&mut gain).enumerate();
    let known = segments.filter(|(s, _)| scope.segments[*s]);
    known.for_each(|(s, (position_m, gain))| {
        let off = &displacement.electronic_m[s];
        (*position_m, *gain) = observations.position_m[s]
            .iter()
            .enumerate()
            .map(|(i, &p)| {
                let clean = p + at(off, i);
                let (error, slope) = baseline.error_m(s, clean, observations.pitch_m);
                (p + error, 1.0 + slope)
            })
            .unzip();
    });
    (position_m, gain)
}
