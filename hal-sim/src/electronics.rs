//! Electronics of the sensor board: converter scales and noise, each with its reason.

use effects::plant::{Channels, Codes};
use effects::random::{ChaCha8Rng, normal};

/// Scales and noise of the two simultaneous 16-bit converters.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Electronics {
    /// Amplitude of the quadrature pairs, counts.
    pub amplitude_counts: f64,
    /// White noise of a quadrature channel before rounding, rms counts.
    pub quadrature_noise_counts: f64,
    /// Sum of the two electrodes of an axis, counts.
    pub psd_sum_counts: f64,
    /// White noise of an electrode before rounding, rms counts.
    pub psd_noise_counts: f64,
}

impl Electronics {
    /// The simulated board.
    ///
    /// - Amplitude 20 000 of 32 767: leaves room for the 6 % offset and 13 % gain mismatch seen in the field.
    /// - Quadrature noise 20 counts: 1e-3 of the amplitude is 0.16 um, which is what limits the paper's sensor to a
    ///   resolution of 0.2 um, one part in 5000 of a pitch.
    /// - Electrode sum 30 000: full deflection stays inside the converter.
    /// - Electrode noise 2 counts: sqrt(2) * 2 / 30 000 of the half range h * full scale = 5 mm is 0.5 um; the
    ///   coordination sensor is said to be "sub-micron" (Ma 1998, as the paper cites it).
    pub const BOARD: Self = Self {
        amplitude_counts: 20_000.0,
        quadrature_noise_counts: 20.0,
        psd_sum_counts: 30_000.0,
        psd_noise_counts: 2.0,
    };

    /// The same without any noise but rounding.
    #[must_use]
    pub fn quiet(self) -> Self {
        Self {
            quadrature_noise_counts: 0.0,
            psd_noise_counts: 0.0,
            ..self
        }
    }

    /// Adds the white noise of every channel. One draw a channel, in a fixed order, so that a changed level changes
    /// nothing else.
    pub(crate) fn add_noise(&self, rng: &mut ChaCha8Rng, channels: &mut Channels) {
        for value in channels.quadrature.iter_mut().flatten() {
            *value += self.quadrature_noise_counts * normal(rng);
        }
        for value in &mut channels.electrodes {
            *value += self.psd_noise_counts * normal(rng);
        }
    }
}

/// 16-bit conversion: nearest code, saturating at both ends.
pub(crate) fn convert(channels: &Channels) -> Codes {
    // `as` saturates.
    let code = |counts: f64| counts.round() as i16;
    Codes {
        quadrature: channels.quadrature.map(|pair| pair.map(code)),
        electrodes: channels.electrodes.map(code),
    }
}
