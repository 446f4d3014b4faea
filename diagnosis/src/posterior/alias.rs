//! Sets that predict the same on this motion are one class, whatever Occam's factor says of them: no further recording of the same motion
//! would tell which it is.

use super::discrepancy::{excess, share_by_chance};
use super::problem::Problem;
use super::weighed::Weighed;
use crate::algebra::statistics::NORMAL_95;
use nalgebra::DVector;

/// A set is no rival if one of its effects is a trifle with more than this probability: the same 95 %. By definition as certain
/// as an interval (Fisher 1925).
const TRIFLE: f64 = 0.95;

/// How far the predictions of two sets are apart, in whitened squares over the noise, and how far they may be for the same cause.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Divergence {
    /// Squares of the difference of both predictions over all rows: twice the divergence of the predictive distributions.
    pub squares: f64,
    /// What noise and the effects' own inexactness make of one cause, to 95 %.
    pub limit: f64,
}

impl Divergence {
    /// True if the two cannot be told apart.
    pub fn is_alias(&self) -> bool {
        self.squares <= self.limit
    }
}

/// Whitened squares below which 95 of 100 differences lie that noise makes of predictions with so many coefficients: a chi-square, by its
/// normal approximation.
pub fn limit(told: f64) -> f64 {
    told + NORMAL_95 * (2.0 * told).sqrt()
}

/// True unless one of its effects is likely to be a trifle.
pub fn is_no_trifle(weighed: &Weighed) -> bool {
    weighed.log_least > (1.0 - TRIFLE).ln()
}

/// What a set predicts on this motion.
struct Prediction<'a> {
    problem: &'a Problem<'a>,
    weighed: &'a Weighed,
    /// Products of every column with the prediction, over all rows.
    products: DVector<f64>,
    /// Squares of the prediction.
    squares: f64,
}

impl<'a> Prediction<'a> {
    /// Cost: all columns for each of the set's.
    fn of(problem: &'a Problem<'a>, weighed: &'a Weighed) -> Self {
        let normal = &problem.reduced.normal;
        let amounts = weighed.fitted.given.coefficients.iter();
        let mut products = DVector::zeros(normal.nrows());
        for (c, amount) in problem.reduced.columns(weighed.set()).iter().zip(amounts) {
            products.axpy(*amount, &normal.column(*c), 1.0);
        }
        let squares = along(problem, weighed, &products);
        Self {
            problem,
            weighed,
            products,
            squares,
        }
    }

    /// How far another set's prediction is from it. Cost: the square of the other's columns.
    fn divergence(&self, other: &Weighed) -> Divergence {
        let Self {
            problem, weighed, ..
        } = *self;
        let columns = problem.reduced.columns(other.set());
        let amounts = &other.fitted.given.coefficients;
        let own = amounts.dot(&(problem.reduced.square(&columns) * amounts));
        let squares = self.squares + own - 2.0 * along(problem, other, &self.products);
        let squares = squares.max(least_apart(weighed, other));
        let noise = problem.stated * weighed.left.log_noise.exp();
        let told = weighed.fitted.given.told + other.fitted.given.told;
        Divergence {
            squares: squares / noise,
            limit: limit(told) + lacking_apart(problem, weighed, other),
        }
    }
}

/// Squares by which the predictions of two sets differ at least: no less than what they leave of the same readings differs in length. Where
/// a motion hardly tells a set's amounts, and the noise of its columns is taken off, they may be so large that the set seems to leave less than
/// nothing. Of such a set nothing is known, and it is infinite.
fn least_apart(one: &Weighed, other: &Weighed) -> f64 {
    let [one, other] = [one, other].map(|w| w.fitted.given.squares);
    if one < 0.0 || other < 0.0 {
        return f64::INFINITY;
    }
    (one.sqrt() - other.sqrt()).powi(2)
}

/// Whitened squares by which the forms of two sets' effects may make them differ. Of the lines that an effect in one of
/// them alone makes, the forms of effects without lines lack nothing.
fn lacking_apart(problem: &Problem, one: &Weighed, other: &Weighed) -> f64 {
    let in_one_alone = |a: &Weighed, b: &Weighed| {
        let makes_lines = |e: &&usize| problem.of_lines.contains(e);
        let mut own = a.set().iter().filter(makes_lines);
        own.any(|e| !b.set().contains(e))
    };
    if in_one_alone(one, other) || in_one_alone(other, one) {
        one.lacking_of_lines + other.lacking_of_lines
    } else {
        one.lacking + other.lacking
    }
}

