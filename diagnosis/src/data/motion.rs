//! Speeds, directions and rates from the readings themselves: what a run is called tells nothing.

use crate::algebra::statistics::quantile;
use crate::data::local_fit::{QuadraticFit, local};
use crate::data::observations::Observations;
use crate::data::play_operator::PlayOperator;
use crate::data::spot::{SpotState, rates};
use effects::sensor::TURNOVERS;
use rayon::prelude::*;
use std::ops::Range;

/// Half the number of neighbours in a local fit. Derived from the parabola's three unknowns: of seven points four degrees of
/// freedom are left for the scatter, and at the sampling intervals that recordings have (1 to 2 ms) the window stays below 15 ms,
/// in which a motion of tens of hertz is a parabola.
const PATH_HALF_WINDOW: usize = 3;
/// A local quadratic must fit within this and a share of what was travelled, or the samples are separate poses, m. A prior: the
/// periodic errors of an uncalibrated segment, some 16 µm of order 1 in the simulated courier, are still a smooth path over seven
/// samples of a slow run, and separate poses lie a whole tooth and more apart.
pub(crate) const SMOOTH_M: f64 = 15.0e-6;
/// See [`SMOOTH_M`].
const SMOOTH_SHARE: f64 = 0.02;
/// Share of the path that [`Motion::loud_m`] is of. A definition: the upper tenth is what disturbances and starts are in.
const LOUD: f64 = 0.9;
/// Share of the path that [`Motion::quiet_m`] is of. A definition: the lower tenth is free of them.
const QUIET: f64 = 0.1;

/// Motion of the segments and of the spot on the coordination sensor, one value a sample.
#[derive(Clone, Debug, Default)]
pub struct Motion {
    /// Speed of each segment's output, m/s; zero at separate poses.
    pub speed_m_s: [Vec<f64>; 4],
    /// Its derivative, m/s².
    pub acceleration_m_s2: [Vec<f64>; 4],
    /// -1, 0 or 1 while moving.
    pub direction: [Vec<f64>; 4],
    /// Where a segment does not move: the direction in which it last did.
    pub approach: [Vec<f64>; 4],
    /// Direction of travel that turns over with it: see [`crate::data::play_operator::PlayOperator::memory`].
    pub memory: [Vec<[f64; TURNOVERS]>; 4],
    /// What is left of the memory that each segment began with: see [`crate::data::play_operator::PlayOperator::before`].
    pub before: [Vec<f64>; 4],
    /// True about a turn, where which way it goes is told to a few samples only.
    pub turning: [Vec<bool>; 4],
    /// Rates of tan(psi), 1/s; not finite where there is none.
    pub tan_psi_rate: [Vec<f64>; 2],
    /// 99th percentile of each segment's speed, m/s.
    pub top_speed_m_s: [f64; 4],
    /// True where the samples follow a smooth path.
    pub smooth: Vec<bool>,
    /// True where the courier is on its way: on a path on most of which a segment moves, its slow ends included.
    pub underway: Vec<bool>,
    /// Each segment's scatter about its own smooth path (median over the path), m; zero where there is none. Nothing but noise
    /// and what changes within some samples is in it.
    pub scatter_m: [f64; 4],
    /// What the scatter of a segment stays below on nine tenths of its path, m.
    pub loud_m: [f64; 4],
    /// What it stays above on nine tenths, m: noise alone, also of a courier that is shaken on most of its way.
    pub quiet_m: [f64; 4],
    /// The same of tan(psi).
    pub loud_tan_psi: [f64; 2],
}

/// Rms misfit of seven points about a parabola, median over the path, for unit noise. Derived from chi-square: root of its median
/// with four degrees of freedom over seven.
pub const MISFIT: f64 = 0.6925;
/// The same for nine tenths of the path: by the 90 % point of that distribution of chi-square.
pub const LOUD_MISFIT: f64 = 1.0543;
/// The same for one tenth: by the 10 % point of that distribution of chi-square.
const QUIET_MISFIT: f64 = 0.3898;

