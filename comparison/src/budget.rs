//! What a calibrated position or angle is worth: an uncertainty budget as JCGM 100:2008 (the GUM) asks for, section 7 and annex G.
//!
//! `position = mean of a pair's calibrated outputs`, so each contribution is an output's or the position's own, with its sensitivity.
//! Coefficients of one order are taken together: those of a pair are correlated, and a row each would hide that.

use crate::COVERAGE;
use crate::distribution::{MANY, coverage_factor, effective_freedom};
use crate::estimate::{Estimate, Unknown, term_name};
use crate::workspace::{Pose, Quantity, Workspace, growth, mean_square_growth, row};
use serde::Serialize;

/// Linear expansion, 1/K. A prior: 11.5 ppm/K, as steel has of which scales and platens are made.
const EXPANSION_PER_K: f64 = 11.5e-6;
/// Standard deviation of a value that lies within half a width to either side, over that half width (JCGM 100:2008, 4.3.7).
/// Derived from the uniform distribution: 1/√3.
const UNIFORM: f64 = 0.577_350_269_189_625_8;
/// A contribution of less than this share of all is rounding, of terms that cancel. Derived from the record's f32, which has
/// seven digits of each term.
const ROUNDING: f64 = 1.0e-6;
/// Tooth variation in the paper's section 4, by an interferometer over seven teeth.
pub const PAPER_TEETH_M: f64 = 1.9e-6;

/// How far a segment's output depends on the place across it, standard deviation over that of what the parity is left with. Derived from the paper's section
/// 3.1.2: by an interferometer each angle is off by 0.4 mrad, and the parity by 4.1 µm. The parity is the difference of both angles, so what they have in
/// common is off by √(0.4² - 0.21²) = 0.34 mrad; if each segment had the parity's errors for itself alone, that would be 0.21. The rest, 0.27 mrad over the
/// span of 9.7 mm, is 2.6 µm.
const PAPER_LATERAL: f64 = 0.63;

/// How an uncertainty was evaluated.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize)]
pub enum Kind {
    /// By statistics of repeated readings.
    A,
    /// By anything else: data sheets, geometry, published values.
    B,
}

/// What is known of the place and its conditions beside the calibration.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Conditions {
    /// Displacement of teeth that a pair's segments share, standard deviation, metres: no parity tells it. Zero with a tooth map.
    pub teeth_m: f64,
    /// How far a segment's output depends on the place across it, standard deviation, metres; none is as the paper found it.
    pub lateral_m: Option<f64>,
    /// The temperature lies within so many kelvin of the calibration's, to either side.
    pub within_k: f64,
    /// How far the courier is from where its coordinates begin, along x and y, metres: what expands.
    pub distance_m: [f64; 2],
}

impl Default for Conditions {
    fn default() -> Self {
        Self {
            teeth_m: PAPER_TEETH_M,
            lateral_m: None,
            within_k: 0.0,
            distance_m: [0.0; 2],
        }
    }
}

/// One line of a budget.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Contribution {
    /// Of what.
    pub name: String,
    /// How it was evaluated.
    pub kind: Kind,
    /// Standard uncertainty of the source, in its own unit.
    pub uncertainty: f64,
    /// Unit of that.
    pub unit: &'static str,
    /// How the quantity follows the source, root of the sum of squares where it has several.
    pub sensitivity: f64,
    /// What it contributes, m or rad: their product.
    pub contribution: f64,
    /// Degrees of freedom; none where infinite.
    pub freedom: Option<f64>,
}

/// The budget of one quantity at one pose.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Budget {
    /// Of what.
    pub quantity: Quantity,
    /// Where.
    pub pose: Pose,
    /// Its contributions, largest first.
    pub contributions: Vec<Contribution>,
    /// Combined standard uncertainty, m or rad.
    pub combined: f64,
    /// Effective degrees of freedom (Welch-Satterthwaite); none where infinite.
    pub freedom: Option<f64>,
    /// Coverage factor for 95 %.
    pub factor: f64,
    /// Expanded uncertainty: their product.
    pub expanded: f64,
}

