//! Keeps bad samples out of the estimate: a start-up buffer judged as a whole, then a gate on each innovation.
//!
//! Before there are more rows than unknowns no prediction exists, and shortly after it is worth little. So the first
//! [`STARTUP`] samples are kept; when they are complete, the one whose deleted residual (Belsley, Kuh and Welsch 1980,
//! sec. 2.1) is largest is taken out and the rest fitted again, as long as it is out of proportion. Later samples are
//! compared with their prediction, whose variance holds noise and parameter covariance. When all are in, the whole fit
//! judges the start-up samples again.

use super::joint::JointEstimator;
use super::regression::Regression;
use super::sample::{SAMPLE_WORDS, Sample};
use crate::frame::SEGMENTS;
use crate::lsq::Estimator;
use crate::math::sqrt;

/// The platen sensor's estimator: the joint calibration's, whose memory it shares. One size is one copy of the code.
pub type PlatenEstimator = JointEstimator;

/// Samples judged together. Derived from the unknowns: three for each of equation (3)'s 33, nearly; two for each of the most.
pub const STARTUP: usize = 96;
/// Innovations, or deleted residuals, above this many predicted standard deviations are refused. Derived from the normal tail:
/// one good sample in 16,000, some more at start-up, where the noise is less well known.
const REFUSED: f32 = 4.0;
/// Those above this count less, so that none pulls harder than this (Huber 1964).
const FULL_WEIGHT: f32 = 2.5;
/// Of the start-up samples. A bound on the work: the weights of the last stand.
const REWEIGHTINGS: usize = 2;

/// Phases per pitch at which the predicted deviation is looked at. Derived from the sampling theorem, with a factor of two: four
/// per period of order 6.
const PHASES: usize = 24;

/// What became of a sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Verdict {
    /// Entered.
    Entered,
    /// Left out.
    Refused,
}

/// Estimator with its gate. All state of the platen's fit.
#[derive(Clone, Debug)]
pub struct GatedFit {
    estimator: PlatenEstimator,
    /// Their words.
    startup: [u32; SAMPLE_WORDS * STARTUP],
    /// Of each sample's row; zero: left out.
    startup_weight: [f32; STARTUP],
    buffered: usize,
    started: bool,
    refused: u32,
    noise_floor_m: f32,
}

impl Default for GatedFit {
    fn default() -> Self {
        Self::new()
    }
}

impl GatedFit {
    /// All zeros, so that as a constant it is a clearing of memory in its place; [`GatedFit::reset`] comes before all else.
    pub const fn new() -> Self {
        Self {
            estimator: Estimator::blank(),
            startup: [0; SAMPLE_WORDS * STARTUP],
            startup_weight: [0.0; STARTUP],
            buffered: 0,
            started: false,
            refused: 0,
            noise_floor_m: 0.0,
        }
    }

    /// Empties it. `noise_floor_m`: the least parity noise that is believed when gating.
    pub fn reset(&mut self, unknowns: usize, noise_floor_m: f32) {
        self.estimator.reset(unknowns);
        self.startup_weight = [1.0; STARTUP];
        self.buffered = 0;
        self.started = false;
        self.refused = 0;
        self.noise_floor_m = noise_floor_m;
    }

    /// The estimate.
    #[must_use]
    pub fn estimator(&self) -> &PlatenEstimator {
        &self.estimator
    }

    /// For solving.
    pub fn estimator_mut(&mut self) -> &mut PlatenEstimator {
        &mut self.estimator
    }

    /// Samples left out.
    #[must_use]
    pub fn refused(&self) -> u32 {
        self.refused
    }

    /// Rows' noise so far, metres: the residual's, not below the floor.
    #[must_use]
    pub fn noise_m(&self) -> f32 {
        let freedom = self.estimator.rows.effective_rows() - self.estimator.rows.unknowns() as f32;
        if freedom < 1.0 {
            return self.noise_floor_m;
        }
        (self.estimator.rows.residual_norm() / sqrt(freedom)).max(self.noise_floor_m)
    }

    /// Adds a sample. Cost: two substitutions of 33 unknowns; once, when start-up is complete, up to 96 rows a dozen times.
    pub fn add(&mut self, regression: &Regression, sample: &Sample) -> Verdict {
        if self.started {
            return self.gate(regression, sample);
        }
        self.startup.as_chunks_mut().0[self.buffered] = sample.to_words();
        self.buffered += 1;
        self.enter(regression, sample, 1.0);
        if self.buffered == STARTUP {
            self.finish_startup(regression);
        }
        Verdict::Entered
    }

    /// Judges the buffered samples, be they few; later ones are gated.
    pub fn finish_startup(&mut self, regression: &Regression) {
        if self.started {
            return;
        }
        self.started = true;
        for _ in 0..STARTUP / 4 {
            let (worst, ratio) = self.worst_of_startup(regression);
            if ratio <= REFUSED {
                break;
            }
            self.startup_weight[worst] = 0.0;
            self.refused += 1;
            self.enter_startup(regression);
        }
        for _ in 0..REWEIGHTINGS {
            self.reweigh_startup(regression);
            self.enter_startup(regression);
        }
    }

