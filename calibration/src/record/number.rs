//! The numbers of a record that can be wrong.

/// A number of a record that can be wrong.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[allow(missing_docs)] // their texts say it
pub enum Number {
    #[error("temperature_c")]
    TemperatureC,
    #[error("amplitude_counts")]
    AmplitudeCounts,
    #[error("geometry.pitch_m")]
    PitchM,
    #[error("geometry.span_m")]
    SpanM,
    #[error("geometry (a length or the full scale)")]
    Geometry,
    #[error("pairs")]
    Pairs,
    #[error("beacon.origin_m")]
    BeaconOriginM,
    #[error("beacon.sensor")]
    BeaconSensor,
    #[error("beacon (a standard deviation, metres)")]
    BeaconDeviationM,
    #[error("quality (a residual or deviation, metres)")]
    QualityM,
    #[error("quality.condition_number")]
    ConditionNumber,
    #[error("poses.range (metres or radians)")]
    PosesRange,
}
