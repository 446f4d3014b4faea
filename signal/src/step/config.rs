//! What the interrupt computes with: settings in machine units.

use crate::beacon::CompiledBeaconPose;
use crate::frame::Status;
use crate::math::{Constants, OCTANTS, Octants};
use crate::model::{CompiledModel, ErrorModel, Further, OwnPolynomial};
use crate::psd::CompiledBeacon;
use crate::quadrature::{CompiledPair, CounterLimits, PairCorrection};
use crate::settings::{ConfigError, Settings};

/// [`Settings`] in machine units: all the interrupt reads. About 1.3 KiB.
#[derive(Clone, Debug, PartialEq)]
#[repr(C)] // what every sample reads comes first, within reach of one load
pub struct StepConfig {
    /// Segments 1 and 3, 2 and 4.
    pub(super) pairs: [(CompiledPair, OwnPolynomial); 2],
    pub(super) constants: Constants,
    /// In use, and at the first sample.
    pub(super) counter: [CounterLimits; 2],
    /// Bits of the limits of the squared amplitude.
    pub(super) square_low: u32,
    pub(super) square_high: u32,
    /// Largest square of a count that is not clipped.
    pub(super) clip_square: i32,
    pub(super) dead_band_m_s: f32,
    pub(super) parity_turns: f32,
    pub(super) gap_samples: u32,
    /// Between two samples.
    pub(super) reach: Reach,
    /// Samples in a window less one; all ones for never.
    pub(super) frozen_mask: u32,
    /// [`Status::FROZEN`], or nothing if that is switched off.
    pub(super) frozen_bit: u32,
    pub(super) beacon: CompiledBeacon,
    pub(super) octants: Octants,
    pub(super) pitch_m: f32,
    pub(super) pitch_over_span: f32,
    pub(super) lateral_over_span: f32,
    /// Whether a sample needs more than equation (3).
    pub(super) beyond_own: bool,
    /// Whether a sample needs more than equations (3) and (9).
    pub(super) extended: bool,
    /// Bits that every frame has.
    pub(super) standing_bits: u32,
    pub(super) beacon_pose: Option<CompiledBeaconPose>,
    pub(super) further: Further,
}

impl StepConfig {
    /// Checks settings and converts them.
    ///
    /// # Errors
    /// The first setting that is out of range; nothing the interrupt computes with can then overflow.
    #[inline] // built with the image, for size
    pub fn build(settings: &Settings) -> Result<Self, ConfigError> {
        settings.validate()?;
        let (geometry, limits) = (&settings.geometry, &settings.limits);
        let speed_m_s = geometry.pitch_m * settings.rate_hz;
        let model = match &settings.model {
            Some(model) => CompiledModel::new(model, geometry.pitch_m),
            None => without_model(),
        };
        let beacon_pose = settings.beacon.map(|beacon| beacon.compile(geometry));
        let extended = settings.track_direction || model.further.has_rows();
        let pair = |p: usize| PairCorrection::compile([&settings.pairs[p], &settings.pairs[p + 2]]);
        let square_bits = |amplitude: f32| (amplitude * amplitude).to_bits();
        let mut standing = Status::empty();
        standing.set(Status::UNCALIBRATED, settings.model.is_none());
        standing.set(Status::CALIBRATION_DRIFT, settings.drifted);
        Ok(Self {
            pairs: [(pair(0), model.own[0]), (pair(1), model.own[1])],
            constants: Constants::VALUES,
            counter: [
                CounterLimits {
                    slip: limits.slip_turns,
                    speed_filter: 0.5 * limits.speed_filter * speed_m_s,
                },
                CounterLimits::FIRST,
            ],
            octants: OCTANTS,
            square_low: square_bits(limits.amplitude_low_counts),
            square_high: square_bits(limits.amplitude_high_counts),
            clip_square: i32::from(limits.clip_counts) * i32::from(limits.clip_counts) - 1,
            dead_band_m_s: limits.direction_dead_band_m_s,
            parity_turns: limits.parity_turns,
            gap_samples: limits.gap_samples.into(),
            reach: Reach::new(1.0 / speed_m_s),
            frozen_mask: u32::from(limits.frozen_samples / 4).wrapping_sub(1),
            frozen_bit: if limits.frozen_samples == 0 {
                0
            } else {
                Status::FROZEN.bits()
            },
            beacon: limits.beacon.compile(geometry.tan_full_scale),
            standing_bits: standing.bits(),
            beacon_pose,
            beyond_own: extended || model.further.has_lateral || beacon_pose.is_some(),
            extended,
            further: model.further,
            pitch_m: geometry.pitch_m,
            pitch_over_span: geometry.pitch_m / geometry.span_m,
            lateral_over_span: geometry.lateral_m / geometry.span_m,
        })
    }
}

#[inline(never)] // the empty model is a kilobyte of stack
fn without_model() -> CompiledModel {
    CompiledModel::new(&ErrorModel::default(), 1.0)
}

/// How far 1 m/s goes between the last good sample and this one, in turns, as bits; negative for the first sample.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) struct Reach(u32);

impl Reach {
    /// No sample came before.
    pub(super) const FIRST: Self = Self(1 << 31);

    /// From turns, not negative.
    pub(super) const fn new(turns_per_m_s: f32) -> Self {
        Self(turns_per_m_s.to_bits())
    }

    #[inline(always)]
    pub(super) const fn is_first(self) -> bool {
        (self.0 as i32) < 0
    }

    #[inline(always)]
    pub(super) const fn turns_per_m_s(self) -> f32 {
        f32::from_bits(self.0)
    }
}