impl Motion {
    /// From calibrated segment positions (empty where a segment is absent), metres. Linear in samples.
    /// Where there is a reference the caller gives its positions: they carry no error pattern.
    pub fn new(observations: &Observations, position_m: &[Vec<f64>; 4]) -> Self {
        let n = observations.len();
        let windows = windows(&observations.unbroken);
        let mut this = Self {
            smooth: vec![true; n],
            ..Self::default()
        };
        let mut fits: Vec<Vec<QuadraticFit>> = Vec::new();
        for position in position_m {
            let fit: Vec<QuadraticFit> = if position.is_empty() {
                Vec::new()
            } else {
                let at = |(i, w): (usize, &Range<usize>)| {
                    local(&observations.t_s, position, i, w.clone())
                };
                windows.par_iter().enumerate().map(at).collect()
            };
            for (i, local) in fit.iter().enumerate() {
                this.smooth[i] &= local.residual < SMOOTH_M + SMOOTH_SHARE * local.travel;
            }
            fits.push(fit);
        }
        for segment in 0..4 {
            this.fill_segment(segment, &fits[segment], &position_m[segment], observations);
        }
        this.underway = this.on_its_way(&observations.unbroken);
        for axis in 0..2 {
            let tan = &observations.tan_psi[axis];
            let mut scatter = Vec::new();
            this.tan_psi_rate[axis] = tan
                .iter()
                .enumerate()
                .map(|(i, _)| {
                    let fit = local(&observations.t_s, tan, i, windows[i].clone());
                    if !this.smooth[i] || !fit.residual.is_finite() {
                        return f64::NAN;
                    }
                    scatter.push(fit.residual);
                    fit.slope
                })
                .collect();
            this.loud_tan_psi[axis] = quantile(&mut scatter, LOUD).unwrap_or(0.0);
        }
        this.tan_psi_rate = this.spot_rates(&fits, position_m, observations);
        this
    }

    /// See [`Self::underway`].
    fn on_its_way(&self, unbroken: &[usize]) -> Vec<bool> {
        let moves = |i: usize| {
            let mut directions = self.direction.iter().map(|d| d.get(i));
            directions.any(|d| d.is_some_and(|d| *d != 0.0))
        };
        let samples: Vec<usize> = (0..self.smooth.len()).collect();
        let path = |a: &usize, b: &usize| {
            unbroken[*a] == unbroken[*b] && self.smooth[*a] == self.smooth[*b]
        };
        let mut out = Vec::with_capacity(samples.len());
        for path in samples.chunk_by(path) {
            let moving = path.iter().filter(|i| moves(**i)).count();
            let most = 2 * moving > path.len();
            out.extend(path.iter().map(|i| most || moves(*i)));
        }
        out
    }

    /// Rates of tan(psi) as the platen sensor tells them where it is whole, else its own slopes.
    fn spot_rates(
        &self,
        fits: &[Vec<QuadraticFit>],
        position_m: &[Vec<f64>; 4],
        observations: &Observations,
    ) -> [Vec<f64>; 2] {
        let n = observations.len();
        let whole = fits.iter().all(|fit| fit.len() == n);
        let smooth = |i: usize, value: f64| if self.smooth[i] { value } else { f64::NAN };
        let way = |i: usize| SpotState {
            speed_m_s: std::array::from_fn(|s| smooth(i, fits[s][i].slope)),
            place_m: std::array::from_fn(|s| position_m[s][i]),
            tan_psi: [0, 1].map(|axis| observations.tan_psi[axis][i]),
        };
        if !whole || self.tan_psi_rate.iter().any(|own| own.len() != n) {
            return self.tan_psi_rate.clone();
        }
        let ways: Vec<SpotState> = (0..n).map(way).collect();
        self.tan_psi_rate
            .each_ref()
            .map(|own| rates(&ways, own).unwrap_or_else(|| own.clone()))
    }

