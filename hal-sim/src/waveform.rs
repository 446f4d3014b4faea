//! A segment's error over its own tooth phase, and its inversion: true displacement to unmodified output.
//!
//! Equation (3)'s error `e` is a function of the unmodified output and is added to it: `p + e(p) = p*`. The plant knows
//! the right side and needs `p`. It is solved once, on a grid over one pitch, and interpolated. A measured waveform is
//! steeper than any inversion allows (adjacent codes of real tables differ by a tenth of the rms and more), so it is taken
//! over the true displacement, `p = p* - e(p*)`, which every waveform has.

use core::f64::consts::TAU;
use effects::shape::cubic;

/// A segment's error over one pitch, metres.
#[derive(Clone, Debug, PartialEq)]
pub enum Waveform {
    /// Equation (3): `k_0` to `k_8`, metres, in its order: offset, then sine and cosine of orders 1, 2, 4 and 6.
    Equation3([f64; 9]),
    /// Equally spaced values over one pitch of the true displacement, metres, periodic, cubic between them.
    Table(Vec<f64>),
}

/// Orders of equation (3) in its order.
pub const ORDERS: [f64; 4] = [1.0, 2.0, 4.0, 6.0];

impl Waveform {
    /// Error at a phase in turns, metres: of the unmodified output for equation (3), of the true displacement for a table.
    #[must_use]
    pub fn at(&self, turns: f64) -> f64 {
        match self {
            Self::Equation3(k) => {
                let phase = TAU * (turns - turns.floor());
                let term = |(order, pair): (f64, &[f64])| {
                    let (sine, cosine) = (order * phase).sin_cos();
                    pair[0] * sine + pair[1] * cosine
                };
                k[0] + ORDERS
                    .into_iter()
                    .zip(k[1..].chunks_exact(2))
                    .map(term)
                    .sum::<f64>()
            }
            Self::Table(values) => {
                let count = values.len();
                let place = (turns - turns.floor()) * count as f64;
                let cell = place as usize;
                let point = |offset: usize| values[(cell + count - 1 + offset) % count];
                cubic(
                    [point(0), point(1), point(2), point(3)],
                    place - cell as f64,
                )
            }
        }
    }

    /// Rms over the pitch with the mean removed, metres.
    #[must_use]
    pub fn rms_m(&self) -> f64 {
        let values: Vec<f64> = (0..GRID).map(|i| self.at(i as f64 / GRID as f64)).collect();
        let mean = values.iter().sum::<f64>() / GRID as f64;
        (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / GRID as f64).sqrt()
    }
}

/// Points of the inversion's grid. Hermite cubics on it are exact to below a picometre for equation (3) at 40 um, and to
/// below a nanometre for measured waveforms with orders up to 255.
const GRID: usize = 4096;

/// Steepest fall of an error that is inverted: beyond, the output would rise twenty times as fast as the displacement.
const STEEPEST: f64 = -0.95;

/// An error so steep that the output no longer rises with the displacement.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the error waveform falls by {slope:.2} m a metre at {turns:.3} turns: wanted above {STEEPEST}, or the output is not unique"
)]
pub struct NotMonotonic {
    /// Slope of the error there.
    pub slope: f64,
    /// Where, turns of the pitch.
    pub turns: f64,
}

/// The inverse of a waveform: `p - p*` over the phase of `p*`.
#[derive(Clone, Debug)]
pub struct Inverse {
    /// `(value, slope * cell)` at each grid point, metres.
    grid: Vec<[f64; 2]>,
    pitch_m: f64,
}

impl Inverse {
    /// Solves the waveform over one pitch.
    ///
    /// # Errors
    /// [`NotMonotonic`] where the waveform has no unique inverse.
    pub fn new(waveform: &Waveform, pitch_m: f64) -> Result<Self, NotMonotonic> {
        let points = match waveform {
            Waveform::Equation3(_) => solved(waveform, pitch_m)?,
            Waveform::Table(_) => (0..GRID)
                .map(|i| -waveform.at(i as f64 / GRID as f64))
                .collect(),
        };
        let slope = |i: usize| 0.5 * (points[(i + 1) % GRID] - points[(i + GRID - 1) % GRID]);
        Ok(Self {
            grid: (0..GRID).map(|i| [points[i], slope(i)]).collect(),
            pitch_m,
        })
    }

    /// Unmodified output for a true displacement, metres.
    #[must_use]
    pub fn unmodified_m(&self, true_m: f64) -> f64 {
        let turns = true_m / self.pitch_m;
        let place = (turns - turns.floor()) * GRID as f64;
        let cell = (place as usize).min(GRID - 1);
        let t = place - cell as f64;
        let ([a, da], [b, db]) = (self.grid[cell], self.grid[(cell + 1) % GRID]);
        let (gap, s) = (b - a, 1.0 - t);
        // Hermite cubic: the line, plus what the end slopes differ from it by.
        true_m + a + t * gap + t * s * (s * (da - gap) - t * (db - gap))
    }
}

