//! A field over a patch of the platen: cubic B-spline, a node a pitch, the firmware's lattice (`courier_sensor::teeth`) in f64.

use courier_sensor::teeth::Grid;

/// Nodes about a place, either way.
pub const SUPPORT: usize = 4;

/// Node and weight of each of the sixteen about a place, nodes numbered from the field's first.
pub type Weights = [(usize, f64); SUPPORT * SUPPORT];

/// Smallest lattice that holds places within these bounds, pitches: `[lowest, highest]` along and across.
pub fn covering(bounds: [[f64; 2]; 2]) -> Grid {
    let first = bounds.map(|[low, _]| low.floor() as i32 - 1);
    let nodes = bounds.map(|[low, high]| (high.floor() - low.floor()) as i64 + 4);
    Grid {
        first_teeth: first,
        nodes: nodes.map(|n| u8::try_from(n).unwrap_or(u8::MAX)),
    }
}

/// Weights at a place, pitches; none outside.
pub fn weights(grid: &Grid, place: [f64; 2]) -> Option<Weights> {
    let (i, along) = spline(place[0] - f64::from(grid.first_teeth[0]), grid.nodes[0])?;
    let (j, aside) = spline(place[1] - f64::from(grid.first_teeth[1]), grid.nodes[1])?;
    let row = usize::from(grid.nodes[1]);
    Some(std::array::from_fn(|k| {
        let (a, b) = (k / SUPPORT, k % SUPPORT);
        ((i + a) * row + j + b, along[a] * aside[b])
    }))
}

/// The cell that a place is in, numbered as its first node.
pub fn cell(grid: &Grid, place: [f64; 2]) -> Option<usize> {
    weights(grid, place).map(|weights| weights[0].0)
}

/// The middle of a cell, pitches; none where the lattice ends before it.
pub fn middle(grid: &Grid, cell: usize) -> Option<[f64; 2]> {
    let row = usize::from(grid.nodes[1]);
    let at = [cell / row, cell % row];
    let inside = (0..2).all(|k| at[k] + SUPPORT <= usize::from(grid.nodes[k]));
    inside.then(|| std::array::from_fn(|k| f64::from(grid.first_teeth[k]) + at[k] as f64 + 1.5))
}

fn spline(position: f64, nodes: u8) -> Option<(usize, [f64; SUPPORT])> {
    if !(position >= 1.0 && position < f64::from(nodes) - 2.0) {
        return None;
    }
    let cell = position.floor();
    let t = position - cell;
    let weights = [
        (1.0 - t).powi(3),
        3.0 * t.powi(3) - 6.0 * t * t + 4.0,
        3.0 * (t + t * t - t.powi(3)) + 1.0,
        t.powi(3),
    ];
    Some((cell as usize - 1, weights.map(|w| w / 6.0)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn lattice_covers_its_bounds_and_nothing_else() {
        let grid = covering([[-3.2, 4.9], [10.0, 12.5]]);
        assert_eq!(grid.first_teeth, [-5, 9]);
        assert_eq!(grid.nodes, [12, 6]);
        for place in [[-3.2, 10.0], [4.9, 12.5], [0.3, 11.0]] {
            let sum: f64 = weights(&grid, place).unwrap().iter().map(|w| w.1).sum();
            assert!((sum - 1.0).abs() < 1e-12);
        }
        assert!(weights(&grid, [-4.1, 11.0]).is_none() && weights(&grid, [5.0, 11.0]).is_none());
        let [i, j] = middle(&grid, cell(&grid, [0.3, 11.2]).unwrap()).unwrap();
        assert!((i - 0.5).abs() < 1e-12 && (j - 11.5).abs() < 1e-12);
    }

    /// A cubic B-spline of a linear function's values is that function.
    #[test]
    fn linear_fields_are_kept() {
        let grid = covering([[0.0, 6.0], [0.0, 6.0]]);
        let row = usize::from(grid.nodes[1]);
        let node = |n: usize| 2.0 * (n / row) as f64 - 0.5 * (n % row) as f64;
        for place in [[0.1, 5.7], [3.3, 2.2]] {
            let value: f64 = weights(&grid, place)
                .unwrap()
                .iter()
                .map(|(n, w)| w * node(*n))
                .sum();
            let wanted = 2.0 * (place[0] + 1.0) - 0.5 * (place[1] + 1.0);
            assert!((value - wanted).abs() < 1e-9);
        }
    }
}