/// A set's amounts times some products of the columns.
fn along(problem: &Problem, weighed: &Weighed, products: &DVector<f64>) -> f64 {
    let columns = problem.reduced.columns(weighed.set());
    let each = columns.iter().zip(weighed.fitted.given.coefficients.iter());
    each.map(|(c, amount)| amount * products[*c]).sum()
}

/// Divergence of two sets.
pub fn divergence(problem: &Problem, one: &Weighed, other: &Weighed) -> Divergence {
    Prediction::of(problem, one).divergence(other)
}

/// Places, among all weighed sets, of those that predict what one of them does, with no more effects, none of them a trifle, and none
/// beside those of another such set. A set with more effects that follow a course of their own predicts the same by coincidence alone. What the
/// counts show of an effect, a set without it does not predict.
pub fn class(problem: &Problem, all: &[Weighed], of: usize) -> Vec<(usize, Divergence)> {
    let best = &all[of];
    if best.set().is_empty() {
        return Vec::new();
    }
    let of_own_course = |w: &Weighed| {
        let each = w.set().iter();
        each.filter(|b| problem.of_own_course.contains(b)).count()
    };
    let shown = |b: &&usize| problem.in_the_counts.contains(b);
    let shows_the_same = |other: &Weighed| {
        best.set()
            .iter()
            .filter(shown)
            .all(|b| other.set().contains(b))
    };
    let rival = |k: &usize| {
        let other = &all[*k];
        other.set() != best.set()
            && shows_the_same(other)
            && of_own_course(other) <= of_own_course(best)
            && other.listed
            && other.left.log_noise == best.left.log_noise
            && !other.set().is_empty()
            && other.set().len() <= best.set().len()
            && is_no_trifle(other)
    };
    let prediction = Prediction::of(problem, best);
    let far = (0..all.len())
        .filter(rival)
        .map(|k| (k, prediction.divergence(&all[k])));
    let mut out: Vec<(usize, Divergence)> = far.filter(|(_, d)| d.is_alias()).collect();
    let within = |a: &Weighed, b: &Weighed| {
        a.set().len() < b.set().len() && a.set().iter().all(|e| b.set().contains(e))
    };
    let smaller: Vec<usize> = out.iter().map(|(k, _)| *k).collect();
    out.retain(|(k, _)| !smaller.iter().any(|s| within(&all[*s], &all[*k])));
    out
}

/// Place of the set that is told for one: the one of fewest of its effects that predicts what it does (9), if the effects besides take no
/// more of what that one leaves than so many columns do by chance of what a form lacks; itself if there is none.
pub fn simplest(problem: &Problem, all: &[Weighed], of: usize) -> usize {
    let whole = &all[of];
    if whole.set().len() < 2 {
        return of;
    }
    let prediction = Prediction::of(problem, whole);
    let left = excess(&whole.left);
    let same = |k: &usize| {
        let other = &all[*k];
        let within = other.set().iter().all(|e| whole.set().contains(e));
        let fewer = within && !other.set().is_empty() && other.set().len() < whole.set().len();
        if !fewer || other.listed != whole.listed || other.left.log_noise != whole.left.log_noise {
            return false;
        }
        let before = excess(&other.left);
        let columns = whole.fitted.given.told - other.fitted.given.told;
        let by_chance = before - left <= share_by_chance(columns, problem.reduced.rows) * before;
        by_chance && prediction.divergence(other).is_alias()
    };
    let rank = |k: &usize| (all[*k].set().len(), *k);
    (0..all.len()).filter(same).min_by_key(rank).unwrap_or(of)
}

#[cfg(test)]
mod tests {
    use crate::posterior::problem::{Prior, Problem};
    use crate::posterior::sets::weigh;
    use crate::synthetic_problem::SyntheticProblem;
    use effects::random::normal;