/// Of an estimate, for a quantity at a pose.
///
/// # Errors
/// The estimate has no covariance, or does not tell what its readings leave.
pub fn budget(
    estimate: &Estimate,
    conditions: &Conditions,
    pose: &Pose,
    quantity: Quantity,
) -> Result<Budget, String> {
    let Some((parity_m, freedom)) = estimate.parity else {
        return Err("no residual of held-out readings is known".into());
    };
    let mut list = coefficients(estimate, pose, quantity)?;
    list.push(readings(estimate, pose, quantity, parity_m, freedom));
    list.extend(counts(estimate, pose, quantity));
    list.extend(lateral_terms(
        estimate, conditions, pose, quantity, parity_m,
    ));
    list.extend(shared_teeth(conditions, quantity));
    list.extend(expansion(conditions, quantity));
    let combined = list
        .iter()
        .map(|of| of.contribution.powi(2))
        .sum::<f64>()
        .sqrt();
    list.retain(|of| of.contribution > ROUNDING * combined);
    let freedom = effective_freedom(
        list.iter()
            .map(|of| (of.contribution.powi(2), of.freedom.unwrap_or(f64::INFINITY))),
    );
    let factor = coverage_factor(COVERAGE, freedom);
    // What is equal but for rounding keeps its order.
    list.sort_by_key(|of| -(of.contribution / (ROUNDING * combined)) as i64);
    Ok(Budget {
        quantity,
        pose: *pose,
        contributions: list,
        combined,
        freedom: (freedom < MANY).then_some(freedom),
        factor,
        expanded: factor * combined,
    })
}

/// At every pose of a workspace.
///
/// # Errors
/// As [`budget`].
pub fn map(
    estimate: &Estimate,
    conditions: &Conditions,
    workspace: &Workspace,
    quantity: Quantity,
) -> Result<Vec<Budget>, String> {
    let poses = workspace.poses(&estimate.unknowns, quantity);
    poses
        .iter()
        .map(|pose| budget(estimate, conditions, pose, quantity))
        .collect()
}

/// What no budget here holds, for people.
#[must_use]
pub fn not_counted(conditions: &Conditions) -> Vec<&'static str> {
    let mut list = vec![
        "where coordinates and angle begin: only changes of position and angle are told (gauge)",
        "the span between segments, as it is drawn: a share of every angle",
        "motion: delay, direction of travel and vibration, beyond the terms that the calibration has",
    ];
    if conditions.within_k == 0.0 {
        list.push("temperature: none was given");
    }
    list
}

/// The coefficients, order by order, and what orders have in common.
fn coefficients(
    estimate: &Estimate,
    pose: &Pose,
    quantity: Quantity,
) -> Result<Vec<Contribution>, String> {
    let certainty = estimate.certainty.as_ref().map_err(Clone::clone)?;
    let row = row(&estimate.unknowns, &estimate.geometry, pose, quantity);
    let unit = if quantity == Quantity::Theta {
        0.5 / f64::from(estimate.geometry.span_m)
    } else {
        0.5
    };
    let mut groups: Vec<(String, Vec<usize>)> = Vec::new();
    for (place, unknown) in estimate.unknowns.iter().enumerate() {
        let (true, Some(wave)) = (
            row[place] != 0.0 && estimate.is_estimated(place),
            unknown.wave,
        ) else {
            continue;
        };
        let name = term_name(&wave.term);
        match groups.iter_mut().find(|group| group.0 == name) {
            Some((_, places)) => places.push(place),
            None => groups.push((name, vec![place])),
        }
    }
    let product = |a: &[usize], b: &[usize]| -> f64 {
        let pairs = a.iter().flat_map(|&a| b.iter().map(move |&b| (a, b)));
        pairs
            .map(|(a, b)| row[a] * certainty.covariance[(a, b)] * row[b])
            .sum()
    };
    let one = |name: String, square: f64| {
        let contribution = square.max(0.0).sqrt();
        Contribution {
            name,
            kind: Kind::A,
            uncertainty: contribution / unit,
            unit: "m",
            sensitivity: unit,
            contribution,
            freedom: certainty.freedom.is_finite().then_some(certainty.freedom),
        }
    };
    let own: Vec<f64> = groups
        .iter()
        .map(|(_, places)| product(places, places))
        .collect();
    let all: Vec<usize> = groups
        .iter()
        .flat_map(|(_, places)| places.iter().copied())
        .collect();
    let (total, sum) = (product(&all, &all), own.iter().sum::<f64>());
    // Where orders are known together better than each by itself, one row tells them all.
    if total < sum * (1.0 - 1.0e-9) {
        return Ok(vec![one("coefficients, all orders together".into(), total)]);
    }
    let mut list: Vec<Contribution> = groups
        .into_iter()
        .zip(own)
        .map(|((name, _), square)| one(format!("coefficients of {name}"), square))
        .collect();
    list.push(one("correlation between orders".into(), total - sum));
    Ok(list)
}

