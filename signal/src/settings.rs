//! What a user sets, in SI units, and its check; [`crate::step::StepConfig::build`] turns it into machine units.

use crate::beacon::BeaconSettings;
use crate::frame::SEGMENTS;
use crate::geometry::Geometry;
use crate::model::{ErrorModel, ModelError};
use crate::psd::BeaconLimits;
use crate::quadrature::PairCorrection;
use crate::range::{OutOfRange, within};
use serde::{Deserialize, Serialize};

/// Everything the signal path can be told.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Settings {
    /// Nominal geometry.
    pub geometry: Geometry,
    /// Sampling rate.
    pub rate_hz: f32,
    /// Known errors of each segment's pair of channels.
    pub pairs: [PairCorrection; SEGMENTS],
    /// When a reading is to be doubted.
    pub limits: Limits,
    /// Keeps the directions of travel in the frames even if the model does not need them.
    pub track_direction: bool,
    /// Where the beacon is, after a joint calibration; none: no pose relative to it.
    pub beacon: Option<BeaconSettings>,
    /// The error model in force; none: frames say [`crate::frame::Status::UNCALIBRATED`].
    pub model: Option<ErrorModel>,
    /// Frames say [`crate::frame::Status::CALIBRATION_DRIFT`].
    pub drifted: bool,
}

impl Default for Settings {
    /// The paper's geometry at 20 kHz, uncalibrated.
    fn default() -> Self {
        Self {
            geometry: Geometry::PAPER,
            rate_hz: 20_000.0,
            pairs: [PairCorrection::default(); SEGMENTS],
            limits: Limits::default(),
            track_direction: false,
            beacon: None,
            model: None,
            drifted: false,
        }
    }
}

/// When a reading is to be doubted.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Limits {
    /// Amplitude below this is low, counts.
    pub amplitude_low_counts: f32,
    /// Amplitude above this is high, counts.
    pub amplitude_high_counts: f32,
    /// A quadrature channel of this magnitude or above is clipped, counts.
    pub clip_counts: i16,
    /// A step this far from the predicted phase is a slip, turns, below 0.5. A sample's step at 1.5 m/s and 20 kHz is
    /// 0.074, so that even a start from rest to that speed within one sample passes; noise of an amplitude at its lower
    /// limit is below 0.01.
    pub slip_turns: f32,
    /// More instants than this in a row without a sample (failed conversions, missed instants) are slips, whatever the phases
    /// say: within 32 at 20 kHz an acceleration of 100 m/s² moves a courier 0.13 mm from the prediction, and another 0.13 mm
    /// since the filtered speed lags behind; a whole pitch less `slip_turns`, 0.8 mm, would pass unseen.
    pub gap_samples: u16,
    /// Share of the newest step in the filtered speed, above 0, at most 1: 1/16 averages over 0.8 ms at 20 kHz.
    pub speed_filter: f32,
    /// Slower than this keeps the direction of travel, m/s.
    pub direction_dead_band_m_s: f32,
    /// g_p of a magnitude above this means a wrong tooth count, turns. One tooth is 1; the paper's uncalibrated g_p is
    /// 0.03 rms.
    pub parity_turns: f32,
    /// Every segment is watched for a quarter of this many samples, one after the other; if one of its channels does not
    /// change at all in that time the converter is frozen. A power of two, 0: never. With 0.3 counts rms of noise the
    /// odds of 256 equal samples in a row are at most 7e-12 (0.904 each, about the middle of a count); a simulation without noise must switch it off.
    pub frozen_samples: u16,
    /// Electrodes.
    pub beacon: BeaconLimits,
}

impl Default for Limits {
    fn default() -> Self {
        Self {
            amplitude_low_counts: 4000.0,
            amplitude_high_counts: 32_000.0,
            clip_counts: 32_760,
            slip_turns: 0.2,
            gap_samples: 32,
            speed_filter: 1.0 / 16.0,
            direction_dead_band_m_s: 1.0e-3,
            parity_turns: 0.25,
            frozen_samples: 1024,
            beacon: BeaconLimits::default(),
        }
    }
}

