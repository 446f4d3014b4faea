//! Errors of the open-loop controller: the courier stands where the motor's field and friction leave it.

use core::f64::consts::TAU;
use effects::motion::Pose;
use effects::random::{ChaCha8Rng, normal, uniform};

/// Open-loop command error and settling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenLoop {
    /// Rms of the random part at each stop, metres: friction against a motor stiffness of some N/mm.
    pub stop_error_m: f64,
    /// Rms of the angle's part, radians: the same over an arm of 0.1 m.
    pub stop_error_rad: f64,
    /// Amplitude of the motor's own periodic error (detent), metres.
    pub detent_m: f64,
    /// Amplitude of the ringing after a stop, metres.
    pub ringing_m: f64,
    /// Frequency of the ringing, hertz: courier mass on the motor's stiffness.
    pub ringing_hz: f64,
    /// Its decay time, seconds: air bearing and eddy currents damp within a few periods.
    pub decay_s: f64,
}

impl OpenLoop {
    /// Tens of micrometres, settled to below 10 nm within a quarter of a second.
    pub const COURIER: Self = Self {
        stop_error_m: 25.0e-6,
        stop_error_rad: 0.2e-3,
        detent_m: 8.0e-6,
        ringing_m: 15.0e-6,
        ringing_hz: 40.0,
        decay_s: 0.03,
    };

    /// Goes exactly where it is told.
    pub const EXACT: Self = Self {
        stop_error_m: 0.0,
        stop_error_rad: 0.0,
        detent_m: 0.0,
        ringing_m: 0.0,
        ringing_hz: 1.0,
        decay_s: 1.0,
    };

    /// Time after which the ringing is below 0.1 % of its start.
    #[must_use]
    pub fn settling_s(&self) -> f64 {
        7.0 * self.decay_s
    }

    /// Where a stop misses its target by.
    pub fn stop_error(&self, rng: &mut ChaCha8Rng) -> Pose {
        Pose::new(
            self.stop_error_m * normal(rng),
            self.stop_error_m * normal(rng),
            self.stop_error_rad * normal(rng),
        )
    }

    /// Direction and phase of a stop's ringing, as a pose of unit size (angle over an arm of 0.1 m).
    pub fn ringing(&self, rng: &mut ChaCha8Rng) -> Pose {
        let direction = uniform(rng, 0.0, TAU);
        let (sine, cosine) = direction.sin_cos();
        Pose::new(
            self.ringing_m * cosine,
            self.ringing_m * sine,
            10.0 * self.ringing_m * uniform(rng, -1.0, 1.0),
        )
    }

    /// Detent at a commanded pose: periodic with the motor's pitch.
    #[must_use]
    pub fn detent(&self, pose: Pose, pitch_m: f64) -> Pose {
        if self.detent_m == 0.0 {
            return Pose::default();
        }
        let wave = |place: f64| self.detent_m * (TAU * place / pitch_m).sin();
        Pose::new(wave(pose.x_m), wave(pose.y_m), 0.0)
    }
}
