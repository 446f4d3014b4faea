//! The figure that a pair draws where nothing cuts it: an ellipse near a circle.

use super::rails::Rails;
use crate::algebra::statistics::median;
use nalgebra::{SMatrix, SVector};
use std::f64::consts::PI;

/// Amplitude, offsets, gain of the sine less one and angle of a pair: `sine = A (o_s + (1 + g) sin(φ + a))`, `cosine = A (o_c + cos φ)`.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Figure {
    /// Of the cosine, counts.
    pub amplitude: f64,
    /// Offset of sine and cosine, gain of the sine less one, quadrature angle (rad), of the amplitude.
    pub pair: [f64; 4],
}

/// A pair that is cut: its rails, which its readings pile up at, and the figure that it would draw without them.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct CutFigure {
    /// Lower and upper rail of sine and cosine, counts, where there is one.
    pub rails_counts: Rails,
    /// What the readings below the rails draw.
    pub figure: Figure,
}

/// Logarithm of the amplitude, then the pair. A definition: one and four.
const FIGURE_PARAMETERS: usize = 5;
type FigureParameters = SVector<f64, FIGURE_PARAMETERS>;

/// This near to a rail, of it, a reading may be bent by a rail that is soft.
const NEAR_RAIL: f64 = 0.01;
/// Fewer readings that are whole tell no amplitude. Derived from the five unknowns: six readings to each, and what the arcs leave
/// open is held by `PRIOR`.
const FEWEST_WHOLE_READINGS: usize = 30;
/// What a few arcs near the diagonals do not tell of offsets, gain and angle is held by this share of a reading. A prior: they
/// are some hundredths, and readings lie about the figure by some thousandths, so that a flaw weighs as a tenth squared of a
/// reading.
const PRIOR: f64 = 0.01;
/// A bound on the work: what eight steps of Gauss and Newton leave open is told as it is.
const FIT_ROUNDS: usize = 8;

impl Figure {
    /// Sine and cosine at a phase, counts.
    #[must_use]
    pub fn at(&self, phase_rad: f64) -> [f64; 2] {
        let [sine, cosine, gain, angle] = self.pair;
        [
            sine + (1.0 + gain) * (phase_rad + angle).sin(),
            cosine + phase_rad.cos(),
        ]
        .map(|value| self.amplitude * value)
    }

    /// The point of the figure at a cosine, counts, on the side of the sine's sign.
    #[must_use]
    pub fn at_cosine(&self, cosine: f64, side: f64) -> [f64; 2] {
        let x = cosine / self.amplitude - self.pair[1];
        self.at(x.clamp(-1.0, 1.0).acos().copysign(side))
    }

    /// The point of the figure at a sine, counts, on the side of the cosine's sign.
    #[must_use]
    pub fn at_sine(&self, sine: f64, side: f64) -> [f64; 2] {
        let [offset, _, gain, angle] = self.pair;
        let x = (sine / self.amplitude - offset) / (1.0 + gain);
        let right = x.clamp(-1.0, 1.0).asin();
        let turned = if side < 0.0 { PI - right } else { right };
        self.at(turned - angle)
    }

    /// By the readings away from the rails; where there are none, a circle of the usual amplitude.
    pub fn of_whole(
        pairs: &[[f64; 2]],
        rails: &Rails,
        usual: impl Fn() -> Option<f64>,
    ) -> Option<Self> {
        let below = |value: f64, rail: &Option<f64>| {
            rail.is_none_or(|r| value * r.signum() < (1.0 - NEAR_RAIL) * r.abs())
        };
        let whole: Vec<[f64; 2]> = pairs
            .iter()
            .filter(|p| (0..2).all(|c| rails[c].iter().all(|r| below(p[c], r))))
            .copied()
            .collect();
        if whole.len() < FEWEST_WHOLE_READINGS {
            return usual().map(|amplitude| Self {
                amplitude,
                pair: [0.0; 4],
            });
        }
        let mut radii: Vec<f64> = whole.iter().map(|p| p[0].hypot(p[1])).collect();
        let mut p = FigureParameters::zeros();
        p[0] = median(&mut radii)?.ln();
        for _ in 0..FIT_ROUNDS {
            p += step(&whole, &p)?;
        }
        Some(Self {
            amplitude: p[0].exp(),
            pair: [p[1], p[2], p[3], p[4]],
        })
    }
}

/// Distance of a reading from the figure, of the amplitude.
fn distance(p: &FigureParameters, [sine, cosine]: &[f64; 2]) -> f64 {
    let per_amplitude = (-p[0]).exp();
    let x = cosine * per_amplitude - p[2];
    let turned = (sine * per_amplitude - p[1]) / (1.0 + p[3]);
    let y = (turned - x * p[4].sin()) / p[4].cos();
    x.hypot(y) - 1.0
}

/// One step of Gauss and Newton; readings far outside the common scatter count by its breadth alone.
fn step(whole: &[[f64; 2]], p: &FigureParameters) -> Option<FigureParameters> {
    let off: Vec<f64> = whole.iter().map(|pair| distance(p, pair)).collect();
    let mut sizes: Vec<f64> = off.iter().map(|d| d.abs()).collect();
    let breadth = 4.0 * median(&mut sizes)?;
    let mut normal = SMatrix::<f64, FIGURE_PARAMETERS, FIGURE_PARAMETERS>::zeros();
    let mut right = FigureParameters::zeros();
    for (pair, off) in whole.iter().zip(&off) {
        let weight = (breadth / off.abs()).min(1.0);
        let slope = FigureParameters::from_fn(|j, _| {
            let mut more = *p;
            more[j] += 1e-5;
            (distance(&more, pair) - off) / 1e-5
        });
        normal += weight * slope * slope.transpose();
        right -= weight * off * slope;
    }
    for j in 1..FIGURE_PARAMETERS {
        normal[(j, j)] += PRIOR;
        right[j] -= PRIOR * p[j];
    }
    normal.cholesky().map(|c| c.solve(&right))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_point_is_found_by_either_channel() {
        let figure = Figure {
            amplitude: 2.0e4,
            pair: [0.01, -0.02, 0.04, 0.03],
        };
        for k in 0..12 {
            let phase = f64::from(k).mul_add(0.5, 0.2);
            let [sine, cosine] = figure.at(phase);
            let by_cosine = figure.at_cosine(cosine, phase.sin());
            let by_sine = figure.at_sine(sine, (phase + 0.03).cos());
            for found in [by_cosine, by_sine] {
                let off = (found[0] - sine).hypot(found[1] - cosine);
                assert!(off < 1e-6, "{phase}: {found:?} for {sine}, {cosine}");
            }
        }
    }
}
