//! Errors of the open-loop controller: the courier stands where the motors' field and friction leave it.

use core::f64::consts::TAU;
use effects::motion::Pose;
use effects::random::{ChaCha8Rng, normal, uniform};
use effects::shape::Waves;

/// Open-loop command error and settling.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct OpenLoop {
    /// Rms of the error that depends on the place, metres: the motors' field and the platen's, smooth over half a metre.
    pub place_error_m: f64,
    /// Rms of the random part at each stop, metres: friction against a motor stiffness of some N/um.
    pub stop_error_m: f64,
    /// Amplitude of the motor's own periodic error (detent), metres.
    pub detent_m: f64,
    /// Amplitude of the ringing after a stop, metres.
    pub ringing_m: f64,
    /// Frequency of the ringing, hertz: courier mass on the motor's stiffness.
    pub ringing_hz: f64,
    /// Its decay time, seconds: air bearing and eddy currents damp within a few periods.
    pub decay_s: f64,
}

/// Arm over which errors of position make errors of angle, metres: the motors' distance.
const ARM_M: f64 = 0.1;

impl OpenLoop {
    /// Tens of micrometres, settled to 0.1 % of its ringing within a quarter of a second.
    pub const COURIER: Self = Self {
        place_error_m: 20.0e-6,
        stop_error_m: 2.0e-6,
        detent_m: 8.0e-6,
        ringing_m: 15.0e-6,
        ringing_hz: 40.0,
        decay_s: 0.03,
    };

    /// Goes exactly where it is told.
    pub const EXACT: Self = Self {
        place_error_m: 0.0,
        stop_error_m: 0.0,
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

    /// Random part of where a stop misses its target by.
    pub(super) fn stop_error(&self, rng: &mut ChaCha8Rng) -> Pose {
        let error = Pose::new(normal(rng), normal(rng), normal(rng) / ARM_M);
        Pose::default().plus(error, self.stop_error_m)
    }

    /// Direction and size of a stop's ringing.
    pub(super) fn ringing(&self, rng: &mut ChaCha8Rng) -> Pose {
        let (sine, cosine) = uniform(rng, 0.0, TAU).sin_cos();
        Pose::default().plus(
            Pose::new(cosine, sine, uniform(rng, -1.0, 1.0) / ARM_M),
            self.ringing_m,
        )
    }

    /// Detent at a commanded pose: periodic with the motors' pitch.
    pub(super) fn detent(&self, pose: Pose, pitch_m: f64) -> Pose {
        if self.detent_m == 0.0 {
            return Pose::default();
        }
        let wave = |place: f64| self.detent_m * (TAU * place / pitch_m).sin();
        Pose::new(wave(pose.x_m), wave(pose.y_m), 0.0)
    }

    /// Error of a stop by its place; between two stops it goes over evenly.
    pub(super) fn error_at(&self, place: &PlaceError, stop: Pose) -> Pose {
        let [x, y, turn] = place.at(stop);
        Pose::default().plus(Pose::new(x, y, turn / ARM_M), self.place_error_m)
    }
}

/// The error that depends on the place: x, y and angle, each of rms 1.
#[derive(Clone, Debug)]
pub struct PlaceError {
    parts: [Waves<2>; 3],
}

impl PlaceError {
    /// Wavelengths of 0.5 to 2 m: the platen's level, the cable's pull, the motors' common field.
    pub fn draw(rng: &mut ChaCha8Rng) -> Self {
        Self {
            parts: [(); 3].map(|()| Waves::draw(rng, 3, 0.5, 2.0)),
        }
    }

    /// Error at a commanded pose.
    #[must_use]
    pub fn at(&self, pose: Pose) -> [f64; 3] {
        [0, 1, 2].map(|i| self.parts[i].at([pose.x_m, pose.y_m]))
    }
}
