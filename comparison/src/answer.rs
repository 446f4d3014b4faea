//! All that is told of some estimates: each against the first, a trend over three or more, a budget of each.

use crate::budget::{self, Budget, Conditions};
use crate::changes::{self, Change, Compared, EffectChange, is_change};
use crate::difference::Difference;
use crate::estimate::{Certainty, Estimate, Unknown};
use crate::largest::{Known, Largest, largest};
use crate::repeats::{Repeats, beside_repeats};
use crate::significance::{JointTest, Root};
use crate::trend::{Over, trend};
use crate::workspace::{Pose, Quantity, Workspace, row};
use nalgebra::DVector;
use serde::Serialize;

/// What is asked.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Question {
    /// Largest angle of the workspace, radians.
    pub turn_rad: f64,
    /// Whether a budget is wanted, under which conditions.
    pub budget: Option<Conditions>,
    /// Where; where it is largest if not said.
    pub at: Option<Pose>,
    /// So many of the first are repeats of one state, whose scatter tells what chance is; 0 or 1 where none are.
    pub repeats: usize,
}

/// All that is told.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Answer {
    /// What was compared.
    pub compared: Vec<Input>,
    /// How far the repeats scatter, where there are any.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub repeats: Option<Told<Repeats>>,
    /// Each but the first, against the first.
    pub differences: Vec<Pair>,
    /// The straight line through three or more.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub trend: Option<Told<Line>>,
    /// A budget of each, where it was asked for.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub budgets: Vec<Told<Budgets>>,
}

/// Something, or why it cannot be told.
#[derive(Clone, Debug, PartialEq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Told<T> {
    /// It.
    Known(T),
    /// Why not.
    Unknown(String),
}

impl<T> From<Result<T, String>> for Told<T> {
    fn from(result: Result<T, String>) -> Self {
        result.map_or_else(Self::Unknown, Self::Known)
    }
}

/// One of those that were compared.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Input {
    /// Its name.
    pub name: String,
    /// What it is.
    pub about: String,
    /// When it was made, seconds since 1970 UTC.
    pub made_s: Option<f64>,
    /// Where its covariance comes from; or why it has none.
    pub certainty: Told<String>,
    /// What is left out of it, and why.
    pub left_out: Vec<String>,
}

/// One against another.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Pair {
    /// Name of the first.
    pub first: String,
    /// Name of the second.
    pub second: String,
    /// Whether they differ beyond chance; or why that cannot be told.
    pub test: Told<JointTest>,
    /// Whether the chance is below 5 %.
    pub changed: Option<bool>,
    /// The largest change of x, y and the angle over the workspace.
    pub largest: Vec<Largest>,
    /// By effect.
    pub effects: Vec<EffectChange>,
    /// By term, the surest change first.
    pub terms: Vec<Change>,
    /// The change over a tooth.
    pub map: Vec<Cell>,
    /// What one of them has alone, or held: it is not compared.
    pub left_out: Vec<String>,
}

/// A place over a tooth at the angle zero, and a number of each quantity there.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Cell {
    /// The platen sensor's place from the tooth's zero phase, metres.
    pub centre_m: [f64; 2],
    /// Of x and y, metres, and of the angle, radians.
    pub values: [f64; 3],
}

/// The straight line.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Line {
    /// What it is over.
    pub over: Over,
    /// Where each is on it.
    pub at: Vec<f64>,
    /// Whether there is a slope.
    pub test: JointTest,
    /// Whether the chance of that is below 5 %.
    pub changes: bool,
    /// Whether they stray from the line beyond chance.
    pub straying: JointTest,
    /// Whether the chance of that is below 5 %.
    pub strays: bool,
    /// By how much each ± is raised for it.
    pub raised: f64,
    /// The largest slope of x, y and the angle over the workspace, a day or a step.
    pub largest: Vec<Largest>,
    /// Slopes by term: the change is that of a day or a step.
    pub terms: Vec<Change>,
}

