//! Finer shapes over the coordinates of diagnosis.md, for telling where a gap lies that nothing explains. They compete with no cause.

use crate::design::coordinate_basis::{CoordinateBasis, logged_columns, with_own_phase};
use crate::linearization::recording::LinearizedRecording;
use crate::linearization::stop_operator::{SLACKS_M, StopOperator};
use effects::identity::Factor;
use effects::sensor::{BasisInputs, Covariates, Regressor};
use std::f64::consts::PI;

/// Prior size of a shape, rms m: what calibration leaves of a segment, 2 to 3 µm by the 4.1 to 5.5 µm that it leaves of the
/// parity of four (paper, 3.1.2).
const SIZE_M: f64 = 3.0e-6;
/// Orders of the own tooth phase that may change with something. Derived from the signals: the square of a third harmonic makes
/// order 8.
const OWN_ORDERS: usize = 8;
/// The same of the lateral one. A prior: higher ones fall as a coil some teeth wide averages them.
const LATERAL_ORDERS: usize = 2;
/// Times after which what a start leaves has decayed to 1/e, of the longest stretch. Derived from each other: in steps of a
/// factor of three two neighbours build what decays in between to 6 %.
const DECAYS: [f64; 4] = [0.02, 0.06, 0.2, 0.6];
/// Knots over the range of the angle. A bound on the work: what bends within a twelfth of the range is described no better, and
/// what it leaves stays without a place.
const THETA_KNOTS: usize = 13;
/// Knots over the recording for a factor that wanders. A bound on the work: what wanders faster than a twelfth of the recording
/// stays without a place.
const GAIN_KNOTS: usize = 13;
/// Half waves over the recording. A bound on the work: what wanders faster stays without a place, or is a line of the spectrum.
const WANDER: usize = 60;
/// Half waves over the deflection, along both axes together. A bound on the work: finer waves are looked for one by one
/// ([`crate::spectra::deflection_waves`]).
const HALF_WAVES: usize = 18;
/// Way from the middle over which a pull changes by as much as it is, m.
/// A prior: what pulls at a courier is fixed some decimetres away.
const DIFFERS_M: f64 = 0.1;
/// Samples that tell a range. Cost alone: they tell a range to a thousandth, of longer recordings evenly spread.
const LOOKED_AT: usize = 2000;

type CoordinateFunction = Box<dyn Fn(&Covariates) -> f64 + Send + Sync>;

/// A shape, and its prior size as a part of [`SIZE_M`].
struct ScaledShape {
    part: f64,
    value: CoordinateFunction,
}

/// A shape of full size.
fn full_size(value: impl Fn(&Covariates) -> f64 + Send + Sync + 'static) -> ScaledShape {
    wave(1, value)
}

/// One of a series that may wander as a path of Brown does: the amplitude of a wave falls with its number.
fn wave(number: usize, value: impl Fn(&Covariates) -> f64 + Send + Sync + 'static) -> ScaledShape {
    ScaledShape {
        part: 1.0 / number as f64,
        value: Box::new(value),
    }
}

