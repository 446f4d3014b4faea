//! Calibrated outputs of a pose and their derivatives: the order of work is the interrupt's. Equation (3) takes the raw phases, fields
//! the outputs that it has calibrated, waves (equation 9's term among them) those that all have.

use super::pose::{Setup, TeethPose};
use super::unknowns::{Unknowns, WAVES};
use courier_sensor::equations::{
    self, ANGLE_SIGN, OWN_ORDERS, PARITY_SIGN, lateral_arguments, middle, own_functions, theta,
};
use courier_sensor::frame::SEGMENTS;
use std::f64::consts::TAU;

/// Outputs of a pose, metres.
#[derive(Clone, Copy, Debug, Default)]
pub struct Outputs {
    /// Calibrated.
    pub p_m: [f64; SEGMENTS],
    /// Derivatives of equation (3)'s outputs by the raw ones.
    pub by_raw: [f64; SEGMENTS],
    /// Derivatives of the waves, `[segment]`, by the outputs before them.
    pub waves_by_outputs: [[f64; SEGMENTS]; SEGMENTS],
}

/// Derivatives of each output by the unknowns: `(unknown, derivative)`.
#[derive(Clone, Debug, Default)]
pub struct Derivatives {
    /// Of the outputs as they are before the waves.
    pub before_waves: [Vec<(usize, f64)>; SEGMENTS],
    /// Of the waves themselves.
    pub of_waves: [Vec<(usize, f64)>; SEGMENTS],
}

impl Derivatives {
    /// Those of an output by all unknowns, those that act through the places of waves included.
    #[must_use]
    pub fn of_output(&self, outputs: &Outputs, segment: usize) -> Vec<(usize, f64)> {
        let own = self.of_waves[segment].iter().copied();
        let through = (0..SEGMENTS).flat_map(|from| {
            let moves =
                outputs.waves_by_outputs[segment][from] + f64::from(u8::from(from == segment));
            let before = self.before_waves[from].iter();
            before.map(move |(at, by)| (*at, moves * by))
        });
        own.chain(through).collect()
    }
}

/// Outputs that are being made, and their derivatives where these are wanted: one place for both, so that they go together.
struct Sum<'a> {
    out: Outputs,
    values: &'a [f64],
    derivatives: Option<&'a mut Derivatives>,
}

impl Sum<'_> {
    fn add(&mut self, segment: usize, at: usize, derivative: f64) {
        self.out.p_m[segment] += self.values[at] * derivative;
        if let Some(lists) = &mut self.derivatives {
            lists.before_waves[segment].push((at, derivative));
        }
    }

    fn add_wave(&mut self, segment: usize, at: usize, function: f64) {
        self.out.p_m[segment] += self.values[at] * function;
        if let Some(lists) = &mut self.derivatives {
            lists.of_waves[segment].push((at, function));
        }
    }
}

/// Position of the pair across, with equation (9)'s turn: the lateral argument of each segment, metres. The turn is the courier's: lines that are turned
/// take no part in it.
fn lateral_m(setup: &Setup, p: &[f64; SEGMENTS]) -> [f64; SEGMENTS] {
    let corrected = corrected(setup, p);
    lateral_arguments(middle(p), theta(&corrected, setup.span_m), setup.lateral_m)
}

/// The same as a linear function of the outputs, along two equal rulings at right angles.
fn linear_lateral_m(setup: &Setup, p: &[f64; SEGMENTS]) -> [f64; SEGMENTS] {
    lateral_arguments(middle(p), theta(p, setup.span_m), setup.lateral_m)
}

/// Outputs with what the rulings add to them.
fn corrected(setup: &Setup, p: &[f64; SEGMENTS]) -> [f64; SEGMENTS] {
    if setup.rulings.are_straight() {
        return *p;
    }
    let places_m = equations::places(p, &linear_lateral_m(setup, p), setup.span_m);
    let by_m = setup.rulings.corrections_m(&places_m);
    std::array::from_fn(|i| p[i] + by_m[i])
}

/// Places of a segment in its direction's field, pitches, from outputs.
pub fn places(setup: &Setup, p: &[f64; SEGMENTS]) -> [[f64; 2]; SEGMENTS] {
    let places_m = equations::places(p, &lateral_m(setup, p), setup.span_m);
    places_m.map(|place| place.map(|p| p / setup.pitch_m))
}

/// Everything of one pose; its derivatives are added to these lists, where there are some. Fields and waves follow the lines, so that what the rulings
/// add comes last. A place outside the lattice has no field. The
/// waves' phases are those of the places that fields and waves have corrected, which the interrupt takes to first order.
pub fn outputs(
    setup: &Setup,
    unknowns: &Unknowns,
    values: &[f64],
    pose: &TeethPose,
    derivatives: Option<&mut Derivatives>,
) -> Outputs {
    let mut sum = Sum {
        out: Outputs {
            p_m: pose.outputs_m,
            ..Outputs::default()
        },
        values,
        derivatives,
    };
    equation_3(setup, unknowns, &mut sum);
    let calibrated = sum.out.p_m;
    for (i, place) in places(setup, &calibrated).into_iter().enumerate() {
        for (unknown, weight) in unknowns.field_at(i % 2, place).into_iter().flatten() {
            sum.add(i, unknown, weight);
        }
    }
    let mut moved = sum.out.p_m;
    wave_functions(setup, unknowns, &calibrated, |i, at, function| {
        moved[i] += values[at] * function;
    });
    wave_functions(setup, unknowns, &moved, |i, at, function| {
        sum.add_wave(i, at, function);
    });
    sum.out.waves_by_outputs = waves_by_outputs(setup, unknowns, values, &moved);
    sum.out.p_m = corrected(setup, &sum.out.p_m);
    sum.out
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
    // The lateral arguments are linear in the outputs.
    let lateral_by: [[f64; SEGMENTS]; SEGMENTS] = std::array::from_fn(|j| {
        let unit = std::array::from_fn(|k| f64::from(u8::from(k == j)));
        linear_lateral_m(setup, &unit)
    });
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
        for j in 0..SEGMENTS {
            by[i][j] += by_lateral * lateral_by[j][i];
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

fn equation_3(setup: &Setup, unknowns: &Unknowns, sum: &mut Sum) {
    let per_m = TAU / setup.pitch_m;
    let raw = sum.out.p_m;
    for i in 0..SEGMENTS {
        let functions = own_functions((per_m * raw[i]).sin_cos().into());
        sum.out.by_raw[i] = 1.0;
        for (k, [sine, cosine]) in functions.into_iter().enumerate() {
            let at = unknowns.own(i, k);
            let slope = sum.values[at] * cosine - sum.values[at + 1] * sine;
            sum.out.by_raw[i] += per_m * f64::from(OWN_ORDERS[k]) * slope;
            sum.add(i, at, sine);
            sum.add(i, at + 1, cosine);
        }
        sum.add(i, unknowns.parity(), 0.25 * f64::from(PARITY_SIGN[i]));
        sum.add(i, unknowns.angle(), 0.25 * f64::from(ANGLE_SIGN[i]));
    }
}
