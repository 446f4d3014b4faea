//! Bursts: short disturbances that stand out of what a model leaves.

use super::fitted_effects::FittedEffects;
use crate::data::outliers::{among_bursts, astray, disturbed};
use crate::data::recurring::{at_the_ends, recurs};
use crate::inference::residuals::Residuals;
use crate::linearization::recording::LinearizedRecording;
use crate::verdict::answer::{Magnitude, Named};
use effects::Detection;

/// Samples that must be judged otherwise than before for all to be fitted anew.
/// By definition: as many as make a burst.
const CHANGED_SAMPLES: usize = LEAST_BURSTS.0;

/// Disturbed samples.
#[derive(Default)]
pub(super) struct Bursts {
    pub(super) count: usize,
    /// Whitened squares by the stated noise, as those of the gap are.
    pub(super) energy: f64,
    /// The same by the noise as it was found: how far they stand out.
    beyond_noise: f64,
    largest_m: f64,
    /// Squares beyond the noise over all rows, m², and the variance that the noise gives them, m⁴.
    squares_m2: f64,
    squares_variance_m4: f64,
    /// Noise of the largest one, m.
    largest_noise_m: f64,
    rows: usize,
    /// They come back where they were: on the diode, on the platen, or at the ends of the angle's range.
    pub(super) recur: bool,
}

/// Disturbed samples that make a burst, and their whitened squares beyond the noise.
/// By definition: three samples of ten times the noise.
const LEAST_BURSTS: (usize, f64) = (3, 300.0);
/// Disturbed samples speak of bursts if they hold this share of what is left of the others, and of the whole gap where what is left shows: a
/// shape stands out here and there as well. Without data.
pub(super) const BURST_SHARE: f64 = 0.05;
/// Bursts are told if they are this share of the whole gap, 7 % of its rms. Without data.
const LEAST_BURST_SHARE: f64 = 0.005;
/// No shape stands out of its neighbours by so many times what is left. Without data.
const FAR_OUTLIER_RATIO: f64 = 10.0;

/// What is left beside bursts and is no noise.
pub(super) struct Left {
    /// Whitened squares beyond the noise.
    pub(super) squares: f64,
    /// Mean of the whitened squares, noise and all.
    pub(super) level: f64,
    /// It would be a gap by itself.
    pub(super) shows: bool,
}

impl Bursts {
    /// True if they are bursts, with more than this many whitened squares by the stated noise.
    pub(super) fn hold(&self, squares: f64) -> bool {
        let (count, least) = LEAST_BURSTS;
        let stand_out = self.count >= count && self.beyond_noise > least;
        stand_out && self.energy > squares && !self.recur
    }

    /// The squares that bursts must hold beside what is left and is no noise: this share of it and, of the whole gap, as much where that
    /// shows, or a trifle where nothing does. A shape without a name stands out of its neighbours here and there as well, but not so far.
    pub(super) fn least_squares(&self, left: &Left, whole: f64, share: f64) -> f64 {
        let far =
            self.energy > FAR_OUTLIER_RATIO * FAR_OUTLIER_RATIO * left.level * self.count as f64;
        let of_whole = if left.squares > 0.0 && left.shows && !far {
            share
        } else {
            LEAST_BURST_SHARE
        };
        (share * left.squares).max(of_whole * whole)
    }

    /// True if there are too few for bursts.
    pub(super) fn are_few(&self) -> bool {
        self.count < LEAST_BURSTS.0
    }

    /// As they are told. `birge_ratio` is by how much the noise is louder than it was taken to be.
    pub(super) fn named(&self, share: f64, birge_ratio: f64) -> Named {
        let rows = self.rows.max(1) as f64;
        let total_m = (self.squares_m2 / rows).sqrt();
        let spread_m = 0.5 * birge_ratio * self.squares_variance_m4.sqrt() / rows;
        Named {
            name: effects::name_of(Detection::AsBursts).into(),
            total_rms_m: Some(total_m),
            total_deviation_m: Some(spread_m / total_m.max(f64::MIN_POSITIVE)),
            magnitude: vec![
                Magnitude {
                    name: "disturbed samples".into(),
                    value: self.count as f64,
                    deviation: Some(0.0),
                    unit: "samples".into(),
                },
                Magnitude {
                    name: "largest".into(),
                    value: self.largest_m,
                    deviation: Some(birge_ratio * self.largest_noise_m),
                    unit: "m".into(),
                },
            ],
            share: share.clamp(0.0, 1.0),
            ..Named::default()
        }
    }
}