/// Budgets of x, y and the angle.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Budgets {
    /// Of what.
    pub of: String,
    /// One of each quantity, at the place asked for or where it is largest.
    pub budgets: Vec<Budget>,
    /// Over the workspace.
    pub range: Vec<Range>,
    /// Expanded uncertainties over a tooth.
    pub map: Vec<Cell>,
    /// What is not counted.
    pub not_counted: Vec<&'static str>,
}

/// How an expanded uncertainty goes over the workspace.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Range {
    /// Of what.
    pub quantity: Quantity,
    /// Smallest, m or rad.
    pub smallest: f64,
    /// Root of the mean square.
    pub rms: f64,
    /// Largest.
    pub largest: f64,
    /// Where.
    pub pose: Pose,
}

/// Of one estimate or more of one courier.
#[must_use]
pub fn answer(estimates: &[Estimate], question: &Question) -> Answer {
    let beside = (question.repeats > 1).then(|| beside_repeats(estimates, question.repeats));
    let (repeats, raised) = match beside {
        Some(Ok((repeats, raised))) => (Some(Ok(repeats)), raised),
        Some(Err(why)) => (Some(Err(why)), estimates.to_vec()),
        None => (None, estimates.to_vec()),
    };
    let pairs = raised.iter().skip(1);
    let pairs = pairs.map(|second| pair(&raised[0], second, question.turn_rad));
    let budgets = question.budget.map(|conditions| {
        let one = |of: &Estimate| {
            let told = budgets(of, &conditions, question);
            told.map_err(|why| format!("{}: {why}", of.name)).into()
        };
        raised.iter().map(one).collect()
    });
    Answer {
        compared: estimates.iter().map(input).collect(),
        repeats: repeats.map(Told::from),
        differences: pairs.collect(),
        trend: (raised.len() > 2).then(|| line(&raised, question.turn_rad).into()),
        budgets: budgets.unwrap_or_default(),
    }
}

fn input(estimate: &Estimate) -> Input {
    let certainty = estimate
        .certainty
        .as_ref()
        .map(|certainty| certainty.source.clone());
    Input {
        name: estimate.name.clone(),
        about: estimate.about.clone(),
        made_s: estimate.made_s,
        certainty: certainty.map_err(Clone::clone).into(),
        left_out: estimate.left_out.clone(),
    }
}

fn pair(first: &Estimate, second: &Estimate, turn_rad: f64) -> Pair {
    let apart = Difference::between(first, second);
    let values = apart.values();
    let root = apart
        .certainty
        .as_ref()
        .map(|certainty| (Root::of(&certainty.covariance), certainty.scale()));
    let test = root
        .as_ref()
        .map(|(root, scale)| root.test(&values, *scale))
        .map_err(|why| (*why).clone());
    let workspace = Workspace {
        geometry: apart.geometry,
        turn_rad,
    };
    let known = Known {
        unknowns: &apart.unknowns,
        values: &values,
        root: root
            .as_ref()
            .ok()
            .map(|(root, scale)| (root, scale.freedom)),
    };
    let compared = Compared {
        unknowns: &apart.unknowns,
        first: &apart.first,
        second: &apart.second,
        certainty: apart.certainty.as_ref().ok().map(of_certainty),
    };
    Pair {
        first: first.name.clone(),
        second: second.name.clone(),
        changed: test.as_ref().ok().map(|test| is_change(test.chance)),
        test: test.into(),
        largest: largest_of_all(&known, &workspace),
        effects: changes::effects(&compared),
        terms: changes::terms(&compared),
        map: change_map(&apart.unknowns, &values, &workspace),
        left_out: apart.left_out,
    }
}