    fn fill_segment(
        &mut self,
        segment: usize,
        fit: &[QuadraticFit],
        position: &[f64],
        observations: &Observations,
    ) {
        let n = fit.len();
        let smooth = &self.smooth;
        // What the noise alone could show is no speed: else a reading's own noise would pass for a cause.
        let clear = |value: f64, noise: f64, i: usize| {
            if smooth[i] && value.abs() > 5.0 * noise {
                value
            } else {
                0.0
            }
        };
        let speed: Vec<f64> = (0..n)
            .map(|i| clear(fit[i].slope, fit[i].slope_noise, i))
            .collect();
        let mut magnitudes: Vec<f64> = speed.iter().map(|v| v.abs()).filter(|v| *v > 0.0).collect();
        let top = quantile(&mut magnitudes, 0.99).unwrap_or(0.0);
        self.top_speed_m_s[segment] = top;
        let mut scatter: Vec<f64> = (0..n)
            .filter(|i| smooth[*i])
            .map(|i| fit[i].residual)
            .collect();
        let scatter_m = crate::algebra::statistics::median(&mut scatter).unwrap_or(0.0);
        self.scatter_m[segment] = scatter_m;
        self.loud_m[segment] = quantile(&mut scatter, LOUD).unwrap_or(0.0);
        self.quiet_m[segment] = quantile(&mut scatter, QUIET).unwrap_or(0.0);
        self.direction[segment] = (0..n)
            .map(|i| {
                let estimate = (5.0 * fit[i].slope_noise).max(0.02 * top);
                if smooth[i] && speed[i].abs() > estimate {
                    speed[i].signum()
                } else {
                    0.0
                }
            })
            .collect();
        self.acceleration_m_s2[segment] = (0..n)
            .map(|i| clear(fit[i].curvature, fit[i].curvature_noise, i))
            .collect();
        self.speed_m_s[segment] = speed;
        let travel = self.retraced(segment, position, 1.0, observations);
        self.follow(segment, travel);
    }

    /// What the way of a segment leaves in its memory, from positions that are known better by now: an effect of some
    /// micrometres hides ways of as many. `louder` is their noise over the segment's own. Linear in samples.
    pub fn retraced(
        &self,
        segment: usize,
        position_m: &[f64],
        louder: f64,
        observations: &Observations,
    ) -> PlayOperator {
        let noise = observations.position_noise_m[segment].iter().copied();
        let stated_m = crate::algebra::statistics::rms(noise.filter(|n| n.is_finite()));
        let noise_m = louder * stated_m.max(self.quiet_m[segment] / QUIET_MISFIT);
        PlayOperator::new(position_m, &self.smooth, MISFIT * noise_m, observations)
    }

    /// Takes over a segment's way as it is known by now.
    pub fn follow(&mut self, segment: usize, travel: PlayOperator) {
        self.memory[segment] = travel.memory;
        self.before[segment] = travel.before;
        self.turning[segment] = travel.turning;
        self.approach[segment] = travel.direction;
        for (approach, direction) in self.approach[segment]
            .iter_mut()
            .zip(&self.direction[segment])
        {
            if *direction != 0.0 {
                *approach = 0.0;
            }
        }
    }

    /// Takes over what another motion's segments remember at a sample.
    pub fn take_way(&mut self, other: &Self, i: usize) {
        fn take<T: Copy>(own: &mut [Vec<T>; 4], other: &[Vec<T>; 4], i: usize) {
            for (own, other) in own.iter_mut().zip(other) {
                if let (Some(own), Some(other)) = (own.get_mut(i), other.get(i)) {
                    *own = *other;
                }
            }
        }
        take(&mut self.memory, &other.memory, i);
        take(&mut self.before, &other.before, i);
        take(&mut self.turning, &other.turning, i);
        take(&mut self.approach, &other.approach, i);
    }
}

/// Neighbours of each sample without a break.
fn windows(unbroken: &[usize]) -> Vec<Range<usize>> {
    let n = unbroken.len();
    (0..n)
        .map(|i| {
            let mut first = i;
            while first > 0 && i - first < PATH_HALF_WINDOW && unbroken[first - 1] == unbroken[i] {
                first -= 1;
            }
            let mut end = i + 1;
            while end < n && end - i <= PATH_HALF_WINDOW && unbroken[end] == unbroken[i] {
                end += 1;
            }
            first..end
        })
        .collect()
}
