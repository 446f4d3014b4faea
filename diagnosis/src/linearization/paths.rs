//! Which way the segments went, where what they remember of it hides it: over micrometres more than one way can give the same readings,
//! and a fixed point stops at the first that does. Several are told from different starts; stretch by stretch the one is kept that the
//! redundant readings agree with.

use crate::algebra::statistics::median;
use crate::inference::residuals::Residuals;
use crate::linearization::recording::{LinearizedRecording, PathEstimator};
use effects::sensor::CHANNELS;

/// Ways are told by all readings together and by each segment's own, at their noise and above.
const PATH_ESTIMATORS: [PathEstimator; 4] = [
    PathEstimator {
        own: false,
        louder: 1.0,
    },
    PathEstimator {
        own: true,
        louder: 1.0,
    },
    PathEstimator {
        own: false,
        louder: 3.0,
    },
    PathEstimator {
        own: true,
        louder: 3.0,
    },
];
/// Squares over the noise by which another way than the first must be the better one on a stretch. Derived from chi-square with
/// four degrees of freedom, what four segments bring along: the best of four starts is beyond 30 by chance once in 50,000
/// stretches.
const BETTER_PATH_SQUARES: f64 = 30.0;

/// The linearized recording with the ways that leave least, from what each way `settle`s at and what is `left` of the residual there. Cost: as many times
/// that of one as there are tellings.
pub fn likeliest<'a>(
    linearized: &LinearizedRecording<'a>,
    settle: impl Fn(LinearizedRecording<'a>) -> LinearizedRecording<'a>,
    left: impl Fn(&LinearizedRecording<'a>) -> Residuals,
) -> LinearizedRecording<'a> {
    let stretch = &linearized.observations.stretch;
    let paths =
        PATH_ESTIMATORS.map(|path_estimator| settle(linearized.with_paths_by(path_estimator)));
    let squares = paths.each_ref().map(|way| by_stretch(&left(way), stretch));
    let [mut out, others @ ..] = paths;
    for i in 0..out.len() {
        let of = |way: usize| squares[way].get(stretch[i]).copied().unwrap_or(0.0);
        let best = (1..PATH_ESTIMATORS.len()).min_by(|a, b| of(*a).total_cmp(&of(*b)));
        if let Some(way) = best.filter(|way| of(*way) + BETTER_PATH_SQUARES < of(0)) {
            out.take_way(&others[way - 1], i);
        }
    }
    out
}

/// Squares over the noise by stretch. A channel's zero is arbitrary, and where some stretches go wrong their mean is wrong for all: it is
/// taken from the median.
fn by_stretch(left: &Residuals, stretch: &[usize]) -> Vec<f64> {
    let in_noise = |k: usize| left.value_m[k] / left.noise_m[k].max(f64::MIN_POSITIVE);
    let rows = 0..left.sample.len();
    let zeros: [f64; CHANNELS] = std::array::from_fn(|channel| {
        let of_it = rows.clone().filter(|k| left.channel[*k] == channel);
        median(&mut of_it.map(in_noise).collect::<Vec<_>>()).unwrap_or(0.0)
    });
    let mut sums = vec![0.0; stretch.last().map_or(0, |last| last + 1)];
    for k in rows {
        sums[stretch[left.sample[k]]] += (in_noise(k) - zeros[left.channel[k]]).powi(2);
    }
    sums
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A stretch that is off, and a zero that it has drawn along.
    #[test]
    fn a_stretch_that_is_off_does_not_speak_against_the_others() {
        let stretch: Vec<usize> = (0..300).map(|i| i / 100).collect();
        let off = |i: usize| if i < 100 { 6.0 } else { 0.0 };
        let left = Residuals {
            sample: (0..300).collect(),
            channel: vec![0; 300],
            value_m: (0..300).map(|i| off(i) - 2.0).collect(),
            noise_m: vec![1.0; 300],
            white: vec![0.0; 300],
        };
        assert_eq!(by_stretch(&left, &stretch), [3600.0, 0.0, 0.0]);
    }
}
