//! Apertures beside one: a little wider or narrower, or with other edges, and with fields of the same size.

use crate::form::{Aperture, EDGE, HALF_PITCHES, spread};
use tooth_field::{ApertureKernel, Lattice};

/// Distance of the neighbours: of the logarithm of a spread and of the edge. Derived from what the readings' weights bear: a width that is
/// wrong by a hundredth leaves 30 nm of a field of 3 µm, within what is left of most poses, while a straight line still holds.
const APART: [f64; COORDINATES] = [0.01, 0.01, 0.02];
/// By definition: logarithms of both spreads, and the edge.
pub(crate) const COORDINATES: usize = 3;

/// An aperture's neighbours below and above along each coordinate, and how far these two are apart.
pub(crate) fn neighbours(centre: &Aperture) -> [([Aperture; 2], f64); COORDINATES] {
    std::array::from_fn(|k| {
        let one = |way: f64| {
            let mut by = [0.0; COORDINATES];
            by[k] = way * APART[k];
            moved(centre, by)
        };
        ([one(-1.0), one(1.0)], 2.0 * APART[k])
    })
}

/// An aperture with its coordinates moved as far as their bounds, and with fields of the same size.
fn moved(aperture: &Aperture, by: [f64; COORDINATES]) -> Aperture {
    let before = aperture.kernel;
    let edge = (before.edge + by[2]).clamp(EDGE[0], EDGE[1]);
    let half = |k: usize| {
        let spread = by[k].exp() * spread(before.edge) / spread(edge);
        (before.half_pitches[k] * spread).clamp(HALF_PITCHES[0], HALF_PITCHES[1])
    };
    let kernel = ApertureKernel {
        half_pitches: [half(0), half(1)],
        edge,
    };
    let [old, new] = [before, kernel].map(Lattice::of_teeth);
    let [node_m, line_m] = aperture.deviations_m;
    Aperture {
        kernel,
        deviations_m: [
            node_m * old.deviation_by_nodes() / new.deviation_by_nodes(),
            line_m * old.deviation_by_lines() / new.deviation_by_lines(),
        ],
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Neighbours are as far away as is said, and their fields are as large.
    #[test]
    fn neighbours_have_fields_of_the_same_size() {
        let centre = Aperture {
            kernel: ApertureKernel {
                half_pitches: [3.4, 2.9],
                edge: 0.7,
            },
            deviations_m: [8.0e-6, 6.0e-6],
        };
        let size =
            |a: &Aperture| a.deviations_m[0] * Lattice::of_teeth(a.kernel).deviation_by_nodes();
        let spreads = |a: &Aperture| {
            let log = |k: usize| (a.kernel.half_pitches[k] * spread(a.kernel.edge)).ln();
            [log(0), log(1), a.kernel.edge]
        };
        for (k, (both, apart)) in neighbours(&centre).into_iter().enumerate() {
            let [below, above] = both.each_ref().map(spreads);
            for other in 0..COORDINATES {
                let wanted = if other == k { apart } else { 0.0 };
                assert!((above[other] - below[other] - wanted).abs() < 1e-12, "{k}");
            }
            for neighbour in &both {
                assert!((size(neighbour) / size(&centre) - 1.0).abs() < 1e-9);
            }
        }
    }
}