/// Every family that such a recording can show. Labels are those of [`crate::design::coordinate_basis`] where the coordinate is the same.
pub fn fine_basis(linearized: &LinearizedRecording) -> Vec<CoordinateBasis> {
    let inputs = &linearized.inputs;
    let ranges = Ranges::of(linearized);
    let place = CoordinateBasis::of;
    let mut list = vec![
        place("time", on_channels(inputs, &|| over_time(&ranges))),
        place("own and lateral tooth phase", both_phases(inputs)),
    ];
    if inputs.turning {
        let course = || hats(ranges.theta_rad, THETA_KNOTS, |m| m.theta_rad);
        list.push(place("theta", on_channels(inputs, &course)));
        let across = times_lateral(inputs, |m| m.theta_rad);
        list.push(place("theta and lateral tooth phase", across));
    }
    if inputs.temperature {
        list.push(place(
            "temperature and own tooth phase",
            times(inputs, Factor::Warmth, |m, _| m.warmth_k),
        ));
        let across = times_lateral(inputs, |m| m.warmth_k);
        list.push(place("temperature and lateral tooth phase", across));
    }
    if inputs.moving {
        let mut moving = on_segments(inputs, &speeds);
        moving.extend(on_beacon(inputs, &beacon_speeds));
        list.push(place("speed", moving));
        let mut own = times(inputs, Factor::Speed, |m, s| m.speed_m_s[s]);
        own.extend(times(inputs, Factor::Other, |m, s| m.speed_m_s[s].abs()));
        list.push(place("speed and own tooth phase", own));
        let mut own = times(inputs, Factor::Way, |m, s| m.direction[s]);
        own.extend(times(inputs, Factor::Other, |m, s| m.memory[s][1]));
        list.push(place("direction and own tooth phase", own));
    }
    let stop = StopOperator::of(linearized);
    let dragged = on_segments(inputs, &|s| dragged(&stop, s));
    list.push(place("direction", dragged));
    if inputs.beacon {
        let span = ranges.deflection;
        list.push(place(
            "deflection of the coordination sensor",
            on_beacon(inputs, &|| half_waves(span)),
        ));
        list.push(place(
            "time and deflection of the coordination sensor",
            on_beacon(inputs, &gains),
        ));
    }
    for (k, name) in logged_columns(inputs) {
        list.push(place(
            &with_own_phase(name),
            times(inputs, Factor::Logged, move |m, _| m.logged[k]),
        ));
    }
    list.retain(|place| !place.regressors.is_empty());
    list
}

/// What the shapes are laid over.
struct Ranges {
    theta_rad: [f64; 2],
    deflection: [[f64; 2]; 2],
    /// First moment of each stretch, s.
    starts_s: Vec<f64>,
    /// Longest stretch, s.
    longest_s: f64,
}

impl Ranges {
    fn of(linearized: &LinearizedRecording) -> Self {
        let step = (linearized.len() / LOOKED_AT).max(1);
        let moments: Vec<Covariates> = (0..linearized.len())
            .step_by(step)
            .map(|i| linearized.covariates(i))
            .collect();
        let over = |value: &dyn Fn(&Covariates) -> f64| {
            let start = [f64::INFINITY, f64::NEG_INFINITY];
            moments.iter().fold(start, |[low, high], m| {
                let v = value(m);
                [low.min(v), high.max(v)]
            })
        };
        let o = linearized.observations;
        let count = o.stretch.iter().max().map_or(0, |last| last + 1);
        let (mut starts_s, mut ends_s) = (vec![f64::INFINITY; count], vec![0.0f64; count]);
        for (&stretch, t_s) in o.stretch.iter().zip(&o.t_s) {
            let t_s = t_s - o.t_s[0];
            starts_s[stretch] = starts_s[stretch].min(t_s);
            ends_s[stretch] = ends_s[stretch].max(t_s);
        }
        let lengths = starts_s.iter().zip(&ends_s).map(|(a, b)| b - a);
        Self {
            theta_rad: over(&|m| m.theta_rad),
            deflection: [0, 1].map(|axis| over(&|m| m.deflection[axis])),
            longest_s: lengths.fold(0.0, f64::max),
            starts_s,
        }
    }
}

/// The same shapes on every channel that the recording has.
fn on_channels(inputs: &BasisInputs, shapes: &dyn Fn() -> Vec<ScaledShape>) -> Vec<Regressor> {
    let mut list = Vec::new();
    if !inputs.reference && inputs.segments == [true; 4] {
        push(&mut list, 0, shapes());
    }
    list.extend(on_beacon(inputs, shapes));
    for s in (0..4).filter(|s| inputs.reference && inputs.segments[*s]) {
        push(&mut list, 3 + s, shapes());
    }
    list
}

