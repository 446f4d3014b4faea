//! The catalogue of effects: one file each, with the plant side and the sensor side, which do not call each other.
//!
//! Adding an effect: one file and one line of the list below. `unlisted` holds effects that no diagnosis knows, for blind
//! tests of its answer `unknown`.

pub mod motion;
pub mod over;
pub mod plant;
pub mod random;
pub mod sensor;
pub mod shape;
pub mod teeth;
pub mod unlisted;

use plant::Draw;

/// One line of the catalogue.
#[derive(Clone, Copy, Debug)]
pub struct Entry {
    /// Name, as in the diagnosis' output.
    pub name: &'static str,
    /// What it is.
    pub summary: &'static str,
    /// Draws the plant's side.
    pub draw: Draw,
}

/// Declares each effect's module and its line of [`CATALOGUE`].
macro_rules! catalogue {
    ($($module:ident :: $plant:ident, $summary:literal;)*) => {
        $(pub mod $module;)*

        /// Every catalogued effect.
        pub const CATALOGUE: &[Entry] = &[
            $(Entry { name: stringify!($module), summary: $summary, draw: $module::$plant::draw },)*
        ];
    };
}

catalogue! {
    lateral_dependence::LateralDependence, "a segment's output depends on the tooth phase across it";
    extra_harmonics::ExtraHarmonics, "orders of the own tooth phase that equation (3) leaves out";
    tooth_variation::ToothVariation, "single teeth of the platen are displaced";
    angle_dependence::AngleDependence, "the error's harmonics change with theta";
    psd_nonlinearity::PsdNonlinearity, "cubic, quadratic and cross terms of the coordination sensor";
    psd_misalignment::PsdMisalignment, "the diode is turned in its mount, or its axes differ in gain";
    thermal_drift::ThermalDrift, "offsets and scale follow temperature";
    velocity_lag::VelocityLag, "a segment's output lags with speed: eddy currents, filter or sampling delay";
    psd_latency::PsdLatency, "the coordination sensor is sampled earlier or later than the platen sensor";
    hysteresis::Hysteresis, "the output depends on the direction of travel, not on the speed";
    gap_variation::GapVariation, "platen flatness or tilt changes amplitude, and the error with it";
    beacon_vibration::BeaconVibration, "the beacon or its mount vibrates at one or a few frequencies";
    axis_skew::AxisSkew, "the platen's two rulings differ in pitch, or are not square";
    cycle_slip::CycleSlip, "a tooth count is off by whole teeth from some moment on";
    outlier_bursts::OutlierBursts, "short disturbances far outside the noise";
    excess_noise::ExcessNoise, "white noise above the stated level";
    adc_clipping::AdcClipping, "a quadrature channel saturates";
    quadrature_drift::QuadratureDrift, "offset, gain or phase of a pair wander with time";
    span_error::SpanError, "the segments do not sit where the drawing says";
}

/// The catalogue's line of a name.
#[must_use]
pub fn entry(name: &str) -> Option<&'static Entry> {
    CATALOGUE.iter().find(|entry| entry.name == name)
}

/// The sensor's sides, of every effect that adds something to the readings; slips, bursts and noise are judged directly.
#[must_use]
pub fn sensor_sides() -> Vec<Box<dyn sensor::SensorEffect>> {
    vec![
        Box::new(adc_clipping::ClipModel),
        Box::new(lateral_dependence::LateralModel),
        Box::new(extra_harmonics::HarmonicsModel),
        Box::new(angle_dependence::AngleModel),
        Box::new(psd_nonlinearity::DeflectionModel),
        Box::new(psd_misalignment::MountingModel),
        Box::new(thermal_drift::WarmthModel),
        Box::new(velocity_lag::LagModel),
        Box::new(psd_latency::LatencyModel),
        Box::new(hysteresis::DirectionModel),
        Box::new(gap_variation::GapModel),
        Box::new(beacon_vibration::VibrationModel),
        Box::new(axis_skew::RulingModel),
        Box::new(quadrature_drift::WanderModel),
        Box::new(span_error::SpanModel),
        Box::new(tooth_variation::FieldModel),
    ]
}