/// `p - p*` at each grid point of `p*`, metres, where the waveform is a function of `p`.
fn solved(waveform: &Waveform, pitch_m: f64) -> Result<Vec<f64>, NotMonotonic> {
    let step = 0.25 / GRID as f64;
    let mut reach = 0.0_f64;
    for i in 0..GRID {
        let turns = i as f64 / GRID as f64;
        let slope =
            (waveform.at(turns + step) - waveform.at(turns - step)) / (2.0 * step * pitch_m);
        if !(slope > STEEPEST) {
            return Err(NotMonotonic { slope, turns });
        }
        reach = reach.max(waveform.at(turns).abs());
    }
    let reach = 1.1 * reach / pitch_m + 1.0e-9;
    let point = |i: usize| {
        let wanted = i as f64 / GRID as f64;
        let miss = |turns: f64| turns + waveform.at(turns) / pitch_m - wanted;
        let bracket = (wanted - reach, wanted + reach);
        (bisect(&miss, bracket, near(&miss, bracket)) - wanted) * pitch_m
    };
    Ok((0..GRID).map(point).collect())
}

/// Root of a rising function within a bracket, to the last bit that matters (60 halvings). What lies outside `near`, a bracket within the
/// first, is not looked at again.
fn bisect(
    function: &impl Fn(f64) -> f64,
    (mut low, mut high): (f64, f64),
    near: Option<(f64, f64)>,
) -> f64 {
    let (below, above) = near.unwrap_or((f64::NEG_INFINITY, f64::INFINITY));
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if middle == low || middle == high {
            // No number lies between them: further halvings change nothing.
            break;
        }
        if middle <= below || middle < above && function(middle) < 0.0 {
            low = middle
        } else {
            high = middle
        }
    }
    0.5 * (low + high)
}

/// Half the width of the bracket that [`near`] finds: far more than a function's rounding, and by 33 halvings less than a waveform's reach.
const NEAR: f64 = 1.0e-13;

/// A narrow bracket of the root by some steps of a secant; none if these do not lead there.
fn near(function: &impl Fn(f64) -> f64, (low, high): (f64, f64)) -> Option<(f64, f64)> {
    let (mut before, mut at) = (low, 0.5 * (low + high));
    let (mut miss_before, mut miss) = (function(before), function(at));
    for _ in 0..8 {
        let step = miss * (at - before) / (miss - miss_before);
        (before, miss_before) = (at, miss);
        at -= step;
        miss = function(at);
        if step.abs() < NEAR {
            break;
        }
    }
    let bracket = (at - NEAR, at + NEAR);
    let inside = low <= bracket.0 && bracket.1 <= high;
    (inside && function(bracket.0) < 0.0 && function(bracket.1) >= 0.0).then_some(bracket)
}

#[cfg(test)]
mod tests {
    use super::*;

    const PITCH_M: f64 = 1.016e-3;

    fn worst_m(waveform: &Waveform) -> f64 {
        let inverse = Inverse::new(waveform, PITCH_M).unwrap();
        let miss = |i: i32| {
            let true_m = f64::from(i) * 1.237e-6 - 2.0e-3;
            let p = inverse.unmodified_m(true_m);
            let at = if matches!(waveform, Waveform::Table(_)) {
                true_m
            } else {
                p
            };
            (p + waveform.at(at / PITCH_M) - true_m).abs()
        };
        (0..4000).map(miss).fold(0.0, f64::max)
    }

    #[test]
    fn unmodified_output_plus_its_error_is_the_displacement() {
        let k = [3e-6, 20e-6, -15e-6, 9e-6, 6e-6, -3e-6, 2e-6, 1e-6, -1e-6];
        assert!(worst_m(&Waveform::Equation3(k)) < 1e-12);
        let rough = |i: i32| {
            let phase = f64::from(i) * TAU / 512.0;
            4e-6 * (12.0 * phase).sin() + 0.3e-6 * (80.0 * phase).cos()
        };
        let rough = (0..512).map(rough).collect();
        assert!(worst_m(&Waveform::Table(rough)) < 1e-9);
    }

    /// Steep ones too, and one that no secant follows.
    #[test]
    fn a_narrow_bracket_leads_to_the_same_bits() {
        let looks = core::cell::Cell::new(0);
        for scale in [0.0, 0.1, 1.0, 2.0] {
            let k = [3e-6, 20e-6, -15e-6, 9e-6, 6e-6, -3e-6, 2e-6, 1e-6, -1e-6];
            let waveform = Waveform::Equation3(k.map(|k| scale * k));
            for i in 0..500 {
                let wanted = f64::from(i) / 499.0;
                let miss = |turns: f64| {
                    looks.set(looks.get() + 1);
                    turns + waveform.at(turns) / PITCH_M - wanted
                };
                let bracket = (wanted - 0.12, wanted + 0.12);
                let plain = bisect(&miss, bracket, None);
                let begin = looks.get();
                let quick = bisect(&miss, bracket, near(&miss, bracket));
                assert_eq!(plain.to_bits(), quick.to_bits(), "{scale} {wanted}");
                let took = looks.get() - begin;
                assert!(took < 50, "{took} looks");
            }
        }
        let step = |x: f64| if x < 0.3 { -1.0 } else { 1.0 };
        let found = bisect(&step, (0.0, 1.0), near(&step, (0.0, 1.0)));
        assert_eq!(found, bisect(&step, (0.0, 1.0), None));
    }

    #[test]
    fn a_waveform_without_an_inverse_is_refused() {
        let mut k = [0.0; 9];
        k[7] = 40e-6;
        let refused = Inverse::new(&Waveform::Equation3(k), PITCH_M).unwrap_err();
        assert!(refused.slope < -0.95, "{refused}");
    }
}
