//! Which terms and which effects changed: each tested by itself, with its probability raised for how many were tried.

use crate::COVERAGE;
use crate::distribution::coverage_factor;
use crate::estimate::{Unknown, term_name};
use crate::significance::{JointTest, Root, Scale};
use nalgebra::{DMatrix, DVector};
use serde::Serialize;

/// A term of a segment, or an amount that is no term: sine and cosine together.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Change {
    /// The effect that it belongs to.
    pub effect: String,
    /// What it is.
    pub name: String,
    /// Unit of the sizes.
    pub unit: String,
    /// Its size before: the root of the sum of squares of sine and cosine.
    pub first: f64,
    /// Its size after.
    pub second: f64,
    /// Size of the change, which a change of the phase makes as well.
    pub change: f64,
    /// Half the width of the 95 % interval of that, by itself; none where it is not known or the term was held.
    pub half_width: Option<f64>,
    /// Probability that chance alone changes as much, times the number of terms that were not more probable changed (Holm 1979).
    pub chance: Option<f64>,
    /// Whether that is below 5 %.
    pub changed: Option<bool>,
}

/// An effect with all its terms.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct EffectChange {
    /// Its name.
    pub effect: String,
    /// All of it together; the chance is raised as for terms. None where nothing of it was estimated.
    pub test: Option<JointTest>,
    /// Whether the chance is below 5 %.
    pub changed: Option<bool>,
}

/// A list of unknowns with two sets of values and the covariance of their difference.
#[derive(Clone, Copy, Debug)]
pub struct Compared<'a> {
    /// Unknowns.
    pub unknowns: &'a [Unknown],
    /// Values before.
    pub first: &'a DVector<f64>,
    /// Values after.
    pub second: &'a DVector<f64>,
    /// Covariance of the difference, and its degrees of freedom.
    pub certainty: Option<(&'a DMatrix<f64>, f64)>,
}

/// By term, the surest change first.
#[must_use]
pub fn terms(compared: &Compared) -> Vec<Change> {
    let mut list: Vec<Change> = groups(compared.unknowns, group_name)
        .into_iter()
        .map(|group| change(compared, group))
        .collect();
    let chances: Vec<Option<f64>> =
        holm(&list.iter().map(|change| change.chance).collect::<Vec<_>>());
    for (change, chance) in list.iter_mut().zip(chances) {
        (change.chance, change.changed) = (chance, chance.map(is_change));
    }
    list.sort_by(|a, b| {
        let chance = |of: &Change| of.chance.unwrap_or(2.0);
        chance(a)
            .total_cmp(&chance(b))
            .then(b.change.total_cmp(&a.change))
    });
    list
}

/// By effect, in the order of the unknowns.
#[must_use]
pub fn effects(compared: &Compared) -> Vec<EffectChange> {
    let values = compared.second - compared.first;
    let groups = groups(compared.unknowns, |unknown| unknown.effect.clone());
    let mut list: Vec<EffectChange> = groups
        .into_iter()
        .map(|(effect, places)| {
            let test = compared
                .certainty
                .map(|(covariance, freedom)| test(covariance, &values, &places, freedom));
            EffectChange {
                effect,
                test: test.filter(|test| test.directions > 0),
                changed: None,
            }
        })
        .collect();
    let chances = holm(
        &list
            .iter()
            .map(|of| of.test.as_ref().map(|test| test.chance))
            .collect::<Vec<_>>(),
    );
    for (of, chance) in list.iter_mut().zip(chances) {
        if let (Some(test), Some(chance)) = (&mut of.test, chance) {
            (test.chance, of.changed) = (chance, Some(is_change(chance)));
        }
    }
    list
}

/// Whether a chance is small enough to call it a change.
#[must_use]
pub fn is_change(chance: f64) -> bool {
    chance < 1.0 - COVERAGE
}

fn change(compared: &Compared, (name, places): (String, Vec<usize>)) -> Change {
    let of = |values: &DVector<f64>| {
        places
            .iter()
            .map(|&k| values[k] * values[k])
            .sum::<f64>()
            .sqrt()
    };
    let values = compared.second - compared.first;
    let test = compared
        .certainty
        .map(|(covariance, freedom)| test(covariance, &values, &places, freedom));
    let test = test.filter(|test| test.directions > 0);
    let half_width = test
        .as_ref()
        .and(compared.certainty)
        .map(|(covariance, freedom)| {
            coverage_factor(COVERAGE, freedom) * deviation_along(covariance, &values, &places)
        });
    let unknown = &compared.unknowns[places[0]];
    Change {
        effect: unknown.effect.clone(),
        name,
        unit: unknown.unit.clone(),
        first: of(compared.first),
        second: of(compared.second),
        change: of(&values),
        half_width,
        chance: test.map(|test| test.chance),
        changed: None,
    }
}

fn test(
    covariance: &DMatrix<f64>,
    values: &DVector<f64>,
    places: &[usize],
    freedom: f64,
) -> JointTest {
    let part = DMatrix::from_fn(places.len(), places.len(), |a, b| {
        covariance[(places[a], places[b])]
    });
    let values = DVector::from_fn(places.len(), |a, _| values[places[a]]);
    Root::of(&part).test(&values, Scale::apart(freedom))
}

/// Standard deviation of the size of a change: along it, or in the mean over directions where there is none.
fn deviation_along(covariance: &DMatrix<f64>, values: &DVector<f64>, places: &[usize]) -> f64 {
    let size = places.iter().map(|&k| values[k] * values[k]).sum::<f64>();
    if size <= 0.0 {
        let variances: f64 = places.iter().map(|&k| covariance[(k, k)]).sum();
        return (variances / places.len() as f64).sqrt();
    }
    let pairs = places
        .iter()
        .flat_map(|&a| places.iter().map(move |&b| (a, b)));
    let square: f64 = pairs
        .map(|(a, b)| values[a] * covariance[(a, b)] * values[b])
        .sum();
    (square.max(0.0) / size).sqrt()
}

