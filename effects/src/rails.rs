//! A pair whose channels saturate: what its counts tell of its rails, and the phase that it gives.

use core::f64::consts::TAU;
use serde::{Deserialize, Serialize};

/// A pair whose channels saturate. An amplifier and a converter have a rail at either end, and an offset shifts the wave against
/// them: any of the four may cut, none needs to.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Clip {
    /// Lower and upper rail of the sine, then of the cosine, of the amplitude, from the electrical zero: signed.
    pub rails: [[f64; 2]; 2],
    /// Offset of sine and cosine, gain of the sine less one, quadrature angle (rad) of the wave before it is cut, of the amplitude.
    pub pair: [f64; 4],
    /// Softness of the rails, 0 (hard) to about 0.7: the reciprocal of the exponent in [`saturated`]. An amplifier of
    /// tanh's shape has 0.5.
    #[serde(default)]
    pub knee: f64,
    /// Found against a reference: electrical phase at the reference's zero,
    /// rad, and delay, s.
    pub zero_and_delay: Option<[f64; 2]>,
}

impl Clip {
    /// A rail that nothing reaches, of the amplitude. A derivation: with 13 % of gain and 6 % of offset, the most that is known
    /// of a pair, its wave ends at 1.2.
    pub const OPEN: f64 = 3.0;
    /// Below this a knee is narrower than the noise: a hundredth of the rail or so.
    pub const HARD: f64 = 0.02;
}

/// What a cut phase depends on: lower and upper rail of sine and cosine, then offsets, gain of the sine less one, quadrature
/// angle and knee, of an amplitude of 1.
pub type Parts = [f64; 9];

/// Rails among [`Parts`]. A definition: two channels with two ends each.
pub const RAILS: usize = 4;
/// The knee among [`Parts`]. A definition: it is the last of them.
pub const KNEE: usize = 8;

/// Rails and pair of a clip in one.
#[must_use]
pub fn parts(clip: &Clip) -> Parts {
    let [[a, b], [c, d]] = clip.rails;
    let [e, f, g, h] = clip.pair;
    [a, b, c, d, e, f, g, h, clip.knee]
}

/// A channel between two rails, of an amplitude of 1. As an amplifier saturates (Rapp 1991):
/// `v / (1 + |v / rail|^(1/knee))^knee`, whose slope falls from 1 to 0 and whose limit at a knee of zero is the hard clip.
#[must_use]
pub fn saturated(value: f64, [lower, upper]: [f64; 2], knee: f64) -> f64 {
    let rail = if value < 0.0 { -lower } else { upper };
    if rail >= Clip::OPEN {
        value
    } else if knee < Clip::HARD {
        value.signum() * value.abs().min(rail)
    } else {
        value * (1.0 + (value.abs() / rail).powf(1.0 / knee)).powf(-knee)
    }
}

/// Error of the phase, rad, of a pair with such [`Parts`].
#[must_use]
pub fn phase_error(phase: f64, p: &Parts) -> f64 {
    let sine = (1.0 + p[6]) * (phase + p[7]).sin() + p[4];
    let cosine = phase.cos() + p[5];
    let sine = saturated(sine, [p[0], p[1]], p[KNEE]);
    let cosine = saturated(cosine, [p[2], p[3]], p[KNEE]);
    let error = sine.atan2(cosine) - phase;
    error - TAU * (error / TAU).round()
}
