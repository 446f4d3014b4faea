//! Poses of the courier over a tooth, and what unknowns do there to the calibrated position and angle.

use crate::estimate::{Unknown, Wave};
use courier_sensor::equations::{ANGLE_SIGN, lateral_arguments, outputs};
use courier_sensor::frame::SEGMENTS;
use courier_sensor::geometry::Geometry;
use courier_sensor::model::Multiplier;
use serde::Serialize;
use std::f64::consts::TAU;

/// A pose. Only places within a tooth count: patterns repeat.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Pose {
    /// Platen sensor's place from the tooth's zero phase, metres.
    pub centre_m: [f64; 2],
    /// Angle, radians.
    pub theta_rad: f64,
}

/// What is looked at: x, y and the angle.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Quantity {
    /// Position along x, metres.
    X,
    /// Position along y, metres.
    Y,
    /// Mean of both pairs' angles, radians.
    Theta,
}

impl Quantity {
    /// All.
    pub const ALL: [Self; 3] = [Self::X, Self::Y, Self::Theta];

    /// How the quantity follows each segment's calibrated output: 1, or 1/m for the angle.
    #[must_use]
    pub fn sensitivities(self, geometry: &Geometry) -> [f64; SEGMENTS] {
        match self {
            Self::X => [0.5, 0.0, 0.5, 0.0],
            Self::Y => [0.0, 0.5, 0.0, 0.5],
            Self::Theta => {
                ANGLE_SIGN.map(|sign| f64::from(sign) / (2.0 * f64::from(geometry.span_m)))
            }
        }
    }
}

/// Points of a tooth, along and across: four a period of order 6, as the board looks at its own prediction. Derived from the
/// sampling theorem, with a factor of two.
const PHASES: usize = 24;
/// Points of a tooth, along and across, of a map that is looked at: two a period of order 8. Derived from the sampling theorem:
/// order 8 is the square of a third harmonic's.
const MAP: usize = 16;
/// Angles, from one end of the turn to the other. Derived from the highest power of the angle that a board has, 3: four values
/// tell it, and one more.
const ANGLES: usize = 5;

/// Where a courier works: everywhere in a tooth, and turned by up to an angle to either side.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Workspace {
    /// Geometry.
    pub geometry: Geometry,
    /// Largest angle, radians.
    pub turn_rad: f64,
}

impl Workspace {
    /// Poses that stand for all of it. A position that follows no lateral phase needs a line alone: there x and y are walked through
    /// together. The angle follows both.
    #[must_use]
    pub fn poses(&self, unknowns: &[Unknown], quantity: Quantity) -> Vec<Pose> {
        let lateral = |unknown: &Unknown| {
            unknown
                .wave
                .is_some_and(|wave| wave.term.lateral_order != 0)
        };
        let across = quantity == Quantity::Theta || unknowns.iter().any(lateral);
        let step_m = f64::from(self.geometry.pitch_m) / PHASES as f64;
        let angle = |k: usize| self.turn_rad * (2.0 * k as f64 / (ANGLES - 1) as f64 - 1.0);
        let rows = if across { PHASES } else { 1 };
        let one = |k: usize| {
            let (row, rest) = (k / (PHASES * ANGLES), k % (PHASES * ANGLES));
            let (x, angle_at) = (rest / ANGLES, rest % ANGLES);
            let y = if across { row } else { x };
            Pose {
                centre_m: [x, y].map(|n| n as f64 * step_m),
                theta_rad: angle(angle_at),
            }
        };
        (0..rows * PHASES * ANGLES).map(one).collect()
    }
}

impl Workspace {
    /// A tooth along x and y, at the angle zero.
    #[must_use]
    pub fn plane(&self) -> Vec<Pose> {
        let step_m = f64::from(self.geometry.pitch_m) / MAP as f64;
        let one = |k: usize| Pose {
            centre_m: [k % MAP, k / MAP].map(|n| n as f64 * step_m),
            theta_rad: 0.0,
        };
        (0..MAP * MAP).map(one).collect()
    }
}