fn group_name(unknown: &Unknown) -> String {
    match &unknown.wave {
        Some(wave) => format!("{}, segment {}", term_name(&wave.term), wave.segment + 1),
        None => unknown.name.clone(),
    }
}

/// Places of the unknowns of one name, and of one effect, in the order of the first of each.
fn groups(unknowns: &[Unknown], name: impl Fn(&Unknown) -> String) -> Vec<(String, Vec<usize>)> {
    let mut list: Vec<(String, Vec<usize>)> = Vec::new();
    for (place, unknown) in unknowns.iter().enumerate() {
        let own = name(unknown);
        let same = |(name, places): &(String, Vec<usize>)| {
            *name == own && unknowns[places[0]].effect == unknown.effect
        };
        match list.iter_mut().find(|group| same(group)) {
            Some((_, places)) => places.push(place),
            None => list.push((own, vec![place])),
        }
    }
    list
}

/// Chances raised for the number of tests (Holm 1979, Scandinavian Journal of Statistics 6, 65): of all tests together one in 20 then tells
/// of a change where there is none.
fn holm(chances: &[Option<f64>]) -> Vec<Option<f64>> {
    let mut order: Vec<(usize, f64)> = chances
        .iter()
        .enumerate()
        .filter_map(|(k, chance)| Some((k, (*chance)?)))
        .collect();
    order.sort_by(|a, b| a.1.total_cmp(&b.1));
    let (mut raised, mut so_far) = (vec![None; chances.len()], 0.0_f64);
    for (rank, (place, chance)) in order.iter().enumerate() {
        so_far = so_far.max(((order.len() - rank) as f64 * chance).min(1.0));
        raised[*place] = Some(so_far);
    }
    raised
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::difference::Difference;
    use crate::difference::tests::of_order;

    fn compare(apart: &Difference) -> (Vec<Change>, Vec<EffectChange>) {
        let certainty = apart.certainty.as_ref().ok();
        let compared = Compared {
            unknowns: &apart.unknowns,
            first: &apart.first,
            second: &apart.second,
            certainty: certainty.map(|certainty| (&certainty.covariance, certainty.freedom)),
        };
        (terms(&compared), effects(&compared))
    }

    #[test]
    fn a_change_of_phase_is_a_change() {
        let apart = Difference::between(
            &of_order(1, [3.0e-6, 0.0], 0.1e-6),
            &of_order(1, [0.0, 3.0e-6], 0.1e-6),
        );
        let (terms, effects) = compare(&apart);
        let change = &terms[0];
        assert_eq!(
            (change.name.as_str(), terms.len(), effects.len()),
            ("order 1, segment 1", 1, 1)
        );
        assert!((change.first - 3.0e-6).abs() < 1e-12 && (change.second - 3.0e-6).abs() < 1e-12);
        assert!(
            (change.change / 4.243e-6 - 1.0).abs() < 1e-3 && change.changed == Some(true),
            "{change:?}"
        );
        // Two deviations of 0.1 µm, and t of 200 degrees of freedom.
        assert!(
            (change.half_width.unwrap() / (1.972 * 0.141_42e-6) - 1.0).abs() < 1.0e-3,
            "{change:?}"
        );
        assert_eq!(effects[0].changed, Some(true));
    }

    #[test]
    fn an_effect_of_one_side_alone_is_compared_with_none() {
        let looked = |order, values| crate::estimate::Estimate {
            looked_for_all: true,
            ..of_order(order, values, 0.1e-6)
        };
        let apart = Difference::between(&looked(5, [3.0e-6, 0.0]), &looked(3, [0.0, 0.1e-6]));
        let (terms, effects) = compare(&apart);
        assert_eq!(
            (terms[0].name.as_str(), terms[0].second, terms[0].changed),
            ("order 5, segment 1", 0.0, Some(true))
        );
        assert_eq!((terms[1].first, terms[1].changed), (0.0, Some(false)));
        assert_eq!(effects.len(), 1);
        assert_eq!(
            (effects[0].effect.as_str(), effects[0].changed),
            ("extra_harmonics", Some(true))
        );
    }

    #[test]
    fn without_a_covariance_the_sizes_alone_are_told() {
        let mut one = of_order(1, [3.0e-6, 0.0], 0.1e-6);
        one.certainty = Err("none".into());
        let (terms, effects) = compare(&Difference::between(
            &one,
            &of_order(1, [1.0e-6, 0.0], 0.1e-6),
        ));
        assert!(
            (terms[0].change - 2.0e-6).abs() < 1e-12
                && terms[0].chance.is_none()
                && terms[0].changed.is_none()
        );
        assert!(effects[0].test.is_none() && effects[0].changed.is_none());
    }

    /// Holm's own example has three tests.
    #[test]
    fn chances_are_raised_and_keep_their_order() {
        let raised = holm(&[Some(0.01), None, Some(0.04), Some(0.03)]);
        let wanted = [Some(0.03), None, Some(0.06), Some(0.06)];
        assert!(
            raised.iter().zip(wanted).all(|(a, b)| match (a, b) {
                (Some(a), Some(b)) => (a - b).abs() < 1e-12,
                (a, b) => a.is_none() && b.is_none(),
            }),
            "{raised:?}"
        );
    }
}
