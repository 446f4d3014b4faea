//! The sensor sides of the catalogue.
pub mod adc_clipping;
pub mod angle_dependence;
pub mod axis_skew;
pub mod beacon_vibration;
pub mod extra_harmonics;
pub mod gap_variation;
pub mod hysteresis;
pub mod lateral_dependence;
pub mod psd_latency;
pub mod psd_misalignment;
pub mod psd_nonlinearity;
pub mod quadrature_drift;
pub mod span_error;
pub mod thermal_drift;
pub mod tooth_variation;
pub mod velocity_lag;

use effects::sensor::SensorEffect;

/// Every effect that has regressors.
pub fn linear() -> Vec<Box<dyn SensorEffect>> {
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
