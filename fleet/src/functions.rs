//! Linear functions of the unknowns that the answer tells: what a field displaces, what a sensor's waves make.

use crate::key::{Key, Platen};
use crate::linearised::AtState;
use crate::member::Member;
use crate::state::State;
use courier_sensor::equations::OWN_ORDERS;
use courier_sensor::frame::SEGMENTS;
use nalgebra::DMatrix;
use std::collections::BTreeSet;
use tooth_field::Lattice;
use tooth_map::{FieldKernel, TeethPose, Unknowns, WAVES, places};

/// A linear function: keys and weights.
pub type Function = Vec<(Key, f64)>;

/// Cells of a direction's field, by the tooth along and across from which each reaches to the next.
pub type Cells = BTreeSet<[i32; 2]>;

/// Cells over which each segment was in a recording's poses, in the platen's count.
#[must_use]
pub fn visited_by_segments(member: &Member, state: &State) -> [Cells; SEGMENTS] {
    let at = AtState::new(member, state);
    let shift = state.shift_teeth(&member.recording);
    let mut cells = [(); SEGMENTS].map(|()| Cells::new());
    for TeethPose { outputs_m, .. } in &member.poses {
        for (s, [along, across]) in places(at.setup(), outputs_m).into_iter().enumerate() {
            let direction = s % 2;
            let [along, across] = [along.floor() as i32, across.floor() as i32];
            cells[s].insert([along + shift[direction], across + shift[1 - direction]]);
        }
    }
    cells
}

/// Cells of both fields over which a recording's poses had a segment, in the platen's count.
#[must_use]
pub fn visited(member: &Member, state: &State) -> [Cells; 2] {
    let [x, y, other_x, other_y] = visited_by_segments(member, state);
    [&x | &other_x, &y | &other_y]
}

/// The field of a direction at the middle of each cell, less the plane of least squares through all of them: its height is gauge, its slopes are
/// what rulings of another pitch or out of square are, and a common pitch is gauge as well.
#[must_use]
pub fn field_functions(field: Lattice<FieldKernel>, direction: u8, cells: &Cells) -> Vec<Function> {
    let at = |cell: &[i32; 2]| -> Function {
        let place = cell.map(|tooth| f64::from(tooth) + 0.5);
        let nodes = field
            .nodes(place)
            .map(|(node, w)| (Key::Node(direction, node), w));
        let lines = field
            .lines(place)
            .map(|(line, w)| (Key::Line(direction, line), w));
        nodes.chain(lines).collect()
    };
    let values: Vec<Function> = cells.iter().map(at).collect();
    let away = off_plane(cells);
    let one = |row: usize| {
        let weighted = values.iter().enumerate().flat_map(|(k, function)| {
            let share = away[(row, k)];
            function
                .iter()
                .map(move |(key, w)| (key.clone(), share * w))
        });
        gathered(weighted.collect())
    };
    (0..values.len()).map(one).collect()
}

/// What takes values at the cells to what is left of them beside their plane: the identity less the projection on 1 and both places.
#[must_use]
pub fn off_plane(cells: &Cells) -> DMatrix<f64> {
    let count = cells.len();
    let columns = cells
        .iter()
        .flat_map(|[i, j]| [1.0, f64::from(*i), f64::from(*j)]);
    let design = DMatrix::from_row_iterator(count, 3, columns);
    let left = DMatrix::identity(count, count);
    // Singular values: cells on one line have two columns alike.
    match design.svd(true, false).u {
        Some(u) if count > 3 => left - &u * u.transpose(),
        _ => left * 0.0,
    }
}

/// One entry a key.
pub fn gathered(mut function: Function) -> Function {
    function.sort_by(|a, b| a.0.cmp(&b.0));
    function.dedup_by(|next, kept| {
        let same = next.0 == kept.0;
        if same {
            kept.1 += next.1;
        }
        same
    });
    function
}

/// What a courier's own waves, equation (3), and its lateral ones amount to: the functions whose squares' half sum over a segment, and mean over
/// the segments, is the mean square of its error over a tooth.
#[must_use]
pub fn own_functions_of(member: &Member) -> Vec<Function> {
    let unknowns = Unknowns::new(member.grids);
    let of = |i: usize| vec![(Key::Courier(member.courier.clone(), i as u16), 1.0)];
    let mut functions = Vec::new();
    for s in 0..SEGMENTS {
        for order in 0..OWN_ORDERS.len() {
            functions.extend([0, 1].map(|k| of(unknowns.own(s, order) + k)));
        }
        for wave in 0..WAVES.len() {
            functions.extend([0, 1].map(|k| of(unknowns.wave(s, wave) + k)));
        }
    }
    functions
}

/// Value of a function at a state.
#[must_use]
pub fn value(state: &State, platen: &Platen, function: &Function) -> f64 {
    function
        .iter()
        .map(|(key, weight)| weight * state.value(platen, key))
        .sum()
}
