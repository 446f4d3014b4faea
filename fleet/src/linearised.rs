//! One pose at a state: the tooth map's equations, with spans and rulings beside them.

use crate::key::{Key, SPAN};
use crate::member::Member;
use crate::state::{State, further, keys_of};
use courier_sensor::equations::theta;
use tooth_map::{Linear, Setup, TeethPose, Unknowns, by_raw_outputs, linear, misclosures, places};

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
    /// Geometry with the courier's spans as they are known.
    setup: Setup,
    /// Values of the tooth map's unknowns.
    values: Vec<f64>,
    /// Geometry and values by which poses are weighed: as they were entered, and the waves as [`State::weighing`] has them.
    weighing: (Setup, Vec<f64>),
    /// Values of the further ones.
    further: [f64; 6],
    shift_teeth: [i32; 2],
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
            shift_teeth,
        }
    }

    /// Geometry with the courier's spans as they are known.
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
        let theta_rad = theta(&pose.outputs_m, span_m);
        let mut longer = self.setup;
        longer.span_m += SPAN_STEP_M;
        let beyond = misclosures(&longer, &self.unknowns, &self.values, pose);
        let first = self.keys.len() - self.further.len();
        let by_segments = |amounts: [f64; 4]| -> [f64; 3] {
            std::array::from_fn(|k| (0..4).map(|s| amounts[s] * at.by_outputs[s][k]).sum())
        };
        let seen = places(&self.setup, &pose.outputs_m);
        // Places along and across, m, from the platen's count zero.
        let place_m = |s: usize, d: usize| {
            let axis = if d == 0 { s % 2 } else { 1 - s % 2 };
            (seen[s][d] + f64::from(self.shift_teeth[axis])) * self.setup.pitch_m
        };
        let pitch = std::array::from_fn(|s| [0.5, -0.5][s % 2] * place_m(s, 0));
        let bow = |axis: usize| {
            let of = |s: usize| {
                if s % 2 == axis {
                    place_m(s, 1).powi(2)
                } else {
                    0.0
                }
            };
            by_segments(std::array::from_fn(of))
        };
        let square = std::array::from_fn(|s| if s % 2 == 0 { place_m(s, 1) } else { 0.0 });
        let rows = [
            by_segments(pitch),
            by_segments(square),
            bow(0),
            bow(1),
            std::array::from_fn(|k| (beyond[k] - at.g_m[k]) / SPAN_STEP_M),
            [-theta_rad, 0.0, 0.0],
        ];
        for (k, row) in rows.into_iter().enumerate() {
            at.by.push((first + k, row));
            // The span itself is in the geometry.
            if k != SPAN_PLACE {
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