    /// Whether an effect of one column and one of three, which holds that column to a part, are told apart.
    fn told_apart(apart: f64, inexactness: f64, in_the_counts: &[usize]) -> bool {
        let blocks = [("one", &[1.0][..]), ("three", &[1.0; 3])];
        let problem = SyntheticProblem::new(&blocks, &|rng| {
            let mut draw = || normal(rng);
            let (one, other, third, fourth, noise) = (draw(), draw(), draw(), draw(), draw());
            vec![
                1.0,
                one,
                one + apart * fourth,
                other,
                third,
                2.0 * one + noise,
            ]
        });
        let reduced = problem.reduced(&[1, 2]);
        let prior = |block| Prior::of_cause(block, inexactness);
        let effects = [prior(0), prior(1)];
        let problem = Problem {
            in_the_counts,
            ..Problem::of_unit_noise(&reduced, &effects, -2.0)
        };
        let all = weigh(&problem);
        assert_eq!(
            all[0].set(),
            [0],
            "fewer columns that do the same are likelier"
        );
        super::class(&problem, &all, 0).is_empty()
    }

    /// Sets differ by no less than what they leave does, and one that seems to leave less than nothing is like no other.
    #[test]
    fn what_leaves_less_than_nothing_is_no_alias() {
        let blocks = [("one", &[1.0][..]), ("same", &[1.0])];
        let problem = SyntheticProblem::new(&blocks, &|rng| {
            let (one, apart, noise) = (normal(rng), normal(rng), normal(rng));
            vec![1.0, one, one + 0.01 * apart, 2.0 * one + noise]
        });
        let reduced = problem.reduced(&[1, 2]);
        let prior = |block| Prior::of_cause(block, 0.1);
        let effects = [prior(0), prior(1)];
        let problem = Problem::of_unit_noise(&reduced, &effects, -2.0);
        let mut all = weigh(&problem);
        let of = |set: &[usize]| all.iter().position(|w| w.set() == set).unwrap();
        let (one, same, none) = (of(&[0]), of(&[1]), of(&[]));
        assert!(super::divergence(&problem, &all[one], &all[same]).is_alias());
        let far = super::divergence(&problem, &all[one], &all[none]);
        assert!(far.squares >= super::least_apart(&all[one], &all[none]));
        assert!(!far.is_alias());
        all[same].fitted.given.squares = -1.0;
        assert!(!super::divergence(&problem, &all[one], &all[same]).is_alias());
    }

    /// Effects of the set that is told where the second takes so much of what the first leaves, which may lack as much and more.
    fn told_beside(companion: f64, left: f64, of_lines: &[usize]) -> Vec<usize> {
        let blocks = [("one", &[1.0][..]), ("other", &[1.0])];
        let problem = SyntheticProblem::new(&blocks, &|rng| {
            let (one, other, noise) = (normal(rng), normal(rng), normal(rng));
            let rest = left * normal(rng);
            vec![
                1.0,
                one,
                other,
                3.0 * one + companion * other + rest + noise,
            ]
        });
        let reduced = problem.reduced(&[1, 2]);
        let prior = |block| Prior::of_cause(block, 0.3);
        let effects = [prior(0), prior(1)];
        let problem = Problem {
            of_lines,
            ..Problem::of_unit_noise(&reduced, &effects, -2.0)
        };
        let all = weigh(&problem);
        let both = all.iter().position(|w| w.set() == [0, 1]).unwrap();
        all[super::simplest(&problem, &all, both)].set().to_vec()
    }

    /// 0.3 of an amplitude is 180 squares of 2,000 rows, 0.7 is 980, and three tenths of 3 are 1,600. Of one direction of 80 that many are a part of what is
    /// left by chance (a quarter, once in a thousand).
    #[test]
    fn a_companion_that_takes_a_part_of_what_may_lack_is_not_told() {
        assert_eq!(told_beside(0.3, 0.7, &[]), [0]);
        assert_eq!(told_beside(0.3, 0.0, &[]), [0, 1]);
        assert_eq!(told_beside(1.5, 0.7, &[]), [0, 1]);
        // Where the first leaves nothing, the other takes nothing.
        assert_eq!(told_beside(0.1, 0.0, &[]), [0]);
        // Lines in the spectrum are nothing that the form of the first lacks.
        assert_eq!(told_beside(0.5, 0.7, &[1]), [0, 1]);
    }

    /// The effect of three columns pays for its freedom, and is an alias all the same.
    #[test]
    fn what_predicts_the_same_is_one_class_whatever_its_columns() {
        assert!(!told_apart(0.0, 0.0, &[]));
        assert!(told_apart(0.3, 0.0, &[]));
        // What the counts show of the first, they do not show of the other.
        assert!(told_apart(0.0, 0.0, &[0]) && !told_apart(0.0, 0.0, &[1]));
        // Of forms that may lack three tenths, the same difference tells nothing.
        assert!(!told_apart(0.3, 0.3, &[]));
    }
}