fn change_map(unknowns: &[Unknown], values: &DVector<f64>, workspace: &Workspace) -> Vec<Cell> {
    let at = |pose: Pose| Cell {
        centre_m: pose.centre_m,
        values: Quantity::ALL.map(|quantity| {
            let row = row(unknowns, &workspace.geometry, &pose, quantity);
            row.iter().zip(values.iter()).map(|(a, b)| a * b).sum()
        }),
    };
    workspace.plane().into_iter().map(at).collect()
}

fn of_certainty(certainty: &Certainty) -> (&nalgebra::DMatrix<f64>, f64) {
    (&certainty.covariance, certainty.freedom)
}

/// Of the position, whose bands hold together, and of the angle.
fn largest_of_all(known: &Known, workspace: &Workspace) -> Vec<Largest> {
    let mut list = largest(known, workspace, &[Quantity::X, Quantity::Y]);
    list.extend(largest(known, workspace, &[Quantity::Theta]));
    list
}

fn line(estimates: &[Estimate], turn_rad: f64) -> Result<Line, String> {
    let trend = trend(estimates)?;
    let zero = DVector::zeros(trend.slope.len());
    let root = Root::of(&trend.certainty.covariance);
    let known = Known {
        unknowns: &trend.unknowns,
        values: &trend.slope,
        root: Some((&root, trend.certainty.freedom)),
    };
    let workspace = Workspace {
        geometry: estimates[0].geometry,
        turn_rad,
    };
    let compared = Compared {
        unknowns: &trend.unknowns,
        first: &zero,
        second: &trend.slope,
        certainty: Some(of_certainty(&trend.certainty)),
    };
    Ok(Line {
        over: trend.over,
        changes: is_change(trend.slope_test.chance),
        strays: is_change(trend.straying.chance),
        raised: trend.raised,
        largest: largest_of_all(&known, &workspace),
        terms: changes::terms(&compared),
        at: trend.at,
        test: trend.slope_test,
        straying: trend.straying,
    })
}

