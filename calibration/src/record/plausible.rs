//! Which numbers a record may hold. The board checks them before it takes a calibration, and a host before it sends one.
//!
//! Pairs of channels and the sum of coefficients are checked with the settings ([`courier_signal::settings::Settings::validate`]).

use super::number::Number;
use super::{Calibration, RecordError};
use crate::geometry::Geometry;
use crate::model::ModelError;

/// Range in which the board's parts may be stored, degrees Celsius: -65 to 150 by the data sheets of the converter and of the
/// processor.
const TEMPERATURES_C: [f32; 2] = [-65.0, 150.0];
/// Hypotenuse of two channels at the converter's end, counts. Derived from 16 bits: √2 · 32,768.
const LARGEST_AMPLITUDE_COUNTS: f32 = 46_341.0;
/// Any finite number: the settings' check has its limits.
const FINITE: [f32; 2] = [f32::MIN, f32::MAX];
/// A length of a courier or a platen, metres. A prior: none is as long as that.
const LONGEST_M: f32 = 100.0;

/// Beyond the inverse of the precision of the numbers nothing is solved.
const LARGEST_CONDITION: f32 = 1.0 / f32::EPSILON;

impl Calibration {
    /// Checks that every number can be used.
    ///
    /// # Errors
    /// [`RecordError::Model`] or [`RecordError::Range`].
    pub fn validate(&self) -> Result<(), RecordError> {
        self.model.validate()?;
        check(self)
    }
}

/// Checks every number.
fn check(calibration: &Calibration) -> Result<(), RecordError> {
    let (g, q) = (&calibration.geometry, &calibration.quality);
    let geometry = [
        g.pitch_m,
        g.span_m,
        g.lateral_m,
        g.height_m,
        g.lever_m[0],
        g.lever_m[1],
        g.tan_full_scale,
    ];
    all(
        Number::TemperatureC,
        &[calibration.temperature_c],
        TEMPERATURES_C,
    )?;
    all(
        Number::AmplitudeCounts,
        &calibration.amplitude_counts,
        [0.0, LARGEST_AMPLITUDE_COUNTS],
    )?;
    all(Number::Geometry, &geometry, [-LONGEST_M, LONGEST_M])?;
    for pair in &calibration.pairs {
        let [offset_sine, offset_cosine] = pair.offset_counts;
        let numbers = [offset_sine, offset_cosine, pair.gain, pair.angle_rad];
        all(Number::Pairs, &numbers, FINITE)?;
    }
    if let Some(beacon) = &calibration.beacon {
        let deviations = [beacon.segment_sd_m, beacon.displacement_sd_m];
        all(
            Number::BeaconOriginM,
            &beacon.origin_m,
            [-LONGEST_M, LONGEST_M],
        )?;
        // Of full scale: more is no correction.
        all(Number::BeaconSensor, &beacon.sensor, [-1.0, 1.0])?;
        all(Number::BeaconDeviationM, &deviations, [0.0, LONGEST_M])?;
    }
    if let Some(poses) = &calibration.poses {
        let range = [poses.range.travel_m, poses.range.turn_rad];
        all(Number::PosesRange, &range, [0.0, LONGEST_M])?;
    }
    let lengths = [q.residual_before_m, q.residual_after_m, q.predicted_worst_m];
    all(Number::QualityM, &lengths, [0.0, LONGEST_M])?;
    all(
        Number::ConditionNumber,
        &[q.condition_number],
        [0.0, LARGEST_CONDITION],
    )
}

/// Checks that a calibration can be of this board's sensor, whose geometry is `own`: its own geometry, and each coefficient.
///
/// A coefficient corrects at most half a pitch in ordinary use ([`Term::ordinary_factor`](crate::model::Term::ordinary_factor)): beyond,
/// it would be the next tooth.
///
/// A segment spans nearly as many teeth as the pairs lie apart. If the pitch is off by a whole tooth over that length, the teeth cancel
/// and the segment reads nothing: such a pitch is another sensor's. A span of half or twice as much is so as well.
///
/// # Errors
/// [`RecordError::Range`], [`RecordError::Model`].
pub fn check_sensor(calibration: &Calibration, own: &Geometry) -> Result<(), RecordError> {
    let Calibration {
        geometry, model, ..
    } = calibration;
    let off_m = own.pitch_m * own.pitch_m / own.span_m;
    let pitches_m = [own.pitch_m - off_m, own.pitch_m + off_m];
    let spans_m = [0.5 * own.span_m, 2.0 * own.span_m];
    all(Number::PitchM, &[geometry.pitch_m], pitches_m)?;
    all(Number::SpanM, &[geometry.span_m], spans_m)?;
    let rows = model.terms.iter().zip(&model.coefficients);
    for (term, (row_of, rows)) in rows.enumerate() {
        let limit = 0.5 * own.pitch_m / row_of.ordinary_factor();
        for (segment, row) in rows.iter().enumerate() {
            if let Some(value) = row.iter().find(|value| value.abs() > limit) {
                return Err(RecordError::Model(ModelError::Coefficient {
                    segment,
                    term: Some(term),
                    value: *value,
                    limit,
                }));
            }
        }
    }
    Ok(())
}

/// Not a number fails as well.
#[inline(never)] // one copy, for size
fn all(number: Number, values: &[f32], [low, high]: [f32; 2]) -> Result<(), RecordError> {
    match values.iter().find(|value| !(low..=high).contains(*value)) {
        None => Ok(()),
        Some(value) => Err(RecordError::Range {
            number,
            value: *value,
            low,
            high,
        }),
    }
}
