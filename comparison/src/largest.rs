//! Where in the workspace values move a quantity most, with a band that holds at all places at once.
//!
//! The largest of many differences is found by looking for it, so an interval for one place would be too narrow there. The band's factor is
//! the 95 % point of the largest of all differences, each over its own deviation, by draws from the covariance (Ruppert, Wand and Carroll
//! 2003, "Semiparametric Regression", section 6.5).

use crate::COVERAGE;
use crate::estimate::Unknown;
use crate::significance::Root;
use crate::workspace::{Pose, Quantity, Workspace, row};
use nalgebra::{DMatrix, DVector};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{ChiSquared, Distribution, StandardNormal};
use serde::Serialize;

/// Draws of a band: its coverage is then known to half a percent. Derived from the binomial distribution: √(0.95 0.05 / 2000).
const DRAWS: usize = 2000;
/// Draws that are made together: as many as the processor's cache holds of the lines. Cost alone: the draws are the same in any
/// portion.
const TOGETHER: usize = 100;
/// Any. By definition always the same, so that the answer is.
const SEED: u64 = 1;
/// A deviation of less than this share of the largest is rounding: nothing is known to vary there. Derived from the seven digits
/// of the record's f32, with two to spare.
const NO_DEVIATION: f64 = 1.0e-9;

/// The largest change of a quantity.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Largest {
    /// Of what.
    pub quantity: Quantity,
    /// Where.
    pub pose: Pose,
    /// How much there, metres or radians.
    pub value: f64,
    /// Standard deviation there; none where no covariance is known.
    pub deviation: Option<f64>,
    /// Half the width of the band that holds at all places of the workspace at once with 95 %.
    pub band: Option<f64>,
    /// Rms over the workspace.
    pub rms: f64,
    /// The same that chance alone gives, root of the mean square.
    pub chance_rms: Option<f64>,
    /// Whether the band leaves out zero somewhere.
    pub changed: Option<bool>,
}

/// Values with how well they are known.
#[derive(Clone, Copy, Debug)]
pub struct Known<'a> {
    /// Unknowns.
    pub unknowns: &'a [Unknown],
    /// Their values.
    pub values: &'a DVector<f64>,
    /// Root of their covariance, and its degrees of freedom.
    pub root: Option<(&'a Root, f64)>,
}

/// The largest of each of some quantities; their bands hold together. Cost: poses times unknowns times 2000.
#[must_use]
pub fn largest(known: &Known, workspace: &Workspace, quantities: &[Quantity]) -> Vec<Largest> {
    let lists: Vec<Line> = quantities
        .iter()
        .map(|&quantity| Line::new(known, workspace, quantity))
        .collect();
    let factor = known.root.map(|(_, freedom)| factor(&lists, freedom));
    lists.iter().map(|line| line.largest(factor)).collect()
}

/// A quantity at all poses.
struct Line {
    quantity: Quantity,
    poses: Vec<Pose>,
    values: Vec<f64>,
    deviations: Option<Vec<f64>>,
    /// How the quantity follows unit numbers, over its deviation: a row a pose.
    directions: DMatrix<f64>,
}

impl Line {
    fn new(known: &Known, workspace: &Workspace, quantity: Quantity) -> Self {
        let poses = workspace.poses(known.unknowns, quantity);
        let rows: Vec<f64> = poses
            .iter()
            .flat_map(|pose| row(known.unknowns, &workspace.geometry, pose, quantity))
            .collect();
        let rows = DMatrix::from_row_slice(poses.len(), known.unknowns.len(), &rows);
        let values = (&rows * known.values).iter().copied().collect();
        let mut directions = known.root.map_or_else(
            || DMatrix::zeros(poses.len(), 0),
            |(root, _)| rows * &root.root,
        );
        let deviations: Vec<f64> = directions.row_iter().map(|row| row.norm()).collect();
        let least = NO_DEVIATION * deviations.iter().fold(0.0, |a: f64, b| a.max(*b));
        for (mut direction, deviation) in directions.row_iter_mut().zip(&deviations) {
            direction.scale_mut(if *deviation > least {
                1.0 / deviation
            } else {
                0.0
            });
        }
        Self {
            quantity,
            poses,
            values,
            deviations: known.root.map(|_| deviations),
            directions,
        }
    }

