//! One pose at a state: the tooth map's equations, with spans and rulings beside them.

use crate::key::{Key, RULINGS, SPAN};
use crate::member::Member;
use crate::state::{FURTHER, State, further, keys_of};
use courier_sensor::equations::theta;
use courier_sensor::frame::SEGMENTS;
use tooth_map::{
    Linear, Rulings, Setup, TeethPose, Unknowns, by_raw_outputs, linear, misclosures, places,
};

/// Step by which a derivative by the span is taken, m. Derived from both: small beside a tooth, over which fields bend, large
/// beside the digits of f64.
const SPAN_STEP_M: f64 = 1.0e-6;
/// Place of [`SPAN`] among the [`further`] unknowns, by definition of their order.
const SPAN_PLACE: usize = 4;

/// A recording's problem at a state.
pub struct AtState {
    /// Order of the tooth map's unknowns.
    pub unknowns: Unknowns,
    /// The key of each unknown: those of the tooth map, then the [`further`] ones.
    pub keys: Vec<Key>,
    /// Geometry with the courier's spans and the platen's rulings as they are known.
    setup: Setup,
    /// Values of the tooth map's unknowns.
    values: Vec<f64>,
    /// Geometry and values by which poses are weighed: as they were entered, and the waves as [`State::weighing`] has them.
    weighing: (Setup, Vec<f64>),
    /// Values of the further ones.
    further: [f64; FURTHER],
}

impl AtState {
    /// Of a recording.
    #[must_use]
    pub fn new(member: &Member, state: &State) -> Self {
        let unknowns = state.unknowns(member);
        let shift_teeth = state.shift_teeth(&member.recording);
        let mut keys = keys_of(member, &unknowns, shift_teeth);
        let value = |key: &Key| state.value(&member.platen, key);
        let values: Vec<f64> = keys.iter().map(value).collect();
        let more = further(member).map(|(key, _)| key);
        let further = more.each_ref().map(value);
        let spans = Key::Courier(member.courier.clone(), SPAN);
        let mut setup = member.setup;
        setup.span_m += value(&spans);
        let beacon_m = state.beacon_m(&member.platen);
        setup.rulings = Rulings {
            amounts: RULINGS.each_ref().map(value),
            from_m: [0, 1]
                .map(|axis| beacon_m[axis] - f64::from(shift_teeth[axis]) * setup.pitch_m),
        };
        keys.extend(more);
        let mut weighing = unknowns.start(&member.setup);
        let waves = unknowns.wave(0, 0)..unknowns.field(0);
        for at in (0..unknowns.parity()).chain(waves) {
            weighing[at] = state.weighing.get(&keys[at]).copied().unwrap_or(0.0);
        }
        Self {
            unknowns,
            keys,
            setup,
            values,
            weighing: (member.setup, weighing),
            further,
        }
    }

    /// Geometry with the courier's spans and the platen's rulings as they are known.
    #[must_use]
    pub fn setup(&self) -> &Setup {
        &self.setup
    }

    /// A pose linearised: the further unknowns are among its derivatives, by their places in [`Self::keys`].
    ///
    /// A span acts on the angle and on where the segments stand over the teeth: its derivative is a difference.
    #[must_use]
    pub fn linear(&self, pose: &TeethPose) -> Linear {
        let mut at = linear(&self.setup, &self.unknowns, &self.values, pose);
        let span_m = self.setup.span_m;
        let theta_rad = theta(&at.outputs_m, span_m);
        let mut longer = self.setup;
        longer.span_m += SPAN_STEP_M;
        let beyond = misclosures(&longer, &self.unknowns, &self.values, pose);
        let first = self.keys.len() - self.further.len();
        let by_segments = |amounts: [f64; 4]| -> [f64; 3] {
            std::array::from_fn(|k| (0..4).map(|s| amounts[s] * at.by_outputs[s][k]).sum())
        };
        // The outputs have what the rulings add.
        let straight = Setup {
            rulings: Rulings::default(),
            ..self.setup
        };
        let seen = places(&straight, &at.outputs_m);
        let by_places: [[f64; 4]; SEGMENTS] = std::array::from_fn(|s| {
            let place_m = seen[s].map(|pitches| pitches * self.setup.pitch_m);
            self.setup.rulings.shapes(s, place_m)
        });
        let by_ruling = |k: usize| by_segments(by_places.map(|of_segment| of_segment[k]));
        let rows = [
            by_ruling(0),
            by_ruling(1),
            by_ruling(2),
            by_ruling(3),
            std::array::from_fn(|k| (beyond[k] - at.g_m[k]) / SPAN_STEP_M),
            [-theta_rad, 0.0, 0.0],
            by_diode_shear(&at, &self.unknowns),
        ];
        for (k, row) in rows.into_iter().enumerate() {
            at.by.push((first + k, row));
            // Rulings and the span itself are in the geometry.
            if k >= RULINGS.len() && k != SPAN_PLACE {
                let value = self.further[k];
                at.g_m
                    .iter_mut()
                    .zip(row)
                    .for_each(|(g, by)| *g += value * by);
            }
        }
        // Noise is in the raw outputs, so that a pose is whitened by the derivatives by these. Weights that follow the arms would have the fit lengthen them: readings count less under a longer one.
        let (setup, values) = &self.weighing;
        at.by_outputs = by_raw_outputs(setup, &self.unknowns, values, pose);
        at
    }
}

/// Derivatives by a shear of the diode's axes: a deflection (u, v) becomes (u + s v, v + s u). A difference of gains makes (u + d u, v - d v) of it, and
/// (v, u) is (u, -v) turned by a quarter.
fn by_diode_shear(at: &Linear, unknowns: &Unknowns) -> [f64; 3] {
    let gains = unknowns.misalignment();
    let by_gains = at.by.iter().find(|(unknown, _)| *unknown == gains);
    by_gains.map_or([0.0; 3], |(_, [_, x, y])| [0.0, -y, *x])
}
