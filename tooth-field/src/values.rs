//! A field that is told by its values on a mesh: where few teeth are passed, those at the edges of the aperture are many more than
//! what can be told of them, and the aperture gives the values' correlation instead.

use crate::kernel::{MeshKernel, correlations};

/// Share of its power that a field may have besides what the aperture allows: its edges and its teeth are not quite alike.
const ROUGH: f64 = 1.0e-3;

/// One direction of a field that is told by its values at the nodes of a mesh: for each, what it adds to those after it beyond what the
/// ones before it tell, over the field's deviation. They are the columns of the Cholesky factor of the values' correlation, which
/// follows from the aperture: independent amounts of unit deviation give the field that independent teeth do.
#[must_use]
pub fn innovations(kernel: &MeshKernel, count: usize) -> Vec<Vec<f64>> {
    let correlations = correlations(kernel, 0, kernel.step_pitches, count);
    let mut columns = vec![vec![0.0; count]; count];
    for column in 0..count {
        for row in column..count {
            let known: f64 = columns[..column].iter().map(|c| c[row] * c[column]).sum();
            let rest = correlations[row - column] - known;
            columns[column][row] = if row == column {
                (rest + ROUGH).max(ROUGH).sqrt()
            } else {
                rest / columns[column][column]
            };
        }
    }
    columns
}

/// Between values a unit apart; at the nearest beyond them, and zero where there are none.
#[must_use]
pub fn between(values: &[f64], at: f64) -> f64 {
    let Some(last) = values.len().checked_sub(1) else {
        return 0.0;
    };
    let at = at.clamp(0.0, last as f64);
    let first = at as usize;
    let part = at - first as f64;
    (1.0 - part) * values[first] + part * values[(first + 1).min(last)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lattice::Lattice;

    /// Values and teeth are two ways to write the same field: two places go together alike in both.
    #[test]
    fn values_go_together_as_sums_of_teeth_do() {
        for step_pitches in [0.25, 0.5, 1.0] {
            let kernel = MeshKernel::of_segment(step_pitches);
            let lattice = Lattice {
                kernel,
                step_pitches: [step_pitches; 2],
            };
            let columns = innovations(&kernel, 14);
            let teeth = |a: f64, b: f64| -> f64 {
                let there = lattice.along(0, a * step_pitches);
                there
                    .map(|(n, weight)| weight * lattice.line_weight(n, [b * step_pitches, 0.0]))
                    .sum()
            };
            let values = |a: f64, b: f64| -> f64 {
                columns.iter().map(|c| between(c, a) * between(c, b)).sum()
            };
            for (a, b) in [(0.0, 0.0), (3.0, 5.0), (2.5, 2.5), (7.3, 9.8), (0.4, 12.9)] {
                let wanted = teeth(a, b) / teeth(3.0, 3.0);
                let found = values(a, b);
                assert!(
                    (found - wanted).abs() <= 2.0 * ROUGH,
                    "{step_pitches} {a} {b}: {found} {wanted}"
                );
            }
        }
    }
}
