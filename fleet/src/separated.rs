//! What was separated: the field of a platen cell by cell, and the waves of a courier coefficient by coefficient.

use crate::functions::{Cells, Function, field_functions, own_functions_of, value};
use crate::key::Platen;
use crate::member::Member;
use crate::solve::Posterior;
use crate::state::State;
use courier_sensor::equations::OWN_ORDERS;
use courier_sensor::frame::SEGMENTS;
use rayon::prelude::*;
use serde::Serialize;
use tooth_field::Lattice;
use tooth_map::{FieldKernel, WAVES};

/// What teeth are displaced by at the middle of a cell, less the field's plane.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct CellAnswer {
    /// The field: of teeth that tell x, or y.
    pub field: char,
    /// Teeth along and across the field, in the platen's count, from which the cell reaches to the next.
    pub teeth: [i32; 2],
    /// Displacement, m.
    pub displacement_m: f64,
    /// Its predicted standard deviation, m.
    pub deviation_m: f64,
}

/// The cells of a platen's fields over which a segment was. Cost: a solution of the platen's equations for each.
pub fn cells(
    state: &State,
    posterior: &Posterior,
    platen: &Platen,
    lattice: Lattice<FieldKernel>,
    visited: &[Cells; 2],
) -> Vec<CellAnswer> {
    let of_one = |(direction, field): (u8, char)| {
        let cells = &visited[usize::from(direction)];
        let functions = field_functions(lattice, direction, cells);
        let each: Vec<(&[i32; 2], Function)> = cells.iter().zip(functions).collect();
        each.into_par_iter()
            .map(|(teeth, function)| CellAnswer {
                field,
                teeth: *teeth,
                displacement_m: value(state, platen, &function),
                deviation_m: posterior.deviation(platen, &function),
            })
            .collect::<Vec<_>>()
    };
    [(0, 'x'), (1, 'y')].into_iter().flat_map(of_one).collect()
}

/// A wave of a courier's segment: `sine sin(i φ + j ψ) + cosine cos(i φ + j ψ)` of the phase along it, φ, and across it, ψ.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct WaveAnswer {
    /// Segment, 1 to 4.
    pub segment: usize,
    /// Orders `i` and `j`; those of equation (3) have no `j`.
    pub orders: [i8; 2],
    /// Amplitudes of sine and cosine, m.
    pub amplitudes_m: [f64; 2],
    /// Their predicted standard deviations, m.
    pub deviations_m: [f64; 2],
}

/// A courier's waves, and the predicted covariance of their amplitudes, m²: by wave, the sine before the cosine.
pub fn waves(
    state: &State,
    posterior: &Posterior,
    member: &Member,
) -> (Vec<WaveAnswer>, Vec<Vec<f64>>) {
    let functions = own_functions_of(member);
    let covariance = posterior.covariance(&member.platen, &functions);
    let own = OWN_ORDERS.map(|order| [order as i8, 0]);
    let across = WAVES.map(|(along, across)| [along as i8, across]);
    let orders: Vec<[i8; 2]> = own.into_iter().chain(across).collect();
    let one = |(k, pair): (usize, &[Function])| WaveAnswer {
        segment: k / orders.len() + 1,
        orders: orders[k % orders.len()],
        amplitudes_m: [0, 1].map(|part| value(state, &member.platen, &pair[part])),
        deviations_m: [0, 1].map(|part| covariance[(2 * k + part, 2 * k + part)].sqrt()),
    };
    let waves: Vec<WaveAnswer> = functions.chunks_exact(2).enumerate().map(one).collect();
    debug_assert_eq!(waves.len(), SEGMENTS * orders.len());
    let rows = covariance
        .row_iter()
        .map(|row| row.iter().copied().collect());
    (waves, rows.collect())
}
