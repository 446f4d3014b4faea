//! Groups of unknowns, and how far apart their columns are.

use super::problem::Problem;
use courier_sensor::calibration::joint::Unknown;
use serde::Serialize;

/// What a group's angle is measured from unless another group is named.
pub(super) const OTHERS: &str = "all others";
/// Pairs of groups that are closer than this are told. Derived from the sine: their common part is known three times worse than
/// each alone.
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
    pub(super) fn groups(&self) -> Vec<(String, Vec<usize>)> {
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
                let angle_deg = self.triangle.angle_deg(columns, other_columns);
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
        self.triangle.angle_deg(&own, &others)
    }

    /// Largest predicted deviation within a group; none where the poses do not determine it.
    pub(super) fn worst_deviation(&self, group: &str) -> Option<f64> {
        let variances = self.triangle.variances();
        let of_group = (0..self.free.len())
            .filter(|&c| group_name(self.layout.unknown(self.free[c])) == group);
        let worst = of_group.map(|c| variances[c]).fold(0.0, f64::max);
        worst.is_finite().then(|| worst.sqrt())
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
