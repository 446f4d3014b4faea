//! The interrupt's elementary functions: f32 polynomials and Newton steps, the same bits on host and target.
//!
//! Nothing here calls libm except [`sqrt`] on the host; nothing is fused; nothing branches on data. Angles are in turns,
//! so that range reduction is exact.

/// 1.5 * 2^23: adding it to an f32 of magnitude below 2^22 leaves the nearest integer (ties to even) in the low bits.
const ROUND: f32 = 12_582_912.0;

/// Nearest integer, as f32 and as i32. Exact for |x| < 2^22; 4 cycles.
#[inline(always)]
pub fn round(x: f32) -> (f32, i32) {
    let shifted = x + ROUND;
    (
        shifted - ROUND,
        (shifted.to_bits() as i32).wrapping_sub(ROUND.to_bits() as i32),
    )
}

/// Sine and cosine of an angle in turns, |turns| < 2^20; error below 1.5e-7.
///
/// Minimax polynomials on ±1/8 turn after an exact reduction. About 30 cycles.
#[inline(always)]
pub fn sincos_turns(turns: f32) -> (f32, f32) {
    let (quarters, quadrant) = round(4.0 * turns);
    let r = turns - 0.25 * quarters;
    let z = r * r;
    let sine = r * (6.283_185_2 + z * (-41.341_628 + z * (81.588_07 + z * -75.237_74)));
    let cosine = 1.0 + z * (-19.739_167 + z * (64.923_18 + z * -83.663_08));
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

/// `1 / sqrt(x)` for 1e-30 < x < 1e30, relative error below 1e-6; finite for any x >= 0.
///
/// Seed by exponent arithmetic and two Newton steps, the first with minimax coefficients (Moroz et al. 2018): 10
/// operations where VSQRT and VDIV would take 28 cycles.
#[inline(always)]
pub fn inverse_sqrt(x: f32) -> f32 {
    let seed = f32::from_bits(0x5F1F_FFF9_u32.wrapping_sub(x.to_bits() >> 1));
    let first = 0.703_952_25 * seed * (2.389_244_6 - x * seed * seed);
    first * (1.5 - 0.5 * x * first * first)
}

/// Square root, correctly rounded: VSQRT on the target, libm on the host, the same bits.
#[inline(always)]
pub fn sqrt(x: f32) -> f32 {
    #[cfg(target_os = "none")]
    {
        crate::board::fpu::sqrt(x)
    }
    #[cfg(not(target_os = "none"))]
    {
        libm::sqrtf(x)
    }
}

/// Per octant: cosine and sine of its centre, and the centre in turns.
///
/// Index: bit 0 |sine| > |cosine|, bit 1 sine < 0, bit 2 cosine < 0.
const OCTANTS: [[f32; 3]; 8] = {
    const C: f32 = 0.923_879_5;
    const S: f32 = 0.382_683_43;
    [
        [C, S, 0.0625],
        [S, C, 0.1875],
        [C, -S, -0.0625],
        [S, -C, -0.1875],
        [-C, S, 0.4375],
        [-S, C, 0.3125],
        [-C, -S, -0.4375],
        [-S, -C, -0.3125],
    ]
};

/// Phase of the unit vector (`sine`, `cosine`) in turns, -0.5 to 0.5; error below 2e-7 turns for a unit length within 1e-6.
///
/// The vector is turned to its octant's centre, where the sine of the rest (at most sin(pi/8)) goes through an odd
/// minimax arcsine: no division, no branch. About 25 cycles.
#[inline(always)]
pub fn phase_turns(sine: f32, cosine: f32) -> f32 {
    let (s, c) = (sine.to_bits(), cosine.to_bits());
    let octant = ((s << 1) > (c << 1)) as u32 | (s >> 31) << 1 | (c >> 31) << 2;
    let [centre_cosine, centre_sine, centre_turns] = OCTANTS[(octant & 7) as usize];
    let t = sine * centre_cosine - cosine * centre_sine;
    let z = t * t;
    centre_turns
        + t * (0.159_154_84 + z * (0.026_535_204 + z * (0.011_713_856 + z * 0.009_013_116)))
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
        assert!(worst < 1.0e-6, "{worst:e}");
        assert!(inverse_sqrt(0.0).is_finite());
    }

    #[test]
    fn phase_turns_is_within_its_stated_error_all_around() {
        let mut worst = 0.0_f64;
        for k in 0..2_000_000 {
            let (s, c) = (f64::from(k) * TAU / 2.0e6).sin_cos();
            let (s, c) = (s as f32, c as f32);
            let exact = f64::from(s).atan2(f64::from(c)) / TAU;
            let error = f64::from(phase_turns(s, c)) - exact;
            worst = worst.max((error - error.round()).abs());
        }
        assert!(worst < 2.0e-7, "{worst:e}");
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
