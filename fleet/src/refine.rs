//! The aperture once more, by the poses themselves, where fields were too large for halved splines.
//!
//! Splines a pitch apart tell an aperture by how the field's coefficients go together, which chance decides where there are few teeth: widths are some
//! percent off. How readings change between the teeth tells it to a tenth of that. The logarithm of an aperture's evidence is that of the
//! sums under it, with all other unknowns integrated out ([`crate::solve::Solution::log_evidence`]): it is formed at the aperture of the
//! state and at two neighbours of each coordinate, one after the other, as the sums of one state each. A parabola through three of them tells
//! the next value (Newton's step), and the fields are fitted again. This is done until no coordinate asks for a step that counts.

use crate::form::{Aperture, EDGE, HALF_PITCHES, spread};
use serde::{Deserialize, Serialize};
use tooth_field::{ApertureKernel, Lattice};

/// Distance of the neighbours: of the logarithm of a spread and of the edge. Derived from what the readings' weights bear: a width that is
/// wrong by a hundredth leaves 30 nm of a field of 3 µm, within what is left of most poses, while a straight line still holds.
const APART: [f64; COORDINATES] = [0.01, 0.01, 0.02];
/// Longest step of a coordinate, in [`APART`]. Derived from it: five times as far as the parabola was looked at.
const LONGEST: f64 = 5.0;
/// A step counts if the parabola promises more than this of the logarithm. Derived from the coordinate's own deviation: it is half of that away.
const COUNTS: f64 = 0.125;
/// Steps, at most. A bound on the work: an eighth, which splines were seen to be off by, takes three.
const ROUNDS: u32 = 8;
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

/// An aperture whose neighbours are looked at.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Round {
    /// The aperture between the neighbours.
    centre: Aperture,
    /// Logarithm of its evidence, and of those of its neighbours so far.
    told: Vec<f64>,
}

/// What comes next.
#[derive(Clone, Debug, PartialEq)]
pub enum Next {
    /// Sums under this aperture.
    Look(Round, Aperture),
    /// Fields under this aperture.
    Move(Aperture),
    /// This one stays.
    Stay(Aperture),
}

/// Begins with an aperture under which the fields have settled. `rounds` have been before.
pub fn begun(centre: &Aperture, log_evidence: f64, rounds: u32) -> Next {
    let within = with_neighbours(centre);
    if within.kernel.edge != centre.kernel.edge {
        return Next::Move(within);
    }
    let round = Round {
        centre: *centre,
        told: Vec::new(),
    };
    round.told(log_evidence, rounds)
}

impl Round {
    /// Takes the evidence of the aperture that was looked at last. `rounds` have been before.
    pub fn told(mut self, log_evidence: f64, rounds: u32) -> Next {
        let looked = self.told.len();
        self.told.push(log_evidence);
        if looked < 2 * COORDINATES {
            let mut by = [0.0; COORDINATES];
            by[looked / 2] = [-1.0, 1.0][looked % 2] * APART[looked / 2];
            let neighbour = moved(&self.centre, by);
            return Next::Look(self, neighbour);
        }
        let steps: [Option<f64>; COORDINATES] = std::array::from_fn(|k| self.step(k));
        if rounds >= ROUNDS || steps.iter().all(Option::is_none) {
            return Next::Stay(self.centre);
        }
        let steps = steps.map(Option::unwrap_or_default);
        Next::Move(with_neighbours(&moved(&self.centre, steps)))
    }

    /// The step of a coordinate, if it counts.
    fn step(&self, k: usize) -> Option<f64> {
        let [middle, below, above] = [self.told[0], self.told[1 + 2 * k], self.told[2 + 2 * k]];
        let slope = 0.5 * (above - below) / APART[k];
        let curvature = (above - 2.0 * middle + below) / APART[k].powi(2);
        let longest = LONGEST * APART[k];
        let step = if curvature < 0.0 {
            (-slope / curvature).clamp(-longest, longest)
        } else {
            longest * slope.signum()
        };
        // At a bound there is no room for it.
        let mut by = [0.0; COORDINATES];
        by[k] = step;
        let beyond = with_neighbours(&moved(&self.centre, by));
        let has_room = coordinate(&beyond, k) != coordinate(&self.centre, k);
        (has_room && 0.5 * slope * step > COUNTS).then_some(step)
    }
}

/// A coordinate, up to what is monotonic.
fn coordinate(aperture: &Aperture, k: usize) -> f64 {
    let [along, across] = aperture.kernel.half_pitches;
    [along, across, aperture.kernel.edge][k]
}

/// The nearest aperture whose neighbours are within the edge's bounds.
fn with_neighbours(aperture: &Aperture) -> Aperture {
    let edge = aperture.kernel.edge;
    let within = edge.clamp(EDGE[0] + APART[2], EDGE[1] - APART[2]);
    moved(aperture, [0.0, 0.0, within - edge])
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

    fn aperture(half_pitches: [f64; 2], edge: f64) -> Aperture {
        Aperture {
            kernel: ApertureKernel { half_pitches, edge },
            deviations_m: [8.0e-6, 6.0e-6],
        }
    }

    /// Refined by an evidence whose coordinates have these deviations about a truth.
    fn refined(start: Aperture, truth: &Aperture, deviations: [f64; 3]) -> Aperture {
        let spreads =
            |a: &Aperture, k: usize| (a.kernel.half_pitches[k] * spread(a.kernel.edge)).ln();
        let off = |a: &Aperture| {
            let edge = a.kernel.edge - truth.kernel.edge;
            [
                spreads(a, 0) - spreads(truth, 0),
                spreads(a, 1) - spreads(truth, 1),
                edge,
            ]
        };
        let evidence = |a: &Aperture| {
            let each = off(a).into_iter().zip(deviations);
            -0.5 * each.map(|(off, d)| (off / d).powi(2)).sum::<f64>()
        };
        let (mut at, mut rounds) = (start, 0);
        let mut next = begun(&at, evidence(&at), rounds);
        loop {
            next = match next {
                Next::Look(round, neighbour) => round.told(evidence(&neighbour), rounds),
                Next::Move(aperture) => {
                    (at, rounds) = (aperture, rounds + 1);
                    begun(&at, evidence(&at), rounds)
                }
                Next::Stay(aperture) => return aperture,
            };
        }
    }

    /// From an eighth off, each coordinate comes within half its deviation, and the field keeps its size.
    #[test]
    fn an_aperture_is_refined_to_the_best_one() {
        let start = aperture([3.4, 2.9], 0.7);
        let truth = aperture([3.02, 3.1], 0.93);
        let found = refined(start, &truth, [0.003, 0.014, 0.05]);
        let off = found.kernel.edge - truth.kernel.edge;
        assert!(off.abs() < 0.025, "{found:?}");
        for k in 0..2 {
            let ratio = coordinate(&found, k) / coordinate(&truth, k);
            assert!((ratio - 1.0).abs() < 0.02, "{found:?}");
        }
        let size =
            |a: &Aperture| a.deviations_m[0] * Lattice::of_teeth(a.kernel).deviation_by_nodes();
        assert!((size(&found) / size(&start) - 1.0).abs() < 1e-9);
    }

    /// Where the best edge is beyond the bounds, the search ends at them.
    #[test]
    fn an_edge_stays_within_its_bounds() {
        let truth = aperture([3.0, 3.0], 1.3);
        let found = refined(aperture([3.0, 3.0], 1.0), &truth, [0.003, 0.003, 0.01]);
        assert_eq!(found.kernel.edge, EDGE[1] - APART[2]);
    }
}
