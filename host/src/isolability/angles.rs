//! Groups of unknowns, and how far apart their columns are.

use super::problem::{Problem, UNDETERMINED};
use courier_sensor::calibration::joint::Unknown;
use nalgebra::DMatrix;
use serde::Serialize;

/// What a group's angle is measured from unless another group is named.
pub(super) const OTHERS: &str = "all others";
/// Pairs of groups that are closer than this are told.
const CLOSE_DEG: f64 = 20.0;

/// How far apart two groups are.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Angle {
    /// A group.
    pub group: String,
    /// Another, or all others.
    pub other: String,
    /// Smallest principal angle of their columns, degrees: 90 is independent, 0 is the same.
    pub angle_deg: f64,
}

impl Problem {
    fn groups(&self) -> Vec<(String, Vec<usize>)> {
        let mut groups: Vec<(String, Vec<usize>)> = Vec::new();
        for (column, &index) in self.free.iter().enumerate() {
            let name = group_name(self.layout.unknown(index));
            match groups.iter_mut().find(|(other, _)| *other == name) {
                Some((_, columns)) => columns.push(column),
                None => groups.push((name, vec![column])),
            }
        }
        groups
    }

    pub(super) fn angles(&self) -> Vec<Angle> {
        let groups = self.groups();
        let mut angles: Vec<Angle> = groups
            .iter()
            .map(|(name, _)| Angle {
                group: name.clone(),
                other: OTHERS.into(),
                angle_deg: self.angle_from_others(name),
            })
            .collect();
        for (i, (name, columns)) in groups.iter().enumerate() {
            for (other, other_columns) in &groups[i + 1..] {
                let angle_deg = self.angle(columns, other_columns);
                if angle_deg < CLOSE_DEG {
                    angles.push(Angle {
                        group: name.clone(),
                        other: other.clone(),
                        angle_deg,
                    });
                }
            }
        }
        angles
    }

    pub(super) fn angle_from_others(&self, group: &str) -> f64 {
        let (own, others): (Vec<usize>, Vec<usize>) = (0..self.free.len())
            .partition(|&column| group_name(self.layout.unknown(self.free[column])) == group);
        self.angle(&own, &others)
    }

    /// Largest predicted deviation within a group; none where the poses do not determine it.
    pub(super) fn worst_deviation(&self, group: &str) -> Option<f64> {
        let variances = self.variances();
        let of_group = (0..self.free.len())
            .filter(|&c| group_name(self.layout.unknown(self.free[c])) == group);
        let worst = of_group.map(|c| variances[c]).fold(0.0, f64::max);
        worst.is_finite().then(|| worst.sqrt())
    }

    /// Smallest principal angle between two sets of columns, degrees; by its sine, which is exact for small ones.
    fn angle(&self, a: &[usize], b: &[usize]) -> f64 {
        if a.is_empty() || b.is_empty() {
            return 90.0;
        }
        let [qa, qb] = [a, b].map(|columns| self.basis(columns));
        let rest = &qa - &qb * (qb.transpose() * &qa);
        let sine = if qa.ncols() == 0 {
            0.0
        } else {
            rest.singular_values().min()
        };
        sine.clamp(0.0, 1.0).asin().to_degrees()
    }

    /// Orthonormal basis of some columns' span; dependent ones give fewer.
    fn basis(&self, columns: &[usize]) -> DMatrix<f64> {
        let picked = self.triangle.select_columns(columns);
        let svd = picked.svd(true, false);
        let keep: Vec<usize> = (0..svd.singular_values.len())
            .filter(|&i| svd.singular_values[i] > UNDETERMINED)
            .collect();
        svd.u.map_or_else(
            || DMatrix::zeros(self.triangle.nrows(), 0),
            |u| u.select_columns(&keep),
        )
    }
}

/// The group that an unknown belongs to.
fn group_name(unknown: Unknown) -> String {
    match unknown {
        Unknown::Coefficient { term, .. } if term.lateral_order != 0 => "lateral terms".into(),
        Unknown::Coefficient { term, .. } => format!("own order {}", term.own_order),
        Unknown::ParityOffset => "parity offset".into(),
        Unknown::AngleOffset => "angle offset".into(),
        Unknown::Height => "height".into(),
        Unknown::Lever(_) => "lever arm".into(),
        Unknown::Place(_) => "beacon's place".into(),
        Unknown::GainDifference | Unknown::Turn => "diode misalignment".into(),
        Unknown::Nonlinearity(..) => "diode nonlinearity".into(),
    }
}
