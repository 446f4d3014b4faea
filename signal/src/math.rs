//! The interrupt's elementary functions: f32 polynomials and Newton steps, the same bits on host and target.
//!
//! Nothing here calls libm except [`sqrt`] on the host; nothing is fused; nothing branches on data. Angles are in turns,
//! so that range reduction is exact.

use crate::lanes::{Lanes, Real};

/// 1.5 * 2^23: adding it to an f32 of magnitude below 2^22 leaves the nearest integer (ties to even) in the low bits. A
/// derivation: there an f32's last bit counts ones.
const ROUND: f32 = 12_582_912.0;

/// The numbers that these functions compute with. The interrupt has them beside its coefficients and loads them in a row:
/// literals would be loaded one by one, each for twice as long.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Constants {
    inverse_sqrt: [f32; 4],
    phase: [f32; 3],
    round: f32,
}

impl Constants {
    /// For a static, before [`Constants::VALUES`] are put there.
    pub const ZERO: Self = Self {
        inverse_sqrt: [0.0; 4],
        phase: [0.0; 3],
        round: 0.0,
    };

    pub const VALUES: Self = Self {
        inverse_sqrt: [-0.313_070_83, 1.315_490_9, -2.191_769_7, 2.189_349],
        phase: [0.014_032_675, 0.026_364_435, 0.159_158],
        round: ROUND,
    };

    /// Nearest integer of |x| < 2^22, and the number whose bits hold it for [`integer`].
    #[inline(always)]
    pub fn nearest<R: Real>(&self, x: R) -> (R, R) {
        let shifted = x + self.round;
        (shifted - self.round, shifted)
    }
}

/// The integer in the second result of [`nearest`].
#[inline(always)]
pub(crate) fn integer(shifted: f32) -> i32 {
    (shifted.to_bits() as i32).wrapping_sub(ROUND.to_bits() as i32)
}

/// Nearest integer of |x| < 2^22, as f32 and as i32. 4 cycles.
#[inline(always)]
pub fn round(x: f32) -> (f32, i32) {
    let (whole, shifted) = Constants::VALUES.nearest(x);
    (whole, integer(shifted))
}

/// Sine and cosine of an angle in turns, |turns| < 2^20; error below 1.5e-7.
///
/// Minimax polynomials on ±1/8 turn after an exact reduction. About 30 cycles.
#[inline(always)]
pub fn sincos_turns(turns: f32) -> (f32, f32) {
    let (quarters, shifted) = Constants::VALUES.nearest(4.0 * turns);
    let (sine, cosine) = sincos_near_zero(turns - 0.25 * quarters);
    into_quadrant(integer(shifted), sine, cosine)
}

/// The same of two angles, which takes a third less than twice as long.
#[inline(always)]
pub(crate) fn sincos_turns_of_two(turns: Lanes) -> [(f32, f32); 2] {
    let (quarters, shifted) = Constants::VALUES.nearest(turns * 4.0);
    let (sine, cosine) = sincos_near_zero(turns - quarters * 0.25);
    [0, 1].map(|k| into_quadrant(integer(shifted.0[k]), sine.0[k], cosine.0[k]))
}

/// Polynomials on ±1/8 turn.
#[inline(always)]
fn sincos_near_zero<R: Real>(r: R) -> (R, R) {
    let z = r * r;
    let sine = r * (z * (z * (z * -75.237_74 + 81.588_07) - 41.341_628) + 6.283_185_2);
    let cosine = z * (z * (z * -83.663_08 + 64.923_18) - 19.739_167) + 1.0;
    (sine, cosine)
}

/// Sine and cosine so many quarters of a turn further on.
#[inline(always)]
fn into_quadrant(quadrant: i32, sine: f32, cosine: f32) -> (f32, f32) {
    let (s, c) = if quadrant & 1 == 0 {
        (sine, cosine)
    } else {
        (cosine, sine)
    };
    let flip_sine = ((quadrant & 2) as u32) << 30;
    let flip_cosine = ((quadrant.wrapping_add(1) & 2) as u32) << 30;
    (
        f32::from_bits(s.to_bits() ^ flip_sine),
        f32::from_bits(c.to_bits() ^ flip_cosine),
    )
}

/// `1 / sqrt(x)` for 1e-30 < x < 1e30, relative error below 1.2e-6; finite for any x >= 0.
///
/// Seed y by exponent arithmetic, then y times a minimax polynomial for 1/sqrt on the range of x y² (0.932 to 1.070):
/// 9 operations where VSQRT and VDIV take 28 cycles.
#[inline(always)]
pub fn inverse_sqrt<R: Real>(x: R) -> R {
    Constants::VALUES.inverse_sqrt(x)
}

impl Constants {
    /// As [`inverse_sqrt`].
    #[inline(always)]
    pub fn inverse_sqrt<R: Real>(&self, x: R) -> R {
        let [a, b, c, d] = self.inverse_sqrt;
        let seed = x.map_bits(|bits| 0x5F37_59DF_u32.wrapping_sub(bits >> 1));
        let e = x * seed * seed;
        (e * (e * (e * a + b) + c) + d) * seed
    }
}

