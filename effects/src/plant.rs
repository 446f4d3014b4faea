//! The plant's side of an effect: hooks along the physical chain from the true pose to counts, all in f64.
//!
//! Order at each sample: platen -> displacement -> signal -> analog (noise already added) -> codes, tooth count beside them;
//! coordination delay and beacon -> deflection -> analog -> codes for the electrodes. An effect overrides what it touches.

use crate::motion::{Motion, Pose};
use crate::random::ChaCha8Rng;

/// Number of quadrature-pair segments; index 0..=3 is the paper's 1..=4, 0 and 2 measure x. By definition of the sensor: "four
/// quadrature-pairs" (paper, section 1).
pub const SEGMENTS: usize = 4;

/// Geometry of the courier in f64: lengths of equations (3), (4), (9), (10) and (11).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Geometry {
    /// Tooth pitch, rho.
    pub pitch_m: f64,
    /// Distance between the segments of a pair, l_s.
    pub span_m: f64,
    /// Lateral offset l_o of equation (9).
    pub lateral_m: f64,
    /// Beacon's height over the diode, h.
    pub height_m: f64,
    /// Lever arm l_x, l_y of equation (11).
    pub lever_m: [f64; 2],
    /// tan(psi) at a normalised deflection of 1.
    pub tan_full_scale: f64,
}

impl Geometry {
    /// The paper's courier; h, l_y, l_o and the full scale are not in its text: values of a plausible build.
    pub const PAPER: Self = Self {
        pitch_m: 1.016e-3,
        span_m: 9.7e-3,
        lateral_m: 3.0e-3,
        height_m: 50.0e-3,
        lever_m: [90.0e-3, 5.0e-3],
        tan_full_scale: 0.1,
    };

    /// 2 pi / pitch.
    #[must_use]
    pub fn wavenumber(&self) -> f64 {
        core::f64::consts::TAU / self.pitch_m
    }

    /// Where the segments are over the platen at a pose: equation (4) along, equation (9)'s arguments across.
    #[must_use]
    pub fn points(&self, pose: Pose) -> [SegmentPoint; SEGMENTS] {
        let half = 0.5 * self.span_m * pose.theta_rad;
        let side = self.lateral_m * pose.theta_rad;
        let Pose { x_m: x, y_m: y, .. } = pose;
        [
            SegmentPoint {
                own_m: x + half,
                across_m: y - side,
            },
            SegmentPoint {
                own_m: y + half,
                across_m: x + side,
            },
            SegmentPoint {
                own_m: x - half,
                across_m: y + side,
            },
            SegmentPoint {
                own_m: y - half,
                across_m: x - side,
            },
        ]
    }

    /// Place of a segment across its own direction, relative to the sensor's centre: segments of a pair cross the same
    /// lines half a span to either side, which is what makes their difference an angle.
    #[must_use]
    pub fn across_offset_m(&self, segment: usize) -> f64 {
        match segment {
            0 | 3 => -0.5 * self.span_m,
            _ => 0.5 * self.span_m,
        }
    }
}

/// A segment's place over the platen, in the ruling's coordinates.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct SegmentPoint {
    /// Along the direction that the segment measures, metres.
    pub own_m: f64,
    /// Across it, metres; equation (9)'s lateral argument.
    pub across_m: f64,
}

/// What an effect may know of one sampling instant.
#[derive(Clone, Copy)]
pub struct Instant<'a> {
    /// Since the courier was switched on, seconds.
    pub time_s: f64,
    /// True pose.
    pub pose: Pose,
    /// Board temperature minus the reference temperature, kelvin.
    pub temperature_delta_k: f64,
    /// The whole motion: poses at other times, velocities.
    pub motion: &'a dyn Motion,
    /// True geometry.
    pub geometry: &'a Geometry,
}

impl Instant<'_> {
    /// Velocity of the sensor's centre: m/s, m/s, rad/s.
    #[must_use]
    pub fn velocity(&self) -> Pose {
        self.motion.velocity(self.time_s)
    }

    /// Each segment's speed along its own direction, m/s (equation (4), differentiated).
    #[must_use]
    pub fn own_speeds(&self) -> [f64; SEGMENTS] {
        self.geometry
            .points(self.velocity())
            .map(|point| point.own_m)
    }
}