/// The same on g_x and g_y.
fn on_beacon(inputs: &BasisInputs, shapes: &dyn Fn() -> Vec<ScaledShape>) -> Vec<Regressor> {
    let mut list = Vec::new();
    for channel in (1..3).filter(|_| inputs.beacon) {
        push(&mut list, channel, shapes());
    }
    list
}

fn push(list: &mut Vec<Regressor>, channel: usize, shapes: Vec<ScaledShape>) {
    for (n, shape) in shapes.into_iter().enumerate() {
        let name = format!("finer shape {n} on channel {channel}");
        let size_m = shape.part * SIZE_M;
        list.push(Regressor::channel(name, "m", size_m, channel, shape.value));
    }
}

fn on_segments(inputs: &BasisInputs, shapes: &dyn Fn(usize) -> Vec<ScaledShape>) -> Vec<Regressor> {
    let mut list = Vec::new();
    for s in (0..4).filter(|s| inputs.segments[*s]) {
        for (n, shape) in shapes(s).into_iter().enumerate() {
            let name = format!("finer shape {n} on segment {}", s + 1);
            let size_m = shape.part * SIZE_M;
            list.push(Regressor::reading(name, "m", size_m, s, shape.value));
        }
    }
    list
}

/// Along the segment, across it, and both together; and how either changes.
fn speeds(s: usize) -> Vec<ScaledShape> {
    let along = move |m: &Covariates| m.speed_m_s[s];
    let across = move |m: &Covariates| m.speed_m_s[(s + 1) % 4];
    vec![
        full_size(along),
        full_size(move |m| along(m).abs()),
        full_size(move |m| along(m).powi(2)),
        full_size(move |m| along(m).powi(3)),
        full_size(across),
        full_size(move |m| across(m).abs()),
        full_size(move |m| across(m).powi(2)),
        full_size(move |m| along(m) * across(m)),
        full_size(move |m| along(m) * across(m).abs()),
        full_size(move |m| along(m).hypot(across(m))),
        full_size(move |m| m.acceleration_m_s2[s]),
        full_size(move |m| m.acceleration_m_s2[(s + 1) % 4]),
        full_size(move |m| m.acceleration_m_s2[s].abs()),
    ]
}

fn beacon_speeds() -> Vec<ScaledShape> {
    let v = |m: &Covariates| [m.speed_m_s[0], m.speed_m_s[1]];
    vec![
        full_size(move |m| v(m)[0]),
        full_size(move |m| v(m)[1]),
        full_size(move |m| v(m)[0].abs()),
        full_size(move |m| v(m)[1].abs()),
        full_size(move |m| v(m)[0].powi(2)),
        full_size(move |m| v(m)[1].powi(2)),
        full_size(move |m| v(m)[0] * v(m)[1]),
        full_size(move |m| m.acceleration_m_s2[0]),
        full_size(move |m| m.acceleration_m_s2[1]),
    ]
}

/// What is dragged after the courier pulls at the segment, by more here than there.
fn dragged(stop: &StopOperator, s: usize) -> Vec<ScaledShape> {
    let mut list = Vec::new();
    for k in 0..SLACKS_M.len() {
        let (here, along, across) = (stop.clone(), stop.clone(), stop.clone());
        list.push(full_size(move |m| here.at(m, s, k)));
        list.push(full_size(move |m| {
            along.at(m, s, k) * m.from_middle_m[0] / DIFFERS_M
        }));
        list.push(full_size(move |m| {
            across.at(m, s, k) * m.from_middle_m[1] / DIFFERS_M
        }));
    }
    list
}

/// What follows the start of every stretch.
fn since_the_start(ranges: &Ranges) -> Vec<ScaledShape> {
    let mut list: Vec<ScaledShape> = Vec::new();
    for decay in DECAYS {
        let (starts_s, tau_s) = (
            ranges.starts_s.clone(),
            (decay * ranges.longest_s).max(1e-9),
        );
        list.push(full_size(move |m| {
            let start_s = starts_s.get(m.stretch).copied().unwrap_or(0.0);
            (-(m.t_s - start_s).max(0.0) / tau_s).exp()
        }));
    }
    list
}

