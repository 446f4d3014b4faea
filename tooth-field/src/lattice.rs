//! Nodes of a field: which of them a reading is made of, and which ones a motion passed.

use crate::kernel::Kernel;
use std::collections::BTreeMap;

/// Nodes at even distances along and across the measured direction, counted from a place that is called zero. A node is given by its
/// numbers along and across, a line of nodes by its number along. Places are in pitches.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Lattice<K> {
    /// Weights of the nodes.
    pub kernel: K,
    /// Pitches from node to node along and across.
    pub step_pitches: [f64; 2],
}

impl<K: Kernel + Copy> Lattice<K> {
    /// A node at each tooth.
    pub const fn of_teeth(kernel: K) -> Self {
        Self {
            kernel,
            step_pitches: [1.0; 2],
        }
    }

    /// Numbers along a direction of the nodes under a place, ascending, and their weights.
    pub fn along(self, direction: usize, place: f64) -> impl Iterator<Item = (i32, f64)> + Clone {
        let (half, step) = (
            self.kernel.half_pitches(direction),
            self.step_pitches[direction],
        );
        let (first, last) = ((place - half) / step, (place + half) / step);
        let weight = move |k: i32| self.kernel.weight(direction, place - f64::from(k) * step);
        (first.ceil() as i32..=last.floor() as i32)
            .map(move |k| (k, weight(k)))
            .filter(|(_, weight)| *weight > 0.0)
    }

    /// Lines under a place, ascending, and their weights.
    pub fn lines(self, place: [f64; 2]) -> impl Iterator<Item = (i32, f64)> + Clone {
        self.along(0, place[0])
    }

    /// Nodes under a place and their weights; those across run fastest.
    pub fn nodes(self, place: [f64; 2]) -> impl Iterator<Item = ([i32; 2], f64)> + Clone {
        let [along, across] = [0, 1].map(|d| self.along(d, place[d]).collect::<Vec<_>>());
        (0..along.len() * across.len()).map(move |at| {
            let ((i, along), (j, across)) = (along[at / across.len()], across[at % across.len()]);
            ([i, j], along * across)
        })
    }

    /// Where a node is.
    pub fn place_of(&self, node: [i32; 2]) -> [f64; 2] {
        [0, 1].map(|d| f64::from(node[d]) * self.step_pitches[d])
    }

    /// Weight of one node at a place.
    pub fn weight(&self, node: [i32; 2], place: [f64; 2]) -> f64 {
        let at = self.place_of(node);
        let along = self.kernel.weight(0, place[0] - at[0]);
        if along == 0.0 {
            return 0.0;
        }
        along * self.kernel.weight(1, place[1] - at[1])
    }

    /// Weight of one line at a place.
    pub fn line_weight(&self, line: i32, place: [f64; 2]) -> f64 {
        let at = self.place_of([line, 0]);
        self.kernel.weight(0, place[0] - at[0])
    }

    /// Nodes that some places are read by, and the sum of their weights there.
    pub fn passed(&self, places: impl IntoIterator<Item = [f64; 2]>) -> BTreeMap<[i32; 2], f64> {
        let mut nodes = BTreeMap::new();
        for place in places {
            for (node, weight) in self.nodes(place) {
                *nodes.entry(node).or_default() += weight;
            }
        }
        nodes
    }

    /// Deviation of readings where independent nodes have unit deviation.
    pub fn deviation_by_nodes(&self) -> f64 {
        let squares = [0, 1].map(|d| self.kernel.squares(d, self.step_pitches[d]));
        (squares[0] * squares[1]).sqrt()
    }

    /// Deviation of readings where independent lines have unit deviation.
    pub fn deviation_by_lines(&self) -> f64 {
        self.kernel.squares(0, self.step_pitches[0]).sqrt()
    }
}