fn budgets(
    estimate: &Estimate,
    conditions: &Conditions,
    question: &Question,
) -> Result<Budgets, String> {
    let workspace = Workspace {
        geometry: estimate.geometry,
        turn_rad: question.turn_rad,
    };
    let (mut budgets, mut range) = (Vec::new(), Vec::new());
    for quantity in Quantity::ALL {
        let map = budget::map(estimate, conditions, &workspace, quantity)?;
        let by_size = |a: &&Budget, b: &&Budget| a.expanded.total_cmp(&b.expanded);
        let (Some(smallest), Some(largest)) =
            (map.iter().min_by(by_size), map.iter().max_by(by_size))
        else {
            continue;
        };
        let square = map.iter().map(|of| of.expanded.powi(2)).sum::<f64>() / map.len() as f64;
        range.push(Range {
            quantity,
            smallest: smallest.expanded,
            rms: square.sqrt(),
            largest: largest.expanded,
            pose: largest.pose,
        });
        budgets.push(match &question.at {
            Some(pose) => budget::budget(estimate, conditions, pose, quantity)?,
            None => largest.clone(),
        });
    }
    let at = |pose: Pose| {
        let mut values = [0.0; 3];
        for (value, quantity) in values.iter_mut().zip(Quantity::ALL) {
            *value = budget::budget(estimate, conditions, &pose, quantity)?.expanded;
        }
        Ok(Cell {
            centre_m: pose.centre_m,
            values,
        })
    };
    Ok(Budgets {
        of: estimate.name.clone(),
        budgets,
        range,
        map: workspace
            .plane()
            .into_iter()
            .map(at)
            .collect::<Result<_, String>>()?,
        not_counted: budget::not_counted(conditions),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::difference::tests::of_order;

    const QUESTION: Question = Question {
        turn_rad: 8.727e-3,
        budget: None,
        at: None,
        repeats: 0,
    };

    #[test]
    fn two_are_a_pair_and_three_have_a_trend() {
        let list = [0.0, 1.0e-6, 2.0e-6].map(|value| of_order(1, [value, 0.0], 0.1e-6));
        let two = answer(&list[..2], &QUESTION);
        assert_eq!((two.compared.len(), two.differences.len()), (2, 1));
        assert!(two.trend.is_none() && two.budgets.is_empty());
        assert_eq!(two.differences[0].changed, Some(true));
        // Half of a segment's 1 µm, wherever y is.
        let map = &two.differences[0].map;
        let most = map
            .iter()
            .map(|cell| cell.values[0].abs())
            .fold(0.0, f64::max);
        assert!(
            (most / 0.5e-6 - 1.0).abs() < 1.0e-6 && map.iter().all(|cell| cell.values[1] == 0.0)
        );
        let three = answer(&list, &QUESTION);
        let Some(Told::Known(line)) = &three.trend else {
            panic!("{three:?}")
        };
        assert!(line.changes && !line.strays, "{line:?}");
        // Half of a step's 1 µm: a pair's mean.
        assert!(
            (line.largest[0].value.abs() / 0.5e-6 - 1.0).abs() < 1.0e-6,
            "{line:?}"
        );
    }

    /// Three repeats that scatter by ten deviations: what was a change is none.
    #[test]
    fn repeats_tell_what_chance_is() {
        let list = [0.0, 1.0e-6, 2.0e-6, 3.0e-6].map(|value| of_order(1, [value, 0.0], 0.1e-6));
        let told = answer(
            &list,
            &Question {
                repeats: 3,
                ..QUESTION
            },
        );
        let Some(Told::Known(repeats)) = &told.repeats else {
            panic!("{told:?}")
        };
        // 2 µm² about their mean, of 0.01 each, over four directions.
        assert!(
            (repeats.raised / 50.0_f64.sqrt() - 1.0).abs() < 1.0e-6,
            "{repeats:?}"
        );
        let changed = |told: &Answer| -> Vec<Option<bool>> {
            told.differences.iter().map(|pair| pair.changed).collect()
        };
        assert_eq!(changed(&told)[..2], [Some(false); 2]);
        assert_eq!(changed(&answer(&list, &QUESTION)), [Some(true); 3]);
    }

    #[test]
    fn what_has_no_covariance_gives_its_difference_alone() {
        let mut list = [0.0, 1.0e-6].map(|value| of_order(1, [value, 0.0], 0.1e-6));
        list[1].certainty = Err("not told".into());
        let told = answer(
            &list,
            &Question {
                budget: Some(Conditions::default()),
                ..QUESTION
            },
        );
        assert!(
            matches!(&told.differences[0].test, Told::Unknown(why) if why.contains("not told")),
            "{told:?}"
        );
        assert!(
            told.differences[0].changed.is_none()
                && told.differences[0].largest[0].value.abs() > 0.4e-6
        );
        assert!(
            matches!(&told.budgets[..], [Told::Known(_), Told::Unknown(_)]),
            "{told:?}"
        );
    }

    #[test]
    fn a_budget_is_at_the_place_asked_for() {
        let pose = Pose {
            centre_m: [1.0e-4, 0.0],
            theta_rad: 0.0,
        };
        let question = Question {
            budget: Some(Conditions::default()),
            at: Some(pose),
            ..QUESTION
        };
        let told = answer(&[of_order(1, [0.0; 2], 0.2e-6)], &question);
        let Told::Known(budgets) = &told.budgets[0] else {
            panic!("{told:?}")
        };
        assert_eq!((budgets.budgets.len(), budgets.budgets[0].pose), (3, pose));
        let x = &budgets.range[0];
        // The same all over the tooth, for sine and cosine that are known alike: to rounding.
        let sizes = [x.smallest, x.rms, x.largest, budgets.budgets[0].expanded];
        assert!(
            sizes
                .iter()
                .all(|size| (size / x.largest - 1.0).abs() < 1.0e-9),
            "{sizes:?}"
        );
    }
}
