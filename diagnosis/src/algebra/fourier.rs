//! Fourier sums of values at uneven places for many frequencies at once: each value is spread over an even grid by a Gaussian,
//! the grid is transformed, and what spreading did is undone (Dutt and Rokhlin 1993; Greengard and Lee 2004).

use rustfft::num_complex::Complex;
use rustfft::{Fft, FftPlanner};
use std::sync::Arc;

/// Grid points to either side that a value is spread over. With a grid of twice what the highest order needs the sums are right
/// to exp(-2 pi / 3) to this power: 1e-9 of the sum of the values' magnitudes. Derived from that power: the sums are then more
/// exact than positions in metres are written.
const REACH: usize = 10;
/// Square of the Gaussian's width, grid points, that makes what is cut off and what folds back alike. Derived from both
/// exponents, which are equal at this width.
const WIDTH: f64 = 4.0 * REACH as f64 / (3.0 * std::f64::consts::PI);

/// Orders 0 to a highest one.
pub struct Orders {
    transform: Arc<dyn Fft<f64>>,
    grid: usize,
    /// The Gaussian at whole distances.
    gaussian: [f64; REACH + 1],
    /// Square of what spreading takes from each order, inverted.
    restored: Vec<f64>,
}

impl Orders {
    /// For orders up to `highest`.
    pub fn new(highest: usize) -> Self {
        let grid = 3 * (4 * (highest + 1)).div_ceil(3).next_power_of_two().max(8);
        let scale = 1.0 / (std::f64::consts::PI * WIDTH);
        let restored = (0..=highest).map(|order| {
            let turn = std::f64::consts::PI * order as f64 / grid as f64;
            scale * (2.0 * WIDTH * turn * turn).exp()
        });
        Self {
            transform: FftPlanner::new().plan_fft_forward(grid),
            grid,
            gaussian: std::array::from_fn(|l| (-((l * l) as f64) / WIDTH).exp()),
            restored: restored.collect(),
        }
    }

    /// Squared magnitude of the sum at each order, of points that are a place (turns of order 1) and a value. Of complex values
    /// the squares of real and imaginary parts' own sums are added: two series cost one transform. Cost: points times
    /// twenty, and the transform.
    pub fn powers(&self, points: impl Iterator<Item = (f64, Complex<f64>)>) -> Vec<f64> {
        let grid = self.transformed(points);
        let square = |k: usize| grid[k % self.grid].norm_sqr();
        let orders = self.restored.iter().enumerate();
        orders
            .map(|(k, restored)| 0.5 * restored * (square(k) + square(self.grid - k)))
            .collect()
    }

    /// Squared magnitude of the sum of complex values at each order, each value turned back by so many turns of its place.
    pub fn turned_back(&self, points: impl Iterator<Item = (f64, Complex<f64>)>) -> Vec<f64> {
        let grid = self.transformed(points);
        let orders = self.restored.iter().zip(grid);
        orders.map(|(by, sum)| by * sum.norm_sqr()).collect()
    }

    fn transformed(&self, points: impl Iterator<Item = (f64, Complex<f64>)>) -> Vec<Complex<f64>> {
        let mut grid = vec![Complex::default(); self.grid];
        for (turns, value) in points {
            self.spread(turns, value, &mut grid);
        }
        self.transform.process(&mut grid);
        grid
    }

    fn spread(&self, turns: f64, value: Complex<f64>, grid: &mut [Complex<f64>]) {
        let at = turns.rem_euclid(1.0) * self.grid as f64;
        let first = at as usize;
        let beyond = at - first as f64;
        let here = value * (-beyond * beyond / WIDTH).exp();
        let step = (2.0 * beyond / WIDTH).exp();
        let (mut above, mut below) = (1.0, 1.0);
        grid[first % self.grid] += here;
        for (l, gaussian) in self.gaussian.iter().enumerate().skip(1) {
            above *= step;
            below /= step;
            grid[(first + l) % self.grid] += here * (above * gaussian);
            grid[(first + self.grid - l) % self.grid] += here * (below * gaussian);
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::f64::consts::TAU;

    #[test]
    fn sums_are_those_of_their_definition() {
        let points: Vec<(f64, f64, f64)> = (0..200)
            .map(|i| {
                let i = f64::from(i);
                let place = (i * 0.618_034).fract() * 2.7 - 0.4;
                (place, (3.0 * i).sin(), (0.7 * i * i).cos())
            })
            .collect();
        let orders = Orders::new(500);
        let both = points.iter().map(|(x, a, b)| (*x, Complex::new(*a, *b)));
        let magnitudes: f64 = points.iter().map(|(_, a, b)| a.abs() + b.abs()).sum();
        for (order, power) in orders.powers(both).into_iter().enumerate() {
            let sum = |value: &dyn Fn(&(f64, f64, f64)) -> f64| {
                let turned = points.iter().map(|p| {
                    let angle = TAU * order as f64 * p.0;
                    Complex::from_polar(value(p), angle)
                });
                turned.sum::<Complex<f64>>().norm_sqr()
            };
            let wanted = sum(&|p| p.1) + sum(&|p| p.2);
            let error = (power.sqrt() - wanted.sqrt()).abs();
            assert!(error < 1e-8 * magnitudes, "{order}: {power} {wanted}");
        }
        let both = points.iter().map(|(x, a, b)| (*x, Complex::new(*a, *b)));
        for (order, power) in orders.turned_back(both).into_iter().enumerate() {
            let back = |p: &(f64, f64, f64)| {
                let angle = -TAU * order as f64 * p.0;
                Complex::new(p.1, p.2) * Complex::from_polar(1.0, angle)
            };
            let wanted = points.iter().map(back).sum::<Complex<f64>>().norm();
            let error = (power.sqrt() - wanted).abs();
            assert!(error < 1e-8 * magnitudes, "{order}: {power} {wanted}");
        }
    }
}
