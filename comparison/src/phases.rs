//! Functions of a segment's phases where the poses are even over the true places: a segment with waves passes its phases unevenly.
//!
//! The correction e(phi) of a phase phi leads to the true one, `phi + f e(phi)`. A function u of the phase is one of the true phase, with the
//! harmonics
//!
//! ```text
//! u_k = mean over phi of  u(phi) exp(-i k (phi + f e(phi))) (1 + f e'(phi))
//! ```
//! Means of products over even true places follow from these, and so do those of two segments of a pair, whose true phases differ by d:
//! `sum_k u_k conj(v_k) exp(i k d)`, and with d even over a turn D to either side `sum_k u_k conj(v_k) sinc(k D)`.

use courier_sensor::equations::PARITY_SIGN;
use courier_sensor::frame::SEGMENTS;
use nalgebra::{Complex, DMatrix};
use std::f64::consts::TAU;

/// Harmonics that are kept: the sixth order of a segment whose phases are as uneven as an error with an inverse makes them has
/// nothing beyond that counts. Derived from the largest waves that keep an output monotonic, whose inverse has harmonics that
/// fall as Bessel functions do.
const HARMONICS: usize = 32;
/// Phases of a mean: no product of the kept harmonics and of the sixth order is taken for another. Derived from the sampling
/// theorem: order 6 times 32 and 32 conjugate reaches 70, and a mean of 128 takes 0 for 128 first.
const PHASES: usize = 128;

/// Sine and cosine of a segment's orders in the parity, and their harmonics.
pub struct Phases {
    /// `[function][harmonic]`: functions of segment 1 first, of each order its sine and cosine; harmonics 0 and above.
    harmonics: Vec<Vec<Complex<f64>>>,
    /// Functions of a segment.
    own: usize,
    orders: Vec<u8>,
}

/// Coefficients of a segment's correction as shares of a radian: sine and cosine of each order.
pub type Waves = Vec<[f64; 2]>;

impl Phases {
    /// Of segments with these corrections.
    pub fn new(orders: &[u8], waves: &[Waves; SEGMENTS]) -> Self {
        let mut harmonics = Vec::new();
        for (waves, sign) in waves.iter().zip(PARITY_SIGN) {
            let mut of_segment = vec![vec![Complex::ZERO; HARMONICS + 1]; 2 * orders.len()];
            for step in 0..PHASES {
                let phase = TAU * step as f64 / PHASES as f64;
                let (mut place, mut slope) = (phase, 1.0);
                for (order, [a, b]) in orders.iter().map(|n| f64::from(*n)).zip(waves) {
                    let (sine, cosine) = (order * phase).sin_cos();
                    place += a * sine + b * cosine;
                    slope += order * (a * cosine - b * sine);
                }
                let share = f64::from(sign) * slope / PHASES as f64;
                for harmonic in 0..=HARMONICS {
                    let wave = Complex::from_polar(share, -(harmonic as f64) * place);
                    for (pair, order) in of_segment.as_chunks_mut::<2>().0.iter_mut().zip(orders) {
                        let (sine, cosine) = (f64::from(*order) * phase).sin_cos();
                        pair[0][harmonic] += wave * sine;
                        pair[1][harmonic] += wave * cosine;
                    }
                }
            }
            harmonics.extend(of_segment);
        }
        Self {
            harmonics,
            own: 2 * orders.len(),
            orders: orders.to_vec(),
        }
    }

    /// Functions of all segments.
    pub fn count(&self) -> usize {
        self.harmonics.len()
    }

    /// Means of products, less the product of the means, which an offset takes up; a pair's phases differ by up to so much.
    pub fn products(&self, difference_rad: f64) -> DMatrix<f64> {
        self.together(|k, same| match k {
            0 => 0.0,
            _ if same => 1.0,
            k => sinc(k as f64 * difference_rad),
        })
    }

    /// Condition number of rows that hold the functions and a one for the offset: the root of that of their products.
    pub fn condition(&self, difference_rad: f64) -> f64 {
        let count = self.count();
        let about_means = self.products(difference_rad);
        let mean = |i: usize| self.harmonics.get(i).map_or(1.0, |u| u[0].re);
        let products = DMatrix::from_fn(count + 1, count + 1, |a, b| {
            mean(a) * mean(b) + about_means.get((a, b)).copied().unwrap_or(0.0)
        });
        let eigenvalues = products.symmetric_eigenvalues();
        (eigenvalues.max() / eigenvalues.min().max(f64::MIN_POSITIVE)).sqrt()
    }