/// A quadrature pair in units of its nominal amplitude, before the converter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Signal {
    /// Phase of the unmodified output, radians, unwrapped.
    pub phase_rad: f64,
    /// Sine channel.
    pub sine: f64,
    /// Cosine channel.
    pub cosine: f64,
}

/// Everything at the converter's inputs, in counts, noise included, before rounding.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Channels {
    /// `[segment][sine, cosine]`.
    pub quadrature: [[f64; 2]; SEGMENTS],
    /// `x+, x-, y+, y-`.
    pub electrodes: [f64; 4],
    /// Nominal amplitude of a quadrature pair.
    pub amplitude_counts: f64,
    /// Nominal sum of an axis' two electrodes; zero when no beacon is seen.
    pub psd_sum_counts: f64,
}

/// The converter's output.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Codes {
    /// `[segment][sine, cosine]`.
    pub quadrature: [[i16; 2]; SEGMENTS],
    /// `x+, x-, y+, y-`.
    pub electrodes: [i16; 4],
}

/// The plant's side of an effect. Hooks are called once a sample, in time order; an effect may keep state.
///
/// Every default does nothing, so an effect states only what it does.
pub trait PlantEffect: Send {
    /// Multiplies the effect's size: how a caller reaches a stated size over a motion of its own.
    fn scale(&mut self, factor: f64);

    /// Where the segments are over the ruling: skew, pitch difference, growth, mounting.
    fn platen(&mut self, _at: &Instant, _points: &mut [SegmentPoint; SEGMENTS]) {}

    /// What this effect adds to each segment's output, metres.
    fn displacement_m(
        &mut self,
        _at: &Instant,
        _points: &[SegmentPoint; SEGMENTS],
    ) -> [f64; SEGMENTS] {
        [0.0; SEGMENTS]
    }

    /// Electrical signals: offset, gain, phase, amplitude, harmonics, cross-talk.
    fn signal(&mut self, _at: &Instant, _signals: &mut [Signal; SEGMENTS]) {}

    /// How much later than the platen sensor the coordination sensor is sampled, seconds (negative: earlier).
    fn coordination_delay_s(&self) -> f64 {
        0.0
    }

    /// Displacement of the beacon from its mean place, metres, platen frame.
    fn beacon_m(&mut self, _at: &Instant) -> [f64; 2] {
        [0.0; 2]
    }

    /// Deflection of the coordination sensor, normalised: 1 is full scale.
    fn deflection(&mut self, _at: &Instant, _normalised: &mut [f64; 2]) {}

    /// At the converter's inputs: further noise, bursts, clipping, stray light.
    fn analog(&mut self, _at: &Instant, _channels: &mut Channels) {}

    /// The converter's codes.
    fn codes(&mut self, _at: &Instant, _codes: &mut Codes) {}

    /// Teeth that each counter is off by.
    fn teeth(&mut self, _at: &Instant) -> [i32; SEGMENTS] {
        [0; SEGMENTS]
    }

    /// What the interferometer reads in excess of the truth (an effect on the reference, not on the courier).
    fn reference(&mut self, _at: &Instant, _pose: &mut Pose) {}

    /// A quantity that the machine logs and this effect follows: name of its column, and its value as it is logged.
    fn logged(&self, _at: &Instant) -> Option<(&'static str, f64)> {
        None
    }
}

/// What a realisation is drawn for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Scene {
    /// The courier's true geometry.
    pub geometry: Geometry,
    /// How long the recording will take, seconds: drifts wander and slips happen within it.
    pub duration_s: f64,
    /// Nominal amplitude of the quadrature pairs, counts.
    pub amplitude_counts: f64,
}

impl Scene {
    /// Counts that move a pair's output by a metre at unit sensitivity: `amplitude * 2 pi / pitch`.
    #[must_use]
    pub fn counts_per_m(&self) -> f64 {
        self.amplitude_counts * self.geometry.wavenumber()
    }
}

/// Draws a realisation: scene, generator, size (rms of the main channel, metres, over the motion that the effect's
/// file states).
pub type Draw = fn(&Scene, &mut ChaCha8Rng, f64) -> Box<dyn PlantEffect>;