impl FittedEffects<'_> {
    /// What is left at every sample, those included that were left out of the fit.
    fn everywhere(&self) -> Residuals {
        let relinearized = &self.relinearized;
        let list: Vec<usize> = (0..relinearized.coefficients.len()).collect();
        let amounts = |_: usize| &relinearized.coefficients;
        Residuals::predicted(
            &relinearized.linearized,
            &relinearized.columns,
            &relinearized.gram,
            &list,
            amounts,
            true,
        )
    }

    /// Samples that stand out of what is left around them.
    fn outliers(&self, left: &Residuals) -> Vec<bool> {
        let linearized = &self.relinearized.linearized;
        let mut rows = left.white_rows();
        rows.extend(linearized.amplitude_rows());
        let mut marked = disturbed(&rows, linearized.len(), &linearized.observations.stretch);
        let astray = astray(&rows, linearized.observations);
        // About a turn a direction that is told some samples late leaves twice what it does there: no burst.
        let directed = self
            .names()
            .iter()
            .any(|n| effects::has(n, |card| card.remembers));
        let turning = |i: usize| {
            let mut segments = linearized.motion.turning.iter();
            directed && segments.any(|s| s.get(i).is_some_and(|t| *t))
        };
        for (i, mark) in marked.iter_mut().enumerate() {
            *mark |= astray[i];
            *mark &= !self.prepared.thinned[i] && !self.prepared.stuck[i] && !turning(i);
        }
        marked
    }

    /// Samples that stand out of what is left where there are bursts.
    fn among_bursts(&self, left: &Residuals) -> Vec<bool> {
        let linearized = &self.relinearized.linearized;
        let o = linearized.observations;
        let mut rows = left.white_rows();
        rows.extend(linearized.amplitude_rows());
        among_bursts(&rows, &o.stretch, &o.run)
    }

    /// What is left without single poses that stand out: where bursts are named, `check` sets those aside as well.
    pub(super) fn without_bursts(&self, left: &Residuals) -> Residuals {
        let marked = self.among_bursts(left);
        left.only(|k| !marked[left.sample[k]])
    }

    /// Samples in use, where what was found shows others to be disturbed than the baseline alone did: a pattern stands out of
    /// its neighbours as a disturbance does, and hides one.
    ///
    /// Where stretches show bursts, single poses are disturbed as well: one that stands out of its run is no gap.
    pub(super) fn revised_mask(&self) -> Option<Vec<bool>> {
        let all = self.everywhere();
        let mut marked = self.outliers(&all);
        let left = all.white.iter().zip(&all.sample);
        let left: f64 = left
            .filter(|(_, i)| !marked[**i])
            .map(|(w, _)| w * w - 1.0)
            .sum();
        if self.bursts().hold(BURST_SHARE * left) {
            let poses = self.among_bursts(&all);
            marked.iter_mut().zip(&poses).for_each(|(m, p)| *m |= p);
        }
        let prepared = self.prepared;
        let mask: Vec<bool> = (0..marked.len())
            .map(|i| !marked[i] && prepared.usable(i))
            .collect();
        let changed = mask.iter().zip(&prepared.mask).filter(|(a, b)| a != b);
        (changed.count() >= CHANGED_SAMPLES).then_some(mask)
    }

    /// Samples that stand out of what the model leaves around them.
    pub(super) fn bursts(&self) -> Bursts {
        let mut out = Bursts::default();
        let all = self.everywhere();
        let stated = self.by_stated_noise(&all);
        let marked = self.outliers(&all);
        let mut last = usize::MAX;
        out.rows = all.sample.len();
        for k in 0..all.sample.len() {
            let i = all.sample[k];
            let (value_m, noise_m) = (all.value_m[k].abs(), all.noise_m[k]);
            if marked[i] {
                out.energy += (stated.white[k].powi(2) - 1.0).max(0.0);
                out.beyond_noise += (all.white[k].powi(2) - 1.0).max(0.0);
                if value_m > out.largest_m {
                    (out.largest_m, out.largest_noise_m) = (value_m, noise_m);
                }
                out.squares_m2 += (value_m * value_m - noise_m * noise_m).max(0.0);
                out.squares_variance_m4 += (2.0 * value_m * noise_m).powi(2);
                if i != last {
                    out.count += 1;
                    last = i;
                }
            }
        }
        let linearized = &self.relinearized.linearized;
        let seen = |i: usize| [0, 1].map(|axis| deflection(linearized, axis, i));
        let on_diode: Vec<[f64; 2]> = (0..linearized.len()).map(seen).collect();
        let on_platen: Vec<[f64; 2]> = (0..linearized.len())
            .map(|i| linearized.centre_m(i))
            .collect();
        let angle = &linearized.observations.commanded[2];
        out.recur = out.count > 0
            && (recurs(&marked, &on_diode)
                || recurs(&marked, &on_platen)
                || at_the_ends(&marked, angle));
        out
    }
}

fn deflection(linearized: &LinearizedRecording, axis: usize, i: usize) -> f64 {
    let tan = linearized.observations.tan_psi[axis].get(i);
    tan.copied().unwrap_or(f64::NAN)
}
