//! The straight parts of a platen's lines, its rulings and its displaced teeth together: one is told from the other by what was known before alone,
//! their sum by the readings.

use crate::functions::{Cells, Function, gathered};
use crate::key::{Key, RULINGS};
use courier_sensor::frame::SEGMENTS;
use nalgebra::DMatrix;
use tooth_field::Lattice;
use tooth_map::{FieldKernel, Rulings};

/// Cells by the segment that was over them.
pub type SegmentCells = [Cells; SEGMENTS];

/// Two functions of a platen's unknowns: the pitch of x over that of y, less one, and the angle by which the lines of x are turned toward +x and those
/// of y toward +y, together, rad. They are the slopes of least squares of what corrects the outputs, over the cells. A pair's segments have each their
/// own height, since offsets of parity and angle take up any other. Both are none where the cells leave a slope open.
pub fn straight(
    lattice: Lattice<FieldKernel>,
    cells: &SegmentCells,
    pitch_m: f64,
    from_m: [f64; 2],
) -> Option<[Function; 2]> {
    let rulings = Rulings {
        from_m,
        ..Rulings::default()
    };
    let mut functions = [Function::new(), Function::new()];
    for direction in 0..2 {
        let pair = [direction, direction + 2];
        let each: Vec<(usize, [f64; 2])> = pair
            .into_iter()
            .flat_map(|s| cells[s].iter().map(move |cell| (s, cell)))
            .map(|(s, cell)| (s, cell.map(|tooth| f64::from(tooth) + 0.5)))
            .collect();
        let [along, across] = slopes(&each)?;
        // A larger pitch of x and a smaller one of y; lines of either that are turned.
        let signed = [[1.0, -1.0][direction], 1.0];
        for ((function, slope), sign) in functions.iter_mut().zip([along, across]).zip(signed) {
            for ((s, place), weight) in each.iter().zip(slope) {
                let per_m = sign * weight / pitch_m;
                let nodes = lattice.nodes(*place);
                let nodes = nodes.map(|(node, w)| (Key::Node(direction as u8, node), per_m * w));
                let lines = lattice.lines(*place);
                let lines = lines.map(|(line, w)| (Key::Line(direction as u8, line), per_m * w));
                function.extend(nodes.chain(lines));
                let by_rulings = rulings.shapes(*s, place.map(|teeth| teeth * pitch_m));
                let by_keys = RULINGS.into_iter().zip(by_rulings);
                function.extend(by_keys.map(|(key, by)| (key, per_m * by)));
            }
        }
    }
    Some(functions.map(gathered))
}

/// What takes values at places to their slopes along and across, by teeth.
fn slopes(each: &[(usize, [f64; 2])]) -> Option<[Vec<f64>; 2]> {
    let columns = each.iter().flat_map(|(s, [along, across])| {
        let first = f64::from(u8::from(*s < 2));
        [first, 1.0 - first, *along, *across]
    });
    let design = DMatrix::from_row_iterator(each.len(), 4, columns);
    // Places on one line leave a slope open.
    let normal = (design.transpose() * &design).cholesky()?.inverse();
    let to_unknowns = normal * design.transpose();
    Some([2, 3].map(|row| to_unknowns.row(row).iter().copied().collect()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::key::Ruling;

    /// Over patches of the two segments of each pair that have nothing in common, each ruling's amount is what the functions tell, and a bow adds the
    /// slope that it has in the middle.
    #[test]
    fn amounts_of_rulings_are_what_is_told_of_them() {
        let pitch_m = 1.0e-3;
        let patch = |along: i32, across: i32| -> Cells {
            let cells = (0..4).flat_map(|i| (0..4).map(move |j| [along + i, across + j]));
            cells.collect()
        };
        let cells = [patch(10, 20), patch(20, 15), patch(10, 30), patch(20, 5)];
        let lattice = Lattice::of_teeth(FieldKernel::Spline);
        let functions = straight(lattice, &cells, pitch_m, [-2.0e-3, 1.0e-3]).unwrap();
        let weight = |function: usize, ruling: Ruling| -> f64 {
            let key = Key::Ruling(ruling);
            let of_it = functions[function].iter().filter(|(k, _)| *k == key);
            of_it.map(|(_, w)| w).sum()
        };
        let wanted = [
            (0, Ruling::PitchDifference, 1.0),
            (0, Ruling::OutOfSquare, 0.0),
            (1, Ruling::PitchDifference, 0.0),
            (1, Ruling::OutOfSquare, 1.0),
            (1, Ruling::BowOfX, 2.0 * 26.0e-3),
            (1, Ruling::BowOfY, 2.0 * 14.0e-3),
        ];
        for (function, ruling, wanted) in wanted {
            let found = weight(function, ruling);
            assert!((found - wanted).abs() < 1.0e-9, "{ruling:?}: {found}");
        }
        // Splines add up to a straight line where nodes are on one: 1 µm a tooth across x.
        let of_nodes: f64 = functions[1]
            .iter()
            .map(|(key, w)| match key {
                Key::Node(0, [_, j]) => w * f64::from(*j) * 1.0e-6,
                _ => 0.0,
            })
            .sum();
        assert!((of_nodes - 1.0e-3).abs() < 1.0e-12, "{of_nodes}");
        // One row of cells tells no slope across it.
        let row: Cells = (0..4).map(|i| [i, 0]).collect();
        let rows = [row.clone(), row.clone(), row.clone(), row];
        assert!(straight(lattice, &rows, pitch_m, [0.0; 2]).is_none());
    }
}