/// Square root, correctly rounded: VSQRT on the target, libm on the host, the same bits.
#[inline(always)]
pub fn sqrt(x: f32) -> f32 {
    #[cfg(target_os = "none")]
    {
        crate::arm::fpu::sqrt(x)
    }
    #[cfg(not(target_os = "none"))]
    {
        libm::sqrtf(x)
    }
}

/// Per octant: cosine and sine of its centre, the centre in turns, and nothing (for the size of a power of two).
pub(crate) type Octants = [[f32; 4]; 8];

/// Index: 7, less 1 where |sine| > |cosine|, less 2 where sine < 0, less 4 where cosine < 0. The interrupt has them beside
/// its coefficients: a place in flash would take two instructions to name.
pub(crate) const OCTANTS: Octants = {
    const C: f32 = 0.923_879_5;
    const S: f32 = 0.382_683_43;
    [
        [-S, -C, -0.3125, 0.0],
        [-C, -S, -0.4375, 0.0],
        [-S, C, 0.3125, 0.0],
        [-C, S, 0.4375, 0.0],
        [S, -C, -0.1875, 0.0],
        [C, -S, -0.0625, 0.0],
        [S, C, 0.1875, 0.0],
        [C, S, 0.0625, 0.0],
    ]
};

/// Phases of two unit vectors in turns, -0.5 to 0.5; error below 2.5e-7 turns for a length within 1e-6 of one.
///
/// `difference` has the sign of cosine² - sine². Each vector is turned to its octant's centre, where the sine of the
/// rest (at most sin(pi/8)) goes through an odd minimax arcsine (error 1.7e-7): no division, no branch.
#[inline(always)]
pub(crate) fn phase_turns(
    constants: &Constants,
    octants: &Octants,
    sine: Lanes,
    cosine: Lanes,
    difference: Lanes,
) -> Lanes {
    let [a, b, c] = constants.phase;
    // -1 for a negative number: an arithmetic shift needs no mask.
    let negative = |of: Lanes, i: usize| (of.bits()[i] as i32) >> 31;
    let centre = [0, 1].map(|i| {
        let signs = 2 * (2 * negative(cosine, i) + negative(sine, i)) + negative(difference, i);
        octants[(7 + signs) as usize & 7]
    });
    let t = sine * Lanes::new(|i| centre[i][0]) - cosine * Lanes::new(|i| centre[i][1]);
    let z = t * t;
    t * (z * (z * a + b) + c) + Lanes::new(|i| centre[i][2])
}

/// Phase of a vector of any length within f32's square roots in turns, -0.5 to 0.5; error below 2.5e-7; 0.0625 for (0, 0).
pub fn atan2_turns(sine: f32, cosine: f32) -> f32 {
    let inverse = inverse_sqrt(sine * sine + cosine * cosine + 1.0e-30);
    let (s, c) = (sine * inverse, cosine * inverse);
    phase_turns(
        &Constants::VALUES,
        &OCTANTS,
        Lanes([s; 2]),
        Lanes([c; 2]),
        Lanes([c * c - s * s; 2]),
    )
    .0[0]
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn sincos_turns_is_within_its_stated_error() {
        let mut worst = 0.0_f64;
        for k in -400_000..=400_000 {
            let turns = k as f32 * 1.234_567e-5;
            let (s, c) = sincos_turns(turns);
            let exact = (f64::from(turns) * TAU).sin_cos();
            worst = worst
                .max((f64::from(s) - exact.0).abs())
                .max((f64::from(c) - exact.1).abs());
        }
        assert!(worst < 1.5e-7, "{worst:e}");
    }

    #[test]
    fn inverse_sqrt_is_within_its_stated_error() {
        let mut worst = 0.0_f64;
        let mut x = 1.0e-30_f32;
        while x < 1.0e30 {
            worst = worst.max((f64::from(inverse_sqrt(x)) * f64::from(x).sqrt() - 1.0).abs());
            x *= 1.000_1;
        }
        assert!(worst < 1.2e-6, "{worst:e}");
        assert!(inverse_sqrt(0.0).is_finite());
    }

    #[test]
    fn atan2_turns_is_within_its_stated_error_all_around() {
        let mut worst = 0.0_f64;
        for k in 0..2_000_000 {
            let (s, c) = (f64::from(k) * TAU / 2.0e6).sin_cos();
            let (s, c) = (s as f32, c as f32);
            let exact = f64::from(s).atan2(f64::from(c)) / TAU;
            let error = f64::from(atan2_turns(s, c)) - exact;
            worst = worst.max((error - error.round()).abs());
        }
        assert!(worst < 2.5e-7, "{worst:e}");
    }

    #[test]
    fn round_is_to_nearest() {
        for k in -3_000_000..3_000_000 {
            let x = k as f32 * 0.37;
            let (whole, n) = round(x);
            assert_eq!(whole, libm::rintf(x));
            assert_eq!(n, whole as i32);
        }
    }
}
