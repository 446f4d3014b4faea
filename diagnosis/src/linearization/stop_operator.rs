//! What a segment drags after it: a cable, a hose. It pulls back over millimetres of travel and then slides, so that the pull
//! remembers the way. Such a stop is the element of Prandtl's and Ishlinskii's hysteresis (Brokate and Sprekels 1996, chapter 2).

use crate::linearization::recording::LinearizedRecording;
use effects::sensor::Covariates;
use std::sync::Arc;

/// Travel after which it slides, m.
/// A prior: a cable's or a bearing's slack is some millimetres.
pub const SLACKS_M: [f64; 3] = [1.0e-3, 2.5e-3, 6.0e-3];

/// Pulls on the four segments at each sample, in parts of the largest: -1 to 1 for each of [`SLACKS_M`].
#[derive(Clone)]
pub struct StopOperator {
    t_s: Arc<Vec<f64>>,
    pulls: Arc<[Vec<[f64; SLACKS_M.len()]>; 4]>,
}

impl StopOperator {
    /// Along the segments' calibrated places; between stretches the way is taken to be straight. Linear in samples.
    pub fn of(linearized: &LinearizedRecording) -> Self {
        let o = linearized.observations;
        let start_s = o.t_s.first().copied().unwrap_or(0.0);
        Self {
            t_s: Arc::new(o.t_s.iter().map(|t_s| t_s - start_s).collect()),
            pulls: Arc::new(
                linearized
                    .calibrated_m
                    .each_ref()
                    .map(|place_m| pulls(place_m)),
            ),
        }
    }

    /// The pull on a segment at a moment of that recording; logarithmic in samples.
    pub fn at(&self, m: &Covariates, segment: usize, stop: usize) -> f64 {
        let sample = self.t_s.partition_point(|t_s| *t_s < m.t_s);
        self.pulls[segment].get(sample).map_or(0.0, |p| p[stop])
    }
}

fn pulls(place_m: &[f64]) -> Vec<[f64; SLACKS_M.len()]> {
    let mut pull = [0.0; SLACKS_M.len()];
    let steps_m = place_m.windows(2).map(|pair| pair[1] - pair[0]);
    let steps_m = std::iter::once(0.0).chain(steps_m);
    steps_m
        .take(place_m.len())
        .map(|step_m| {
            for (pull, slack_m) in pull.iter_mut().zip(SLACKS_M) {
                if step_m.is_finite() {
                    *pull = (*pull + step_m / slack_m).clamp(-1.0, 1.0);
                }
            }
            pull
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    /// 4 mm there and 1 mm back: the shortest slides both ways, the longest has only been stretched.
    #[test]
    fn a_pull_slides_and_turns_over() {
        let estimate = pulls(&[0.0, 4.0e-3, 3.0e-3]);
        let there = [1.0, 1.0, 2.0 / 3.0];
        let back = [0.0, 0.6, 0.5];
        for (estimate, want) in estimate[1..]
            .iter()
            .flatten()
            .zip([there, back].into_iter().flatten())
        {
            assert!((estimate - want).abs() < 1.0e-12, "{estimate} for {want}");
        }
    }
}
