//! What a simulated courier is built from.

use crate::electronics::Electronics;
use crate::waveform::Waveform;
use courier_sensor::device::Device;
use effects::motion::Pose;
use effects::plant::{Geometry, PlantEffect, SEGMENTS};

/// Board temperature over time: warm-up after switching on, and the room's slow swing.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Temperature {
    /// At switching on, Celsius; also the reference temperature of the calibration.
    pub start_c: f64,
    /// Rise by the electronics' own heat, kelvin.
    pub rise_k: f64,
    /// Time constant of the rise, seconds.
    pub time_constant_s: f64,
    /// Amplitude of the room's swing, kelvin.
    pub swing_k: f64,
    /// Its period, seconds.
    pub swing_period_s: f64,
}

impl Temperature {
    /// A board on an aluminium courier in a laboratory: a few kelvin in minutes, air conditioning in tens of minutes.
    pub const LABORATORY: Self = Self {
        start_c: 22.0,
        rise_k: 4.0,
        time_constant_s: 240.0,
        swing_k: 0.3,
        swing_period_s: 700.0,
    };

    /// Temperature at a time, Celsius.
    #[must_use]
    pub fn at_c(&self, time_s: f64) -> f64 {
        let warm = 1.0 - (-time_s.max(0.0) / self.time_constant_s).exp();
        let swing = (core::f64::consts::TAU * time_s / self.swing_period_s).sin();
        self.start_c + self.rise_k * warm + self.swing_k * swing
    }
}

/// The interferometer's own noise, rms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Interferometer {
    /// Of a position, metres: air turbulence over half a metre of beam, some 20 nm.
    pub position_noise_m: f64,
    /// Of the angle, radians: two beams 50 mm apart give sqrt(2) * 20 nm / 50 mm.
    pub angle_noise_rad: f64,
}

impl Interferometer {
    /// The laboratory's.
    pub const LABORATORY: Self = Self {
        position_noise_m: 20.0e-9,
        angle_noise_rad: 0.6e-6,
    };
}

/// Where on the platen the usual runs take place.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Places {
    /// Corner of the square that the scatter covers, ten pitches a side.
    pub scatter_corner: Pose,
    /// Middle of the 40 mm fly-bys.
    pub flyby: Pose,
    /// Pose at which the coordination sensor stands under the beacon.
    pub beacon: Pose,
    /// Middle of the 8 mm sweeps under the beacon.
    pub beacon_sweep: Pose,
}

impl Default for Places {
    /// Scatter from the origin, fly-bys through its middle, the beacon over the origin.
    fn default() -> Self {
        let middle_m = 5.0 * Geometry::PAPER.pitch_m;
        Self {
            scatter_corner: Pose::default(),
            flyby: Pose::new(middle_m, middle_m, 0.0),
            beacon: Pose::default(),
            beacon_sweep: Pose::default(),
        }
    }
}

/// A simulated courier, before it is switched on.
pub struct CourierSpec {
    /// Free text for recordings.
    pub device: String,
    /// Number by which its board introduces itself.
    pub number: Device,
    /// True geometry.
    pub geometry: Geometry,
    /// What the drawing says: what a recording states and a calibration starts from.
    pub nominal: Geometry,
    /// Pose at which the coordination sensor stands under the beacon; `None` without one.
    pub beacon_over: Option<Pose>,
    /// Where its usual runs take place.
    pub places: Places,
    /// Converter scales and noise.
    pub electronics: Electronics,
    /// Each segment's error over its own phase.
    pub waveforms: [Waveform; SEGMENTS],
    /// Board temperature.
    pub temperature: Temperature,
    /// Reference.
    pub interferometer: Interferometer,
    /// Everything else that is wrong with it, in the order of application.
    pub effects: Vec<Box<dyn PlantEffect>>,
}

impl CourierSpec {
    /// A flawless courier of the drawing's geometry, with a beacon over the origin.
    #[must_use]
    pub fn flawless() -> Self {
        Self {
            device: "simulated courier".into(),
            number: Device(*b"simulated-01"),
            geometry: Geometry::PAPER,
            nominal: Geometry::PAPER,
            beacon_over: Some(Pose::default()),
            places: Places::default(),
            electronics: Electronics::BOARD,
            waveforms: [const { Waveform::Equation3([0.0; 9]) }; SEGMENTS],
            temperature: Temperature::LABORATORY,
            interferometer: Interferometer::LABORATORY,
            effects: Vec::new(),
        }
    }
}