/// A number by which places near each other follow each other: then few of many nodes act in a chunk of rows. Bits of the place along
/// x and along y, in pitches, in turn (Morton 1966).
#[must_use]
pub fn order_of_places(place: [f64; 2]) -> u64 {
    let spread = |place: u32| {
        let bits = (0..u32::BITS).map(|bit| u64::from(place >> bit & 1) << (2 * bit));
        bits.sum::<u64>()
    };
    // Numbers of either sign ascend as unsigned ones.
    let [x, y] = place.map(|p| (p.floor() as i32 as u32) ^ (1 << 31));
    spread(x) | spread(y) << 1
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::kernel::{ApertureKernel, CubicSpline, MeshKernel};

    fn apertures() -> Lattice<ApertureKernel> {
        Lattice {
            kernel: ApertureKernel {
                half_pitches: [3.2, 2.6],
                edge: 0.4,
            },
            step_pitches: [1.5, 1.0],
        }
    }

    /// Asked from the place or from the node, the weights are the same.
    #[test]
    fn nodes_under_a_place_are_all_that_have_a_weight_there() {
        let lattice = apertures();
        for place in [[0.2, 5.7], [-3.3, 1.0], [12.9, -0.4]] {
            let under: BTreeMap<_, _> = lattice.nodes(place).collect();
            let mut weighing = 0;
            for node in (-15..15).flat_map(|i| (-15..15).map(move |j| [i, j])) {
                let weight = lattice.weight(node, place);
                let found = under.get(&node).copied().unwrap_or(0.0);
                assert!((weight - found).abs() < 1e-15, "{place:?} {node:?}");
                weighing += usize::from(weight > 0.0);
            }
            assert_eq!(weighing, under.len());
            for (line, weight) in lattice.lines(place) {
                assert!((lattice.line_weight(line, place) - weight).abs() < 1e-15);
            }
        }
    }

    /// A cubic B-spline of a linear function's values is that function.
    #[test]
    fn splines_keep_linear_fields() {
        let lattice = Lattice::of_teeth(CubicSpline);
        let linear = |[x, y]: [f64; 2]| 2.0 * x - 0.5 * y;
        for place in [[0.1, 5.7], [3.3, 2.2], [-4.0, 7.0]] {
            let nodes = lattice.nodes(place);
            let value: f64 = nodes.map(|(n, w)| w * linear(n.map(f64::from))).sum();
            assert!((value - linear(place)).abs() < 1e-12, "{place:?}");
        }
    }

    /// The stated deviations are the mean squares of the weights over the places between nodes.
    #[test]
    fn deviations_are_those_of_sums_over_nodes() {
        let lattice = apertures();
        let steps = 30;
        let (mut by_nodes, mut by_lines) = (0.0, 0.0);
        for k in 0..steps * steps {
            let at = |k: i32| f64::from(k) / f64::from(steps);
            let place = [1.5 * at(k % steps), at(k / steps)];
            by_nodes += lattice.nodes(place).map(|(_, w)| w * w).sum::<f64>();
            by_lines += lattice.lines(place).map(|(_, w)| w * w).sum::<f64>();
        }
        let mean = |sum: f64| (sum / f64::from(steps * steps)).sqrt();
        let share = mean(by_nodes) / lattice.deviation_by_nodes();
        assert!((share - 1.0).abs() < 0.01, "{share}");
        let share = mean(by_lines) / lattice.deviation_by_lines();
        assert!((share - 1.0).abs() < 0.01, "{share}");
    }

    #[test]
    fn a_node_is_passed_as_often_as_it_is_read() {
        let lattice = Lattice {
            kernel: MeshKernel::of_segment(1.0),
            step_pitches: [1.0; 2],
        };
        let passed = lattice.passed([[0.0, 0.0], [0.0, 0.0], [4.0, 0.0]]);
        assert_eq!(passed[&[0, 0]], 2.0);
        assert_eq!(passed[&[2, 0]], 1.5);
        assert!(!passed.contains_key(&[0, 3]));
    }

    #[test]
    fn places_near_each_other_follow_each_other() {
        let order = |x: f64, y: f64| order_of_places([x, y]);
        assert_eq!(order(3.2, 4.1), order(3.9, 4.9));
        assert!(order(-1.0, 0.0) < order(0.0, 0.0) && order(0.0, -1.0) < order(0.0, 0.0));
        // A square of four is whole before the next begins.
        assert!(order(1.0, 1.0) < order(2.0, 0.0) && order(1.0, 1.0) < order(0.0, 2.0));
    }
}
