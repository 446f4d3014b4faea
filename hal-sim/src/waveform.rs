//! A segment's error over its own tooth phase, and its inversion: true displacement to unmodified output.
//!
//! The error `e` is a function of the unmodified output and is added to it (equation 3): `p + e(p) = p*`. The plant knows
//! the right side and needs `p`. It is solved once, on a grid over one pitch, and interpolated.

use core::f64::consts::TAU;
use effects::shape::cubic;

/// A segment's error over one pitch, metres.
#[derive(Clone, Debug, PartialEq)]
pub enum Waveform {
    /// Equation (3): `k_0` to `k_8`, metres, in its order: offset, then sine and cosine of orders 1, 2, 4 and 6.
    Equation3([f64; 9]),
    /// Equally spaced values over one pitch, periodic, cubic between them.
    Table(Vec<f64>),
}

/// Orders of equation (3) in its order.
pub const ORDERS: [f64; 4] = [1.0, 2.0, 4.0, 6.0];

impl Waveform {
    /// Error at an unmodified output given in turns of the pitch, metres.
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

/// An error so steep that the output no longer rises with the displacement.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error(
    "the error waveform falls by {slope:.2} m a metre at {turns:.3} turns: wanted above -0.95, or the output is not unique"
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
        let step = 0.25 / GRID as f64;
        let slope = |turns: f64| {
            (waveform.at(turns + step) - waveform.at(turns - step)) / (2.0 * step * pitch_m)
        };
        let mut reach = 0.0_f64;
        for i in 0..GRID {
            let turns = i as f64 / GRID as f64;
            let slope = slope(turns);
            if !(slope > -0.95) {
                return Err(NotMonotonic { slope, turns });
            }
            reach = reach.max(waveform.at(turns).abs());
        }
        let reach_turns = 1.1 * reach / pitch_m + 1.0e-9;
        let point = |i: usize| {
            let wanted = i as f64 / GRID as f64;
            let turns = bisect(
                |p| p + waveform.at(p) / pitch_m - wanted,
                wanted - reach_turns,
                wanted + reach_turns,
            );
            let rise = 1.0 / (1.0 + slope(turns)) - 1.0;
            [(turns - wanted) * pitch_m, rise * pitch_m / GRID as f64]
        };
        Ok(Self {
            grid: (0..GRID).map(point).collect(),
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

/// Root of a rising function within a bracket, to the last bit that matters (60 halvings).
fn bisect(function: impl Fn(f64) -> f64, mut low: f64, mut high: f64) -> f64 {
    for _ in 0..60 {
        let middle = 0.5 * (low + high);
        if function(middle) < 0.0 {
            low = middle
        } else {
            high = middle
        }
    }
    0.5 * (low + high)
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
            (p + waveform.at(p / PITCH_M) - true_m).abs()
        };
        (0..4000).map(miss).fold(0.0, f64::max)
    }

    #[test]
    fn unmodified_output_plus_its_error_is_the_displacement() {
        let k = [3e-6, 20e-6, -15e-6, 9e-6, 6e-6, -3e-6, 2e-6, 1e-6, -1e-6];
        assert!(worst_m(&Waveform::Equation3(k)) < 1e-12);
        let rough = (0..512)
            .map(|i| 10e-6 * (f64::from(i) * 0.31).sin() * (f64::from(i) * TAU / 512.0).cos())
            .collect();
        assert!(worst_m(&Waveform::Table(rough)) < 1e-9);
    }

    #[test]
    fn a_waveform_without_an_inverse_is_refused() {
        let mut k = [0.0; 9];
        k[7] = 40e-6;
        let refused = Inverse::new(&Waveform::Equation3(k), PITCH_M).unwrap_err();
        assert!(refused.slope < -0.95, "{refused}");
    }
}