    /// What the functions have in common with a unit step of the parity at the edge of the way, which is anywhere in a wave: means of products
    /// of the integrals over the true phase.
    pub fn at_edge(&self, difference_rad: f64) -> DMatrix<f64> {
        self.together(|k, _| match k {
            0 => 0.0,
            k => (sinc(0.5 * k as f64 * difference_rad) / k as f64).powi(2),
        })
    }

    /// Largest variance of a correction over segments and phases, of coefficients with this covariance.
    pub fn largest(&self, covariance: &DMatrix<f64>) -> f64 {
        let mut largest = 0.0_f64;
        for step in 0..PHASES {
            let phase = TAU * step as f64 / PHASES as f64;
            let pairs = self
                .orders
                .iter()
                .map(|n| (f64::from(*n) * phase).sin_cos());
            let functional: Vec<f64> = pairs.flat_map(|(sine, cosine)| [sine, cosine]).collect();
            for first in (0..self.count()).step_by(self.own) {
                let of_segment = covariance.view((first, first), (self.own, self.own));
                let by = |i: usize| {
                    (0..self.own)
                        .map(|j| of_segment[(i, j)] * functional[j])
                        .sum::<f64>()
                };
                let variance = (0..self.own).map(|i| functional[i] * by(i)).sum();
                largest = largest.max(variance);
            }
        }
        largest
    }

    /// Sums over the harmonics, each with a weight that may be another within a segment than within a pair; none between pairs.
    fn together(&self, weight: impl Fn(usize, bool) -> f64) -> DMatrix<f64> {
        let weights = [false, true].map(|same| {
            (0..=HARMONICS)
                .map(|k| 2.0 * weight(k, same))
                .collect::<Vec<_>>()
        });
        let count = self.count();
        let mut out = DMatrix::zeros(count, count);
        for a in 0..count {
            for b in 0..=a {
                let [one, two] = [a, b].map(|i| i / self.own);
                if (one - two) % 2 == 0 {
                    let each = self.harmonics[a].iter().zip(&self.harmonics[b]);
                    let weights = &weights[usize::from(one == two)];
                    let sum: f64 = each
                        .zip(weights)
                        .map(|((u, v), w)| w * (u.re * v.re + u.im * v.im))
                        .sum();
                    (out[(a, b)], out[(b, a)]) = (sum, sum);
                }
            }
        }
        out
    }
}