/// Own and lateral phases of all segments at a pose, radians.
struct Phases {
    own_rad: [f64; SEGMENTS],
    lateral_rad: [f64; SEGMENTS],
    theta_rad: f64,
}

impl Phases {
    fn at(geometry: &Geometry, pose: &Pose) -> Self {
        let f = TAU / f64::from(geometry.pitch_m);
        let p = outputs(pose.centre_m, pose.theta_rad, f64::from(geometry.span_m));
        let q = lateral_arguments(pose.centre_m, pose.theta_rad, f64::from(geometry.lateral_m));
        Self {
            own_rad: p.map(|p| f * p),
            lateral_rad: q.map(|q| f * q),
            theta_rad: pose.theta_rad,
        }
    }

    /// What an unknown of 1 adds to its segment's correction: at rest, at the calibration's temperature, after a motion in the positive
    /// direction.
    fn value(&self, wave: &Wave) -> f64 {
        let term = &wave.term;
        if matches!(term.multiplier, Multiplier::Speed | Multiplier::Temperature) {
            return 0.0;
        }
        let phase = f64::from(term.own_order) * self.own_rad[wave.segment]
            + f64::from(term.lateral_order) * self.lateral_rad[wave.segment];
        let function = if wave.cosine {
            phase.cos()
        } else {
            phase.sin()
        };
        wave.share * self.theta_rad.powi(i32::from(term.theta_power)) * function
    }

    /// Its derivative by the segment's own output, 1/m.
    fn slope(&self, wave: &Wave, geometry: &Geometry) -> f64 {
        let order = f64::from(wave.term.own_order) * TAU / f64::from(geometry.pitch_m);
        let turned = Wave {
            cosine: !wave.cosine,
            ..*wave
        };
        let sign = if wave.cosine { -1.0 } else { 1.0 };
        sign * order * self.value(&turned)
    }
}

/// How a quantity at a pose follows each unknown; zero for those that are no term of the board's error model.
#[must_use]
pub fn row(unknowns: &[Unknown], geometry: &Geometry, pose: &Pose, quantity: Quantity) -> Vec<f64> {
    let (phases, by_segment) = (Phases::at(geometry, pose), quantity.sensitivities(geometry));
    let one = |unknown: &Unknown| {
        unknown
            .wave
            .map_or(0.0, |wave| by_segment[wave.segment] * phases.value(&wave))
    };
    unknowns.iter().map(one).collect()
}

/// How each segment's calibrated output follows its unmodified one at a pose: `1 + de/dp`.
#[must_use]
pub fn growth(
    unknowns: &[Unknown],
    values: &[f64],
    geometry: &Geometry,
    pose: &Pose,
) -> [f64; SEGMENTS] {
    let phases = Phases::at(geometry, pose);
    let mut growth = [1.0; SEGMENTS];
    for (unknown, value) in unknowns.iter().zip(values) {
        if let Some(wave) = unknown.wave {
            growth[wave.segment] += value * phases.slope(&wave, geometry);
        }
    }
    growth
}

/// The mean of the square of [`growth`] over all phases: one, and half the square of each slope.
#[must_use]
pub fn mean_square_growth(
    unknowns: &[Unknown],
    values: &[f64],
    geometry: &Geometry,
) -> [f64; SEGMENTS] {
    let f = TAU / f64::from(geometry.pitch_m);
    let mut mean = [1.0; SEGMENTS];
    for (unknown, value) in unknowns.iter().zip(values) {
        let plain =
            |wave: &Wave| wave.term.theta_power == 0 && wave.term.multiplier == Multiplier::None;
        if let Some(wave) = unknown.wave.filter(plain) {
            mean[wave.segment] +=
                0.5 * (value * wave.share * f64::from(wave.term.own_order) * f).powi(2);
        }
    }
    mean
}

#[cfg(test)]
mod tests {
    use super::*;
    use courier_sensor::model::Term;