/// What the parity of held-out readings left, as if each unmodified output had the same share: noise, and what no term describes. The
/// parity has each grown by the slope of its correction, as the position has.
fn readings(
    estimate: &Estimate,
    pose: &Pose,
    quantity: Quantity,
    parity_m: f64,
    freedom: f64,
) -> Contribution {
    let growth = mean_square_growth(
        &estimate.unknowns,
        estimate.values.as_slice(),
        &estimate.geometry,
    );
    let uncertainty = parity_m / growth.iter().sum::<f64>().sqrt();
    let sensitivity = by_segments(estimate, pose, quantity);
    Contribution {
        name: "readings: noise, and what no term describes".into(),
        kind: Kind::A,
        uncertainty,
        unit: "m",
        sensitivity,
        contribution: uncertainty * sensitivity,
        freedom: freedom.is_finite().then_some(freedom),
    }
}

/// How outputs depend on the place across, of which the parity tells next to nothing: what follows that place alone looks there like the other pair's own
/// waves, and is taken for those. Nothing where lateral terms were fitted or looked for.
fn lateral_terms(
    estimate: &Estimate,
    conditions: &Conditions,
    pose: &Pose,
    quantity: Quantity,
    parity_m: f64,
) -> Option<Contribution> {
    let is_lateral = |unknown: &Unknown| {
        unknown
            .wave
            .is_some_and(|wave| wave.term.lateral_order != 0)
    };
    let mut estimated = (0..estimate.unknowns.len()).filter(|place| estimate.is_estimated(*place));
    let is_held = estimate.looked_for_all || estimated.any(|k| is_lateral(&estimate.unknowns[k]));
    let by_paper = (!is_held).then_some(PAPER_LATERAL * parity_m);
    let uncertainty = conditions.lateral_m.or(by_paper)?;
    let sensitivity = by_segments(estimate, pose, quantity);
    Some(Contribution {
        name: "lateral terms, which the parity does not tell".into(),
        kind: Kind::B,
        uncertainty,
        unit: "m",
        sensitivity,
        contribution: uncertainty * sensitivity,
        freedom: None,
    })
}

/// Half a converter's count to either side, as a length along the tooth.
fn counts(estimate: &Estimate, pose: &Pose, quantity: Quantity) -> Option<Contribution> {
    let least = estimate
        .amplitude_counts
        .iter()
        .fold(f64::INFINITY, |a, b| a.min(*b));
    if least <= 0.0 {
        return None;
    }
    let half_m = 0.5 * f64::from(estimate.geometry.pitch_m) / (std::f64::consts::TAU * least);
    let sensitivity = by_segments(estimate, pose, quantity);
    Some(Contribution {
        name: "converter's count".into(),
        kind: Kind::B,
        uncertainty: UNIFORM * half_m,
        unit: "m",
        sensitivity,
        contribution: UNIFORM * half_m * sensitivity,
        freedom: None,
    })
}

fn shared_teeth(conditions: &Conditions, quantity: Quantity) -> Option<Contribution> {
    // Both segments of a pair are on the same teeth: the angle does not see them.
    (quantity != Quantity::Theta).then(|| Contribution {
        name: "teeth of the platen that a pair shares".into(),
        kind: Kind::B,
        uncertainty: conditions.teeth_m,
        unit: "m",
        sensitivity: 1.0,
        contribution: conditions.teeth_m,
        freedom: None,
    })
}

fn expansion(conditions: &Conditions, quantity: Quantity) -> Option<Contribution> {
    let distance_m = match quantity {
        Quantity::X => conditions.distance_m[0],
        Quantity::Y => conditions.distance_m[1],
        Quantity::Theta => return None,
    };
    let (uncertainty, sensitivity) = (
        UNIFORM * conditions.within_k,
        EXPANSION_PER_K * distance_m.abs(),
    );
    Some(Contribution {
        name: "temperature: the platen's expansion".into(),
        kind: Kind::B,
        uncertainty,
        unit: "K",
        sensitivity,
        contribution: uncertainty * sensitivity,
        freedom: None,
    })
}

/// How the quantity follows independent errors of the unmodified outputs, all of one size.
fn by_segments(estimate: &Estimate, pose: &Pose, quantity: Quantity) -> f64 {
    let growth = growth(
        &estimate.unknowns,
        estimate.values.as_slice(),
        &estimate.geometry,
        pose,
    );
    let sensitivities = quantity
        .sensitivities(&estimate.geometry)
        .into_iter()
        .zip(growth);
    sensitivities
        .map(|(s, growth)| (s * growth).powi(2))
        .sum::<f64>()
        .sqrt()
}

#[cfg(test)]
mod tests;