    fn largest(&self, factor: Option<f64>) -> Largest {
        let beyond = |k: usize| match (&self.deviations, factor) {
            (Some(deviations), Some(factor)) => Some(self.values[k].abs() > factor * deviations[k]),
            _ => None,
        };
        let at = (0..self.values.len())
            .max_by(|&a, &b| self.values[a].abs().total_cmp(&self.values[b].abs()))
            .unwrap_or(0);
        let rms = |list: &[f64]| {
            (list.iter().map(|v| v * v).sum::<f64>() / list.len().max(1) as f64).sqrt()
        };
        let deviation = self.deviations.as_ref().map(|list| list[at]);
        Largest {
            quantity: self.quantity,
            pose: self.poses[at],
            value: self.values[at],
            deviation,
            band: deviation
                .zip(factor)
                .map(|(deviation, factor)| deviation * factor),
            rms: rms(&self.values),
            chance_rms: self.deviations.as_ref().map(|list| rms(list)),
            changed: factor.map(|_| (0..self.values.len()).any(|k| beyond(k) == Some(true))),
        }
    }
}

/// The 95 % point of the largest difference over its deviation, of all lines.
fn factor(lines: &[Line], freedom: f64) -> f64 {
    let directions = lines.first().map_or(0, |line| line.directions.ncols());
    if directions == 0 {
        return 0.0;
    }
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    let scale = freedom
        .is_finite()
        .then(|| ChiSquared::new(freedom.max(1.0)).ok())
        .flatten();
    let mut largest = Vec::with_capacity(DRAWS);
    for _ in 0..DRAWS / TOGETHER {
        let draws = DMatrix::from_fn(directions, TOGETHER, |_, _| StandardNormal.sample(&mut rng));
        let of: Vec<DMatrix<f64>> = lines.iter().map(|line| &line.directions * &draws).collect();
        for k in 0..TOGETHER {
            let size = of
                .iter()
                .fold(0.0, |size: f64, of| size.max(of.column(k).amax()));
            let own = scale.as_ref().map_or(1.0, |scale| {
                (scale.sample(&mut rng) / freedom.max(1.0)).sqrt()
            });
            largest.push(size / own);
        }
    }
    largest.sort_by(f64::total_cmp);
    largest[((DRAWS as f64 * COVERAGE) as usize).min(DRAWS - 1)]
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::estimate::Wave;
    use courier_sensor::geometry::Geometry;
    use courier_sensor::model::Term;

    /// One sine of one segment: a change of 2 µm moves x by 1 µm at a quarter of a tooth, and the band is that of one number.
    #[test]
    fn one_unknown_has_the_band_of_one_number() {
        let wave = Wave {
            segment: 0,
            term: Term::own(1),
            cosine: false,
            share: 1.0,
        };
        let (unknowns, values) = ([Unknown::of_wave(wave)], DVector::from_element(1, 2.0e-6));
        let workspace = Workspace {
            geometry: Geometry::PAPER,
            turn_rad: 0.0,
        };
        let root = Root::of(&DMatrix::from_element(1, 1, 0.25e-12));
        for (freedom, factor) in [(f64::INFINITY, 1.96), (10.0, 2.228)] {
            let known = Known {
                unknowns: &unknowns,
                values: &values,
                root: Some((&root, freedom)),
            };
            let found = &largest(&known, &workspace, &[Quantity::X])[0];
            assert!(
                (found.value.abs() / 1.0e-6 - 1.0).abs() < 1.0e-6,
                "{found:?}"
            );
            assert!(
                (found.deviation.unwrap() / 0.25e-6 - 1.0).abs() < 1.0e-6,
                "{found:?}"
            );
            // The quantile of 2000 draws: its own deviation is 2.4 % of it, and more with fewer degrees of freedom.
            assert!(
                (found.band.unwrap() / 0.25e-6 / factor - 1.0).abs() < 0.1,
                "{found:?}"
            );
            assert_eq!(found.changed, Some(true));
            assert!(
                (found.rms / (1.0e-6 / 2.0_f64.sqrt()) - 1.0).abs() < 1.0e-6,
                "{found:?}"
            );
        }
    }

    #[test]
    fn without_a_covariance_the_difference_stands_alone() {
        let wave = Wave {
            segment: 1,
            term: Term::own(2),
            cosine: true,
            share: 1.0,
        };
        let (unknowns, values) = ([Unknown::of_wave(wave)], DVector::from_element(1, 2.0e-6));
        let workspace = Workspace {
            geometry: Geometry::PAPER,
            turn_rad: 0.0,
        };
        let known = Known {
            unknowns: &unknowns,
            values: &values,
            root: None,
        };
        let found = largest(&known, &workspace, &[Quantity::Y, Quantity::X]);
        assert!((found[0].value.abs() - 1.0e-6).abs() < 1.0e-12 && found[1].value == 0.0);
        assert!(
            found
                .iter()
                .all(|f| f.band.is_none() && f.changed.is_none() && f.chance_rms.is_none())
        );
    }
}