    /// Judges the start-up samples once more, by the whole fit, and takes those out that are far off. Call before solving.
    pub fn review_startup(&mut self, regression: &Regression) {
        self.finish_startup(regression);
        for i in 0..self.buffered {
            let weight = self.startup_weight[i];
            if weight > 0.0 && self.deleted_ratio(regression, i) > REFUSED {
                let (row, rhs) = regression.row(&self.startup(i));
                let row = row.map(|x| x * weight);
                if self
                    .estimator
                    .rows
                    .remove(&row[..regression.unknowns()], rhs * weight)
                {
                    self.startup_weight[i] = 0.0;
                    self.refused += 1;
                }
            }
        }
    }

    /// Innovation of a sample, metres, and its predicted standard deviation; `None` while not predictable.
    #[must_use]
    pub fn innovation(&self, regression: &Regression, sample: &Sample) -> Option<(f32, f32)> {
        let (row, rhs) = regression.row(sample);
        let prediction = self.estimator.rows.predict(&row[..regression.unknowns()])?;
        let innovation = rhs - prediction.value;
        let deviation = self.noise_m() * sqrt(1.0 + prediction.leverage);
        (deviation.is_finite() && innovation.is_finite()).then_some((innovation, deviation))
    }

    /// Largest predicted standard deviation of a segment's correction over the pitch, its constant aside, metres; infinite
    /// while not determined. Cost: 96 substitutions.
    #[must_use]
    pub fn worst_deviation_m(&self, regression: &Regression) -> f32 {
        let rows = &self.estimator.rows;
        let mut worst = 0.0f32;
        for step in 0..SEGMENTS * PHASES {
            let functional =
                regression.correction(step % SEGMENTS, step as f32 / (SEGMENTS * PHASES) as f32);
            let prediction = rows.predict(&functional[..regression.unknowns()]);
            worst = worst.max(prediction.map_or(f32::INFINITY, |p| p.leverage));
        }
        self.noise_m() * sqrt(worst)
    }

    fn gate(&mut self, regression: &Regression, sample: &Sample) -> Verdict {
        let weight = match self.innovation(regression, sample) {
            None => 1.0,
            Some((innovation, deviation)) => {
                let ratio = innovation.abs() / deviation;
                if ratio > REFUSED {
                    self.refused += 1;
                    return Verdict::Refused;
                }
                row_weight(ratio)
            }
        };
        self.enter(regression, sample, weight);
        Verdict::Entered
    }

    fn enter(&mut self, regression: &Regression, sample: &Sample, weight: f32) {
        let (row, rhs) = regression.row(sample);
        let row = row.map(|x| x * weight);
        // Finite and of the right length: fractions come from checked frames.
        let _ = self
            .estimator
            .rows
            .enter(&row[..regression.unknowns()], rhs * weight);
    }

    fn startup(&self, i: usize) -> Sample {
        Sample::from_words(&self.startup.as_chunks().0[i])
    }

    fn enter_startup(&mut self, regression: &Regression) {
        self.estimator.reset(self.estimator.rows.unknowns());
        for i in 0..self.buffered {
            let (sample, weight) = (self.startup(i), self.startup_weight[i]);
            if weight > 0.0 {
                self.enter(regression, &sample, weight);
            }
        }
    }

    /// The sample that fits the others worst, and by how many standard deviations.
    fn worst_of_startup(&self, regression: &Regression) -> (usize, f32) {
        (0..self.buffered)
            .filter(|&i| self.startup_weight[i] > 0.0)
            .fold((0, 0.0), |worst, i| {
                let ratio = self.deleted_ratio(regression, i);
                if ratio > worst.1 { (i, ratio) } else { worst }
            })
    }

    fn reweigh_startup(&mut self, regression: &Regression) {
        let mut weights = self.startup_weight;
        for (i, weight) in weights
            .iter_mut()
            .enumerate()
            .take(self.buffered)
            .filter(|(_, w)| **w > 0.0)
        {
            *weight = row_weight(self.deleted_ratio(regression, i));
        }
        self.startup_weight = weights;
    }

    /// Residual of a start-up sample against the fit of all others over its standard deviation; zero if unknown.
    fn deleted_ratio(&self, regression: &Regression, i: usize) -> f32 {
        let rows = &self.estimator.rows;
        let freedom = rows.rows() as f32 - 1.0 - rows.unknowns() as f32;
        let (row, rhs) = regression.row(&self.startup(i));
        let Some(prediction) = rows
            .predict(&row[..rows.unknowns()])
            .filter(|_| freedom >= 4.0)
        else {
            return 0.0;
        };
        let residual = rhs - prediction.value;
        let square = self.startup_weight[i] * self.startup_weight[i];
        let apart = (1.0 - square * prediction.leverage).max(1.0e-3);
        let norm = rows.residual_norm();
        let share = square * (residual / norm) * (residual / norm) / apart;
        let others = (norm * sqrt((1.0 - share).max(0.0) / freedom)).max(self.noise_floor_m);
        let ratio = residual.abs() / (sqrt(apart) * others);
        if ratio.is_finite() { ratio } else { 0.0 }
    }
}

/// Factor of a row that is so many standard deviations off.
fn row_weight(ratio: f32) -> f32 {
    if ratio > FULL_WEIGHT {
        sqrt(FULL_WEIGHT / ratio)
    } else {
        1.0
    }
}