/// The sine of a number over it.
pub fn sinc(x: f64) -> f64 {
    if x.abs() < 1.0e-6 {
        1.0 - x * x / 6.0
    } else {
        x.sin() / x
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const ORDERS: [u8; 4] = [1, 2, 4, 6];
    /// Largest difference of a pair's phases.
    const DIFFERENCE_RAD: f64 = 0.5;

    /// Waves of up to 30 µm of a millimetre's pitch, others in each segment.
    fn waves() -> [Waves; SEGMENTS] {
        std::array::from_fn(|s| {
            let amplitude = |n: usize| 0.15 / (1 + n) as f64 * (1.0 + 0.2 * s as f64);
            let pair =
                |n: usize| [(s + n) as f64, 2.0 * (s + n) as f64].map(|at| amplitude(n) * at.cos());
            (0..ORDERS.len()).map(pair).collect()
        })
    }

    /// Functions of the segments at true phases of each, by a search for what is read there.
    fn at(waves: &[Waves; SEGMENTS], places: [f64; SEGMENTS]) -> Vec<f64> {
        let mut row = Vec::new();
        for s in 0..SEGMENTS {
            let correction = |phase: f64| -> f64 {
                let each = ORDERS.iter().zip(&waves[s]);
                each.map(|(n, [a, b])| {
                    a * (f64::from(*n) * phase).sin() + b * (f64::from(*n) * phase).cos()
                })
                .sum()
            };
            let (mut low, mut high) = (places[s] - 2.0, places[s] + 2.0);
            for _ in 0..50 {
                let middle = 0.5 * (low + high);
                if middle + correction(middle) < places[s] {
                    low = middle
                } else {
                    high = middle
                }
            }
            for n in ORDERS {
                let (sine, cosine) = (f64::from(n) * low).sin_cos();
                row.extend([sine, cosine].map(|u| f64::from(PARITY_SIGN[s]) * u));
            }
        }
        row
    }

    fn assert_close(found: &DMatrix<f64>, wanted: &DMatrix<f64>, within: f64) {
        let off = (found - wanted).amax();
        assert!(
            off < within * wanted.amax(),
            "{off:e} of {:e}",
            wanted.amax()
        );
    }

    /// Sums over a lattice of poses: places over a pitch, the pair's difference over its range.
    #[test]
    fn products_are_those_of_poses_that_are_even_over_places() {
        let (waves, steps) = (waves(), 48);
        let phases = Phases::new(&ORDERS, &waves);
        let count = phases.count();
        let (mut products, mut mean) = (
            DMatrix::zeros(count, count),
            nalgebra::DVector::zeros(count),
        );
        for step in 0..steps * steps {
            let place = TAU * f64::from(step % steps) / f64::from(steps);
            let half = 0.5
                * DIFFERENCE_RAD
                * (2.0 * (f64::from(step / steps) + 0.5) / f64::from(steps) - 1.0);
            // Both directions at the same place: what they have in common is not looked at.
            let row = nalgebra::DVector::from_vec(at(
                &waves,
                [place + half, place + half, place - half, place - half],
            ));
            products += &row * row.transpose() / f64::from(steps * steps);
            mean += row / f64::from(steps * steps);
        }
        let own = 2 * ORDERS.len();
        let apart = |a: usize, b: usize| (a / own).abs_diff(b / own) % 2 == 1;
        let wanted = DMatrix::from_fn(count, count, |a, b| match apart(a, b) {
            true => 0.0,
            false => products[(a, b)] - mean[a] * mean[b],
        });
        // The midpoint rule over the difference: of harmonics up to the twelfth, (12 * 0.5 / 48)^2 / 24 and some more by those beyond.
        assert_close(&phases.products(DIFFERENCE_RAD), &wanted, 3.0e-3);
        let even = Phases::new(&ORDERS, &waves.each_ref().map(|w| vec![[0.0; 2]; w.len()]));
        assert!((even.products(DIFFERENCE_RAD)[(0, 0)] - 0.5).abs() < 1e-12);
        assert!(
            (even.products(DIFFERENCE_RAD)[(0, own * 2)] + 0.5 * sinc(DIFFERENCE_RAD)).abs()
                < 1e-12
        );
        // The offset's one over the weakest: the sum of a pair's two of order 1.
        let condition = (0.5 * (1.0 - sinc(DIFFERENCE_RAD))).recip().sqrt();
        assert!((even.condition(DIFFERENCE_RAD) / condition - 1.0).abs() < 1e-9);
        assert!(phases.condition(DIFFERENCE_RAD) > condition);
    }

    /// A rest that rises evenly over whole pitches has nothing but its ends.
    #[test]
    fn a_slope_acts_as_its_ends_do() {
        let (waves, steps, starts) = (waves(), 96, 48);
        let phases = Phases::new(&ORDERS, &waves);
        let count = phases.count();
        let table: Vec<nalgebra::DVector<f64>> = (0..steps)
            .map(|k| {
                nalgebra::DVector::from_vec(at(
                    &waves,
                    [TAU * f64::from(k) / f64::from(steps); SEGMENTS],
                ))
            })
            .collect();
        let mean = table.iter().sum::<nalgebra::DVector<f64>>() / f64::from(steps);
        let mut wanted = DMatrix::zeros(count, count);
        for start in 0..starts {
            // Over one pitch, by the midpoint between the steps' ends: the rest rises by one.
            let share = |k: i32| (f64::from(k) + 0.5) / f64::from(steps);
            let one = |k: i32| {
                let [here, next] =
                    [k, k + 1].map(|k| &table[((k + start * steps / starts) % steps) as usize]);
                (0.5 * (here + next) - &mean) * (share(k) / f64::from(steps))
            };
            let mut common: nalgebra::DVector<f64> = (0..steps).map(one).sum();
            common *= TAU;
            wanted += &common * common.transpose() / f64::from(starts);
        }
        let own = 2 * ORDERS.len();
        let found = phases.at_edge(0.0);
        let wanted = DMatrix::from_fn(count, count, |a, b| {
            if (a / own).abs_diff(b / own) % 2 == 1 {
                0.0
            } else {
                wanted[(a, b)]
            }
        });
        // Trapezoids of a hundredth of a pitch under the sixth order.
        assert_close(&found, &wanted, 1.0e-2);
    }
}