/// Why settings cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[non_exhaustive]
pub enum ConfigError {
    /// A number is not finite or outside its range.
    #[error(transparent)]
    Range(#[from] OutOfRange),
    /// The frozen window is no power of two.
    #[error("frozen_samples is {0}, wanted 0 or a power of two from 8 to 32768")]
    FrozenSamples(u16),
    /// The coefficients of equations (3) and (9) could add up to more than half a pitch.
    #[error(
        "error model: segment {}'s coefficients add up to {sum_m} m, wanted at most half a pitch, {limit_m} m",
        segment + 1
    )]
    ModelSize {
        /// Segment, 0 to 3.
        segment: usize,
        /// Sum of the magnitudes of its coefficients.
        sum_m: f32,
        /// Half a pitch.
        limit_m: f32,
    },
    /// The error model.
    #[error("error model: {0}")]
    Model(#[from] ModelError),
}

impl Settings {
    /// Checks every number, so that the interrupt need not.
    ///
    /// # Errors
    /// The first one that is out of range.
    #[inline] // built with the image, for size
    pub fn validate(&self) -> Result<(), ConfigError> {
        self.geometry_ranges()?;
        within("rate_hz", self.rate_hz, 1.0, 1.0e6)?;
        for pair in &self.pairs {
            pair.validate()?;
        }
        self.limits.validate()?;
        if let Some(beacon) = &self.beacon {
            let [x_m, y_m] = beacon.origin_m;
            within("beacon.origin_m", x_m, -100.0, 100.0)?;
            within("beacon.origin_m", y_m, -100.0, 100.0)?;
            within("beacon.segment_sd_m", beacon.segment_sd_m, 1.0e-9, 1.0e-3)?;
            within(
                "beacon.displacement_sd_m",
                beacon.displacement_sd_m,
                1.0e-9,
                1.0e-3,
            )?;
        }
        self.model
            .iter()
            .try_for_each(|model| self.check_model(model))
    }

    #[inline] // built with the image, for size
    fn check_model(&self, model: &ErrorModel) -> Result<(), ConfigError> {
        model.validate()?;
        let limit_m = 0.5 * self.geometry.pitch_m;
        for segment in 0..SEGMENTS {
            let sum_m = model.bound_m(segment);
            if sum_m > limit_m {
                return Err(ConfigError::ModelSize {
                    segment,
                    sum_m,
                    limit_m,
                });
            }
        }
        Ok(())
    }

    #[inline] // built with the image, for size
    fn geometry_ranges(&self) -> Result<(), OutOfRange> {
        let g = &self.geometry;
        within("pitch_m", g.pitch_m, 1.0e-5, 0.1)?;
        within("span_m", g.span_m, 1.0e-4, 1.0)?;
        within("lateral_m", g.lateral_m, -1.0, 1.0)?;
        within("height_m", g.height_m, 1.0e-4, 10.0)?;
        within("lever_m", g.lever_m[0], -10.0, 10.0)?;
        within("lever_m", g.lever_m[1], -10.0, 10.0)?;
        within("tan_full_scale", g.tan_full_scale, 1.0e-6, 100.0)
    }
}

impl Limits {
    #[inline] // built with the image, for size
    fn validate(&self) -> Result<(), ConfigError> {
        within(
            "amplitude_low_counts",
            self.amplitude_low_counts,
            0.0,
            46_341.0,
        )?;
        within(
            "amplitude_high_counts",
            self.amplitude_high_counts,
            self.amplitude_low_counts,
            1.0e6,
        )?;
        within("clip_counts", f32::from(self.clip_counts), 1.0, 32_767.0)?;
        within("slip_turns", self.slip_turns, 0.01, 0.499)?;
        within("speed_filter", self.speed_filter, 1.0e-4, 1.0)?;
        within(
            "direction_dead_band_m_s",
            self.direction_dead_band_m_s,
            0.0,
            100.0,
        )?;
        within("parity_turns", self.parity_turns, 0.01, 1.0e6)?;
        within(
            "beacon.sum_low_counts",
            self.beacon.sum_low_counts as f32,
            1.0,
            65_534.0,
        )?;
        within(
            "beacon.clip_counts",
            f32::from(self.beacon.clip_counts),
            1.0,
            32_767.0,
        )?;
        let n = self.frozen_samples;
        if n != 0 && !(n.is_power_of_two() && n >= 8) {
            return Err(ConfigError::FrozenSamples(n));
        }
        Ok(())
    }
}