    const PITCH_M: f64 = Geometry::PAPER.pitch_m as f64;

    fn unknown(segment: usize, term: Term, cosine: bool) -> Unknown {
        Unknown::of_wave(Wave {
            segment,
            term,
            cosine,
            share: 1.0,
        })
    }

    #[test]
    fn a_pair_moves_its_own_axis_and_the_angle() {
        let geometry = Geometry::PAPER;
        let unknowns = [
            unknown(0, Term::own(1), false),
            unknown(2, Term::own(1), false),
            unknown(1, Term::own(1), false),
        ];
        let pose = Pose {
            centre_m: [0.25 * PITCH_M, 0.5 * PITCH_M],
            theta_rad: 0.0,
        };
        let at = |quantity| row(&unknowns, &geometry, &pose, quantity);
        let near = |found: Vec<f64>, wanted: [f64; 3]| {
            assert!(
                found
                    .iter()
                    .zip(wanted)
                    .all(|(a, b)| (a - b).abs() < 1.0e-9 * (1.0 + b.abs())),
                "{found:?}"
            );
        };
        near(at(Quantity::X), [0.5, 0.5, 0.0]);
        near(at(Quantity::Y), [0.0, 0.0, 0.0]);
        let half = 0.5 / f64::from(geometry.span_m);
        near(at(Quantity::Theta), [half, -half, 0.0]);
    }

    #[test]
    fn growth_is_the_slope_of_the_correction() {
        let geometry = Geometry::PAPER;
        let unknowns = [
            unknown(0, Term::own(2), false),
            unknown(0, Term::own(1), true),
        ];
        let values = [3.0e-6, -2.0e-6];
        let correction = |x_m: f64| -> f64 {
            let pose = Pose {
                centre_m: [x_m, 0.0],
                theta_rad: 0.0,
            };
            2.0 * row(&unknowns, &geometry, &pose, Quantity::X)
                .iter()
                .zip(values)
                .map(|(a, b)| a * b)
                .sum::<f64>()
        };
        let (x_m, step_m) = (0.31 * PITCH_M, 1.0e-8);
        let slope = (correction(x_m + step_m) - correction(x_m - step_m)) / (2.0 * step_m);
        let pose = Pose {
            centre_m: [x_m, 0.0],
            theta_rad: 0.0,
        };
        let found = growth(&unknowns, &values, &geometry, &pose);
        assert!(
            (found[0] - 1.0 - slope).abs() < 1.0e-6 && found[1] == 1.0,
            "{found:?} {slope}"
        );
        let all = (0..1000).map(|k| {
            let pose = Pose {
                centre_m: [f64::from(k) / 1000.0 * PITCH_M, 0.0],
                theta_rad: 0.0,
            };
            growth(&unknowns, &values, &geometry, &pose)[0].powi(2)
        });
        let mean = mean_square_growth(&unknowns, &values, &geometry);
        assert!(
            (all.sum::<f64>() / 1000.0 - mean[0]).abs() < 1.0e-9 && mean[1] == 1.0,
            "{mean:?}"
        );
    }

    #[test]
    fn lateral_terms_need_the_plane_and_others_a_line() {
        let workspace = Workspace {
            geometry: Geometry::PAPER,
            turn_rad: 0.01,
        };
        let own = workspace.poses(&[unknown(0, Term::own(1), true)], Quantity::X);
        let both = workspace.poses(&[unknown(0, Term::lateral(1), true)], Quantity::X);
        let angle = workspace.poses(&[unknown(0, Term::own(1), true)], Quantity::Theta);
        assert_eq!(
            (own.len(), both.len()),
            (PHASES * ANGLES, PHASES * PHASES * ANGLES)
        );
        assert_eq!(angle.len(), both.len());
        assert!(both.iter().any(|pose| pose.centre_m[0] != pose.centre_m[1]));
        assert!(
            own.iter()
                .any(|pose| (pose.theta_rad - 0.01).abs() < 1.0e-12)
        );
    }
}
