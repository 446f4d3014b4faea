//! `velocity_lag`: a segment's output lags with speed: eddy currents, filter or sampling delay.
//!
//! A delay shifts every pattern, so the plant looks at where the segment was; eddy currents in the teeth add a lag that
//! saturates with speed.

// --- plant side: from the true pose to where the segment reads ---

use crate::plant::{Instant, PlantEffect, SEGMENTS, Scene, SegmentPoint};
use crate::random::{ChaCha8Rng, normal, uniform};
use crate::shape::root_mean_square;

/// Speed at which the size is stated: the fly-bys'. A definition: as a survey makes them.
const REFERENCE_M_S: f64 = 50.0e-3;

/// Plant side. Size: rms over the segments of the lag at 50 mm/s along each.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct VelocityLag {
    /// Each segment's delay, seconds.
    pub delay_s: [f64; SEGMENTS],
    /// Share of the delay that is lost at high speed.
    pub saturation: f64,
    /// Speed at which half of that is lost, m/s.
    pub saturation_m_s: f64,
}

impl VelocityLag {
    /// A common delay and the segments' own, of like size.
    pub fn draw(_scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let common = uniform(rng, 0.0, 1.0);
        let raw: [f64; SEGMENTS] = core::array::from_fn(|_| common + 0.6 * normal(rng));
        let mut effect = Self {
            delay_s: raw,
            saturation: uniform(rng, 0.0, 0.25),
            saturation_m_s: uniform(rng, 0.03, 0.3),
        };
        let lag = effect.delays_s([REFERENCE_M_S; SEGMENTS]).map(|delay| delay * REFERENCE_M_S);
        effect.scale(size_rms_m / root_mean_square(&lag).max(1.0e-12));
        Box::new(effect)
    }

    fn delays_s(&self, speeds_m_s: [f64; SEGMENTS]) -> [f64; SEGMENTS] {
        core::array::from_fn(|s| {
            let speed = speeds_m_s[s].abs();
            self.delay_s[s] * (1.0 - self.saturation * speed / (speed + self.saturation_m_s))
        })
    }
}

impl PlantEffect for VelocityLag {
    fn scale(&mut self, factor: f64) {
        self.delay_s = self.delay_s.map(|delay| delay * factor);
    }

    fn platen(&mut self, at: &Instant, points: &mut [SegmentPoint; SEGMENTS]) {
        let now = at.geometry.points(at.pose);
        let delays_s = self.delays_s(at.own_speeds());
        for (s, point) in points.iter_mut().enumerate() {
            let then = at.geometry.points(at.motion.pose(at.time_s - delays_s[s]))[s];
            point.own_m += then.own_m - now[s].own_m;
            point.across_m += then.across_m - now[s].across_m;
        }
    }
}

// --- sensor side: each segment's own speed ---

/// What a sensor can know of it: shares nothing with the plant side above.
pub mod sensor_side {
    use crate::identity::{Factor, Identity, Wave};
    use crate::sensor::{Regressor, BasisInputs};

    /// Prior size of a delay, m: 50 µs at 0.1 m/s, a filter of some kHz.
    const DELAY_SIZE_M: f64 = 5.0e-6;
    /// Prior size of what eddy currents lose of it at speed, m: a fifth of the delay's, as a correction to first order must be.
    const SATURATION_SIZE_M: f64 = 1.0e-6;
    /// Once a tooth: eddy currents are those of the tooth and not of the slot. Twice: the two channels of a pair are delayed by
    /// different times. Derived from the pair's phase: unlike delays of both channels are a quadrature angle that grows with the
    /// speed, of order 2.
    const WAVES: [usize; 2] = [1, 2];
    /// How much: it completes the effect.
    /// A prior: less than the effect itself, and more than the noise.
    const WAVES_SIZE_M: f64 = 0.6e-6;

    /// Sensor side: a delay of each segment, and a part that grows with the square of speed. Told more fully, a delay that changes over
    /// a tooth.
    pub fn regressors(inputs: &BasisInputs) -> Vec<Regressor> {
        let mut list = Vec::new();
        for s in (0..4).filter(|s| inputs.segments[*s]) {
            let name = format!("delay, segment {}", s + 1);
            let delay = Regressor::reading(name, "s", DELAY_SIZE_M, s, move |m| m.speed_ahead_m_s[s]);
            let delay = delay.aligned_by(inputs.late_s[s]);
            list.push(delay.identified(Identity::Wave(Wave::constant(s, Factor::Speed))));
            let name = format!("square of speed, segment {}", s + 1);
            list.push(Regressor::reading(name, "s²/m", SATURATION_SIZE_M, s, move |m| {
                m.speed_m_s[s] * m.speed_m_s[s].abs()
            }));
            for order in WAVES.into_iter().filter(|_| inputs.forms.lag_waves) {
                let label = ("delay times ", "s", WAVES_SIZE_M, Factor::Speed);
                Regressor::free_harmonic(inputs, &mut list, (s, order), label, move |m| {
                    m.speed_m_s[s]
                });
            }
        }
        list
    }
}

// --- what is known of it ---

use crate::effect::{Card, Confusable, Effect, Form, Need, Quantity};
use crate::sensor::{Regressor, BasisInputs};

/// The effect.
pub struct Definition;

/// Its card.
pub static CARD: Card = Card {
    name: "velocity_lag",
    summary: "a segment's output lags with speed: eddy currents, filter or sampling delay",
    sizes: "5 µm at the recording's speeds, 1 µm for what grows with the square: 50 µs of a filter at 0.1 m/s; 1 µs is 1.5 µm at 1.5 m/s",
    telling_motion: "fly-bys at several speeds, with samples while the speed changes",
    needs: &[Need::Moving],
    follows: Quantity::Speed,
    coordinate: "speed",
    rigid: true,
    forms: &[Form::new("a delay that changes over a tooth", |told| told.lag_waves = true)],
    on_board: "each segment's delay, and how it changes over a tooth; what grows with the square of speed is left",
    confusable: &[
        Confusable { with: "psd_latency", parted_by: "what all segments' delays have in common is the coordination sensor's, the other way round: no motion parts these; different delays of the segments show in every fly-by" },
        Confusable { with: "hysteresis", parted_by: "at one speed a delay is a direction: the same fly-by there and back at two speeds tells" },
    ],
    ..Card::PLAIN
};

impl Effect for Definition {
    fn card(&self) -> &'static Card {
        &CARD
    }

    fn draw(&self, scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        VelocityLag::draw(scene, rng, size_rms_m)
    }

    fn shapes(&self, inputs: &BasisInputs) -> Vec<Regressor> {
        sensor_side::regressors(inputs)
    }
}
