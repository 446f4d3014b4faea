//! What the interrupt computes with: settings in machine units.

use crate::beacon::CompiledBeaconPose;
use crate::frame::Status;
use crate::math::{Constants, OCTANTS, Octants};
use crate::model::{Further, OwnPolynomial};
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
    /// Of zeros, so that a static of it lies in .bss and not in flash; of no use before [`StepConfig::set`].
    pub const UNSET: Self = Self {
        pairs: [(CompiledPair::ZERO, OwnPolynomial::ZERO); 2],
        constants: Constants::ZERO,
        counter: [CounterLimits::ZERO; 2],
        square_low: 0,
        square_high: 0,
        clip_square: 0,
        dead_band_m_s: 0.0,
        parity_turns: 0.0,
        gap_samples: 0,
        reach: Reach(0),
        frozen_mask: 0,
        frozen_bit: 0,
        beacon: CompiledBeacon::ZERO,
        octants: [[0.0; 4]; 8],
        pitch_m: 0.0,
        pitch_over_span: 0.0,
        lateral_over_span: 0.0,
        beyond_own: false,
        extended: false,
        standing_bits: 0,
        beacon_pose: None,
        further: Further::NONE,
    };

    /// Checks settings and converts them.
    ///
    /// # Errors
    /// The first setting that is out of range; nothing the interrupt computes with can then overflow.
    #[inline] // built with the image, for size
    pub fn build(settings: &Settings) -> Result<Self, ConfigError> {
        let mut set = Self::UNSET;
        set.set(settings)?;
        Ok(set)
    }

    /// The same in its place: a set is more than a kilobyte of stack.
    ///
    /// # Errors
    /// As [`StepConfig::build`]; nothing is changed.
    #[inline] // built with the image, for size
    pub fn set(&mut self, settings: &Settings) -> Result<(), ConfigError> {
        settings.validate()?;
        let (geometry, limits) = (&settings.geometry, &settings.limits);
        let speed_m_s = geometry.pitch_m * settings.rate_hz;
        let square_bits = |amplitude: f32| (amplitude * amplitude).to_bits();
        let own = self.further.set(settings.model.as_ref(), geometry.pitch_m);
        for (p, (pair, polynomial)) in self.pairs.iter_mut().enumerate() {
            *pair = PairCorrection::compile([&settings.pairs[p], &settings.pairs[p + 2]]);
            *polynomial = own[p];
        }
        (self.constants, self.octants) = (Constants::VALUES, OCTANTS);
        self.counter = [
            CounterLimits {
                slip: limits.slip_turns,
                speed_filter: 0.5 * limits.speed_filter * speed_m_s,
            },
            CounterLimits::FIRST,
        ];
        self.square_low = square_bits(limits.amplitude_low_counts);
        self.square_high = square_bits(limits.amplitude_high_counts);
        self.clip_square = i32::from(limits.clip_counts) * i32::from(limits.clip_counts) - 1;
        self.dead_band_m_s = limits.direction_dead_band_m_s;
        self.parity_turns = limits.parity_turns;
        self.gap_samples = limits.gap_samples.into();
        self.reach = Reach::new(1.0 / speed_m_s);
        self.frozen_mask = u32::from(limits.frozen_samples / 4).wrapping_sub(1);
        self.frozen_bit = match limits.frozen_samples {
            0 => 0,
            _ => Status::FROZEN.bits(),
        };
        self.beacon = limits.beacon.compile(geometry.tan_full_scale);
        let mut standing = Status::empty();
        standing.set(Status::UNCALIBRATED, settings.model.is_none());
        standing.set(Status::CALIBRATION_DRIFT, settings.drifted);
        self.standing_bits = standing.bits();
        self.beacon_pose = settings.beacon.map(|beacon| beacon.compile(geometry));
        self.extended = settings.track_direction || self.further.has_rows();
        self.beyond_own = self.extended || self.further.has_lateral || self.beacon_pose.is_some();
        self.pitch_m = geometry.pitch_m;
        self.pitch_over_span = geometry.pitch_m / geometry.span_m;
        self.lateral_over_span = geometry.lateral_m / geometry.span_m;
        Ok(())
    }
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