/// What wanders, and what follows a start.
fn over_time(ranges: &Ranges) -> Vec<ScaledShape> {
    let mut list = since_the_start(ranges);
    list.extend((1..=WANDER).map(|n| wave(n, move |m| (PI * n as f64 * m.progress).cos())));
    list
}

/// A gain of either deflection that changes with time.
fn gains() -> Vec<ScaledShape> {
    let of = |axis: usize| {
        let hats = hats([0.0, 1.0], GAIN_KNOTS, |m| m.progress).into_iter();
        hats.map(move |hat| full_size(move |m| (hat.value)(m) * m.deflection[axis]))
    };
    of(0).chain(of(1)).collect()
}

/// A course over a range, straight from knot to knot.
fn hats([low, high]: [f64; 2], count: usize, value: fn(&Covariates) -> f64) -> Vec<ScaledShape> {
    let step = ((high - low) / (count - 1) as f64).max(1e-12);
    (0..count)
        .map(|k| {
            let at = low + k as f64 * step;
            full_size(move |m| (1.0 - ((value(m) - at) / step).abs()).max(0.0))
        })
        .collect()
}

/// Half waves over both deflections.
fn half_waves(span: [[f64; 2]; 2]) -> Vec<ScaledShape> {
    let mut list: Vec<ScaledShape> = Vec::new();
    for a in 0..=HALF_WAVES {
        for b in 0..=HALF_WAVES - a {
            if a + b == 0 {
                continue;
            }
            list.push(wave(a + b, move |m| {
                let half = |axis: usize, n: usize| {
                    let [low, high] = span[axis];
                    let turns = (m.deflection[axis] - low) / (high - low).max(1e-12);
                    (PI * n as f64 * turns).cos()
                };
                half(0, a) * half(1, b)
            }));
        }
    }
    list
}

/// Orders of the own phase times a factor.
fn times(
    inputs: &BasisInputs,
    which: Factor,
    factor: impl Fn(&Covariates, usize) -> f64 + Send + Sync + Copy + 'static,
) -> Vec<Regressor> {
    let mut list = Vec::new();
    for s in (0..4).filter(|s| inputs.segments[*s]) {
        for order in 1..=OWN_ORDERS {
            Regressor::harmonic(
                &mut list,
                s,
                order,
                ("finer, times ", "1", SIZE_M, which),
                move |m| factor(m, s),
            );
        }
    }
    list
}

/// The same of the lateral phase.
fn times_lateral(inputs: &BasisInputs, factor: fn(&Covariates) -> f64) -> Vec<Regressor> {
    let mut list = Vec::new();
    for s in (0..4).filter(|s| inputs.lateral && inputs.segments[*s]) {
        for order in 1..=LATERAL_ORDERS {
            let name = |part| format!("finer, {part} of lateral order {order}, segment {}", s + 1);
            let wave = move |m: &Covariates| m.lateral[s][order];
            let (sine, cosine) = (name("sine"), name("cosine"));
            let of =
                |name, value: CoordinateFunction| Regressor::reading(name, "1", SIZE_M, s, value);
            list.push(of(sine, Box::new(move |m| factor(m) * wave(m).0)));
            list.push(of(cosine, Box::new(move |m| factor(m) * wave(m).1)));
        }
    }
    list
}

/// Orders of the own phase times orders of the lateral one.
fn both_phases(inputs: &BasisInputs) -> Vec<Regressor> {
    let mut list = Vec::new();
    for s in (0..4).filter(|s| inputs.lateral && inputs.segments[*s]) {
        for (own, lateral) in [(1, 1), (2, 1), (1, 2), (2, 2)] {
            let label = ("finer, with lateral, ", "1", SIZE_M);
            Regressor::harmonic(&mut list, s, own, label, move |m| m.lateral[s][lateral].0);
            Regressor::harmonic(&mut list, s, own, label, move |m| m.lateral[s][lateral].1);
        }
    }
    list
}
