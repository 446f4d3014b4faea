//! How far the gap between a segment and the platen went, by its amplitude: what a model says of it beyond is extrapolated.

use crate::linearization::recording::LinearizedRecording;
use serde::{Deserialize, Serialize};

/// Share of the range that another recording may lie beyond it.
const AMPLITUDE_MARGIN: f64 = 0.05;

/// Lowest and highest logarithm of each segment's amplitude over its usual one.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct AmplitudeSupport {
    /// None where it was not measured or does not change.
    pub ln_amplitude: [Option<[f64; 2]>; 4],
}

impl AmplitudeSupport {
    /// Of the samples in use.
    pub fn of(linearized: &LinearizedRecording) -> Self {
        let mut all = [[f64::INFINITY, f64::NEG_INFINITY]; 4];
        for i in (0..linearized.len()).filter(|i| linearized.mask[*i]) {
            let here = linearized.covariates(i).ln_amplitude;
            for (range, here) in all.iter_mut().zip(here) {
                *range = [range[0].min(here), range[1].max(here)];
            }
        }
        let ln_amplitude = all.map(|[low, high]| (high > low).then_some([low, high]));
        Self { ln_amplitude }
    }

    /// True if a segment's amplitude lies beyond.
    pub fn is_beyond(&self, ln_amplitude: [f64; 4]) -> bool {
        let mut each = self.ln_amplitude.iter().zip(ln_amplitude);
        each.any(|(range, here)| {
            range.is_some_and(|[low, high]| {
                let margin = AMPLITUDE_MARGIN * (high - low);
                here < low - margin || here > high + margin
            })
        })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn beyond_is_past_the_margin_of_a_segment_that_was_measured() {
        let range = Some([-0.4, 0.6]);
        let reached = AmplitudeSupport {
            ln_amplitude: [range, None, range, range],
        };
        assert!(!reached.is_beyond([0.64, 9.0, -0.44, 0.0]));
        assert!(reached.is_beyond([0.0, 0.0, -0.46, 0.0]));
        assert!(reached.is_beyond([0.66, 0.0, 0.0, 0.0]));
    }
}
