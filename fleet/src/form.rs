//! The form of an aperture and its bounds.

use serde::{Deserialize, Serialize};
use tooth_field::ApertureKernel;

/// Bounds of half an aperture, pitches. A prior: a reading averages over one tooth to a dozen, as the diagnosis takes it to.
pub const HALF_PITCHES: [f64; 2] = [0.6, 6.0];
/// Bounds of its edge. By definition 1 is a bell; a prior keeps it from 0, a box whose weights jump, which no place is known well enough for.
pub const EDGE: [f64; 2] = [0.1, 1.0];

/// How the segments of a make read teeth.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Aperture {
    /// What a reading averages over.
    pub kernel: ApertureKernel,
    /// Deviation of a tooth by itself and of a whole line before the data, m.
    pub deviations_m: [f64; 2],
}

/// Spread of an aperture over half its width. A box with smooth edges is a box to the middles of these, blurred by the slope of an edge: a parabola, whose
/// second moment is a twentieth of its length's square.
pub fn spread(edge: f64) -> f64 {
    ((1.0 - 0.5 * edge).powi(2) / 3.0 + edge * edge / 20.0).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use tooth_field::Kernel;

    /// Spread of a kernel by its definition.
    #[test]
    fn a_spread_is_the_root_of_the_second_moment() {
        for edge in [0.1, 0.5, 1.0] {
            let kernel = ApertureKernel {
                half_pitches: [3.0; 2],
                edge,
            };
            let places = (-3000..3000).map(|k| (f64::from(k) + 0.5) * 1.0e-3);
            let moment: f64 = places.map(|x| 1.0e-3 * x * x * kernel.weight(0, x)).sum();
            assert!(
                (moment.sqrt() - 3.0 * spread(edge)).abs() < 1.0e-5,
                "{edge}"
            );
        }
    }
}
