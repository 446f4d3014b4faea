//! Calibrated outputs of a pose and their derivatives: the order of work is the interrupt's. Equation (3) takes the raw phases, fields
//! the outputs that it has calibrated, waves (equation 9's term among them) those that all have.

use super::pose::{Setup, TeethPose};
use super::unknowns::{Unknowns, WAVES};
use courier_sensor::equations::{
    self, ANGLE_SIGN, OWN_ORDERS, PARITY_SIGN, lateral_arguments, middle, own_functions, theta,
};
use courier_sensor::frame::SEGMENTS;
use std::f64::consts::TAU;

/// Outputs of a pose, metres, and each one's derivatives by unknowns.
#[derive(Clone, Debug, Default)]
pub struct Outputs {
    /// Calibrated.
    pub p_m: [f64; SEGMENTS],

    /// `(unknown, derivative)` of the outputs as they are before the waves.
    pub by: [Vec<(usize, f64)>; SEGMENTS],
    /// The same of the waves themselves.
    pub by_waves: [Vec<(usize, f64)>; SEGMENTS],
    /// Derivatives of equation (3)'s outputs by the raw ones.
    pub by_raw: [f64; SEGMENTS],
    /// Derivatives of the waves, `[segment]`, by the outputs before them.
    pub waves_by_outputs: [[f64; SEGMENTS]; SEGMENTS],
}

impl Outputs {
    /// Derivatives of an output by the unknowns, those that act through the places of waves included.
    #[must_use]
    pub fn all_by(&self, segment: usize) -> Vec<(usize, f64)> {
        let own = self.by_waves[segment].iter().copied();
        let through = (0..SEGMENTS).flat_map(|from| {
            let moves = self.waves_by_outputs[segment][from] + f64::from(u8::from(from == segment));
            self.by[from].iter().map(move |(at, by)| (*at, moves * by))
        });
        own.chain(through).collect()
    }

    fn add(&mut self, segment: usize, values: &[f64], at: usize, derivative: f64) {
        self.p_m[segment] += values[at] * derivative;
        self.by[segment].push((at, derivative));
    }
}

/// Position of the pair across, with equation (9)'s turn: the lateral argument of each segment, metres.
fn lateral_m(setup: &Setup, p: &[f64; SEGMENTS]) -> [f64; SEGMENTS] {
    lateral_arguments(middle(p), theta(p, setup.span_m), setup.lateral_m)
}

/// Places of a segment in its direction's field, pitches, from outputs.
pub fn places(setup: &Setup, p: &[f64; SEGMENTS]) -> [[f64; 2]; SEGMENTS] {
    let places_m = equations::places(p, &lateral_m(setup, p), setup.span_m);
    places_m.map(|place| place.map(|p| p / setup.pitch_m))
}

/// Everything of one pose. A place outside the lattice has no field. The waves' phases are those of the places that fields and
/// waves have corrected, which the interrupt takes to first order.
pub fn outputs(setup: &Setup, unknowns: &Unknowns, values: &[f64], pose: &TeethPose) -> Outputs {
    let mut out = Outputs {
        p_m: pose.outputs_m,
        ..Outputs::default()
    };
    equation_3(setup, unknowns, values, &mut out);
    let calibrated = out.p_m;
    for (i, place) in places(setup, &calibrated).into_iter().enumerate() {
        for (unknown, weight) in unknowns.field_at(i % 2, place).into_iter().flatten() {
            out.add(i, values, unknown, weight);
        }
    }
    let mut moved = out.p_m;
    wave_functions(setup, unknowns, &calibrated, |i, at, function| {
        moved[i] += values[at] * function;
    });

    wave_functions(setup, unknowns, &moved, |i, at, function| {
        out.p_m[i] += values[at] * function;
        out.by_waves[i].push((at, function));
    });
    out.waves_by_outputs = waves_by_outputs(setup, unknowns, values, &moved);
    out
}

/// Derivatives of each segment's waves by the outputs: of their own phase, and of the lateral one, which all outputs move.
fn waves_by_outputs(
    setup: &Setup,
    unknowns: &Unknowns,
    values: &[f64],
    outputs_m: &[f64; SEGMENTS],
) -> [[f64; SEGMENTS]; SEGMENTS] {
    let lateral = lateral_m(setup, outputs_m);
    let per_m = TAU / setup.pitch_m;
    let mut by = [[0.0; SEGMENTS]; SEGMENTS];
    for i in 0..SEGMENTS {
        let (mut by_own, mut by_lateral) = (0.0, 0.0);
        for (k, (own, across)) in WAVES.iter().enumerate() {
            let orders = [f64::from(*own), f64::from(*across)];
            let phase = per_m * (orders[0] * outputs_m[i] + orders[1] * lateral[i]);
            let (sine, cosine) = phase.sin_cos();
            let at = unknowns.wave(i, k);
            let slope = per_m * (values[at] * cosine - values[at + 1] * sine);
            by_own += orders[0] * slope;
            by_lateral += orders[1] * slope;
        }
        by[i][i] = by_own;
        // The lateral arguments are linear in the outputs.
        for j in 0..SEGMENTS {
            let unit = std::array::from_fn(|k| f64::from(u8::from(k == j)));
            by[i][j] += by_lateral * lateral_m(setup, &unit)[i];
        }
    }
    by
}

/// Hands over segment, unknown and value of each wave's sine and cosine at some outputs.
fn wave_functions(
    setup: &Setup,
    unknowns: &Unknowns,
    outputs_m: &[f64; SEGMENTS],
    mut take: impl FnMut(usize, usize, f64),
) {
    let lateral = lateral_m(setup, outputs_m);
    let per_m = TAU / setup.pitch_m;
    for i in 0..SEGMENTS {
        for (k, (own, across)) in WAVES.iter().enumerate() {
            let phase = per_m * (f64::from(*own) * outputs_m[i] + f64::from(*across) * lateral[i]);
            let (sine, cosine) = phase.sin_cos();
            take(i, unknowns.wave(i, k), sine);
            take(i, unknowns.wave(i, k) + 1, cosine);
        }
    }
}

fn equation_3(setup: &Setup, unknowns: &Unknowns, values: &[f64], out: &mut Outputs) {
    let per_m = TAU / setup.pitch_m;
    let raw = out.p_m;
    for i in 0..SEGMENTS {
        let functions = own_functions((per_m * raw[i]).sin_cos().into());
        out.by_raw[i] = 1.0;
        for (k, [sine, cosine]) in functions.into_iter().enumerate() {
            let at = unknowns.own(i, k);
            let slope = values[at] * cosine - values[at + 1] * sine;
            out.by_raw[i] += per_m * f64::from(OWN_ORDERS[k]) * slope;
            out.add(i, values, unknowns.own(i, k), sine);
            out.add(i, values, unknowns.own(i, k) + 1, cosine);
        }
        out.add(
            i,
            values,
            unknowns.parity(),
            0.25 * f64::from(PARITY_SIGN[i]),
        );
        out.add(i, values, unknowns.angle(), 0.25 * f64::from(ANGLE_SIGN[i]));
    }
}
