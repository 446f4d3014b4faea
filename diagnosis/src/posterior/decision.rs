//! From weighed sets to the verdict: ordered reasons, each with its number.

use super::alias::{class, simplest};
use super::discrepancy::excess;
use super::hypotheses::{Hypothesis, Says, give_way_to_causes, hypotheses, own_courses_give_way};
use super::problem::Problem;
use super::weighed::Weighed;
use crate::verdict::answer::Verdict;
use std::fmt;

/// One step of the decision.
#[derive(Clone, Debug, PartialEq)]
pub struct Reason {
    /// What was asked.
    pub asked: &'static str,
    /// What was found.
    pub found: f64,
    /// From where on the answer is yes.
    pub limit: f64,
    /// The answer.
    pub yes: bool,
}

impl fmt::Display for Reason {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let answer = if self.yes { "yes" } else { "no" };
        write!(
            f,
            "{} {answer} ({:.3}, limit {:.3})",
            self.asked, self.found, self.limit
        )
    }
}

/// How the probability is shared.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Masses {
    /// Nothing that is worth a name.
    pub no_gap: f64,
    /// A set of effects, or louder noise, that leaves little.
    pub named: f64,
    /// A gap that no set explains.
    pub unknown: f64,
}

/// An effect, or louder noise, of the answer.
#[derive(Clone, Debug, PartialEq)]
pub struct Inclusion {
    /// Its block; none for louder noise.
    pub block: Option<usize>,
    /// Probability that it acts, where anything is named.
    pub probability: f64,
    /// Whitened squares over the noise that it does.
    pub power: f64,
    /// Blocks that would do in its place.
    pub aliases: Vec<usize>,
}

/// The decision.
#[derive(Clone, Debug)]
pub struct Decision {
    /// Verdict.
    pub verdict: Verdict,
    /// What is named, the largest first.
    pub named: Vec<Inclusion>,
    /// Place, among all sets, of the one that is told: of the named ones the likeliest, or else the likeliest of all.
    pub first: usize,
    /// Whitened squares over the noise that the first set explains.
    pub explained: f64,
    /// Whitened squares over the noise that it leaves, and nothing named explains.
    pub left: f64,
    /// The same as a share of both.
    pub left_share: f64,
    /// Whitened squares over the noise that the best set leaves, what its effects' forms may lack among them.
    pub excess: f64,
    /// Blocks of coordinates that hold what it leaves, with their share of it.
    pub places: Vec<(usize, f64)>,
    /// How the probability is shared.
    pub masses: Masses,
    /// Steps.
    pub reasons: Vec<Reason>,
    /// Logarithm of the sum of all weights: the evidence of the whole comparison.
    pub log_evidence: f64,
}

/// Decides. `all` is ordered by weight; `noise_is_white` tells whether what the best set leaves has been shown to be noise.
pub fn decide(problem: &Problem, all: &[Weighed], noise_is_white: bool) -> Decision {
    let mut hypotheses = hypotheses(problem, all, noise_is_white);
    give_way_to_causes(problem, all, &mut hypotheses);
    own_courses_give_way(problem, all, &mut hypotheses);
    let total = super::noise_scale::log_sum(hypotheses.iter().map(|h| h.log_weight));
    let probability = |h: &Hypothesis| (h.log_weight - total).exp();
    let mass = |says: Says| {
        hypotheses
            .iter()
            .filter(|h| h.says == says)
            .map(probability)
            .fold(0.0, |a, b| a + b) // the sum of none is -0 otherwise
    };
    let masses = Masses {
        no_gap: mass(Says::NoGap),
        named: mass(Says::Named),
        unknown: mass(Says::Unknown),
    };
    let of_set = |k: usize| hypotheses.iter().filter(move |h| h.set == k);
    let best = &all[0];
    let left: f64 = {
        let whole: f64 = of_set(0).map(probability).sum();
        of_set(0).map(|h| probability(h) * h.left).sum::<f64>() / whole.max(f64::MIN_POSITIVE)
    };
    let explained = best.explained;
    let mut reasons = vec![
        reason("Is a gap likelier than none?", 1.0 - masses.no_gap, 0.5),
        reason(
            "Is it likelier that a set of effects explains it than that none does?",
            masses.named,
            masses.unknown,
        ),
    ];
    let mut out = Decision {
        verdict: Verdict::NoGap,
        first: of_nothing(all),
        named: Vec::new(),
        explained,
        left,
        left_share: left / (left + explained).max(f64::MIN_POSITIVE),
        excess: excess(&best.left),
        places: places(problem, best),
        masses,
        reasons: Vec::new(),
        log_evidence: total,
    };
    if reasons[0].yes {
        (out.verdict, out.first) = (Verdict::Unknown, 0);
        if reasons[1].yes {
            let by_set = |k: usize| {
                let named = of_set(k).filter(|h| h.says == Says::Named);
                named.map(probability).sum::<f64>()
            };
            let first = (0..all.len())
                .max_by(|a, b| by_set(*a).total_cmp(&by_set(*b)))
                .unwrap_or(0);
            let first = simplest(problem, all, first);
            out.first = first;
            // What a set of fewer of its own effects predicts as well is no other cause.
            let own = all[first].set();
            let others = |k: usize| all[k].set().iter().any(|b| !own.contains(b));
            let rivals = class(problem, all, first).into_iter();
            let rivals: Vec<_> = rivals.filter(|(k, _)| others(*k)).collect();
            let nearest = rivals
                .iter()
                .map(|(_, d)| d.squares / d.limit)
                .fold(f64::INFINITY, f64::min);
            let alias = Reason {
                asked: "Does another set predict the same on this motion?",
                found: nearest,
                limit: 1.0,
                yes: !rivals.is_empty(),
            };
            out.verdict = if alias.yes {
                Verdict::Alias
            } else {
                Verdict::Named
            };
            reasons.push(alias);
            let rivals: Vec<usize> = rivals.into_iter().map(|r| r.0).collect();
            out.named = named(all, first, &rivals, &hypotheses, total, masses.named);
        }
    }
    out.reasons = reasons;
    out
}

/// Place of the likeliest set of no effect, which is told where there is no gap.
fn of_nothing(all: &[Weighed]) -> usize {
    all.iter().position(|w| w.set().is_empty()).unwrap_or(0)
}

fn reason(asked: &'static str, found: f64, limit: f64) -> Reason {
    Reason {
        asked,
        found,
        limit,
        yes: found > limit,
    }
}

/// The effects of a set, and louder noise, with their probabilities and aliases.
fn named(
    all: &[Weighed],
    first: usize,
    rivals: &[usize],
    hypotheses: &[Hypothesis],
    total: f64,
    mass: f64,
) -> Vec<Inclusion> {
    let among = |of_it: &dyn Fn(&Hypothesis) -> bool| {
        let list = hypotheses
            .iter()
            .filter(|h| h.says == Says::Named && of_it(h));
        let sum: f64 = list.map(|h| (h.log_weight - total).exp()).sum();
        // Rounding may make a little more than one of all of them.
        (sum / mass.max(f64::MIN_POSITIVE)).min(1.0)
    };
    let set = all[first].set();
    let mut out: Vec<Inclusion> = Vec::new();
    for (block, power) in set.iter().zip(&all[first].powers) {
        let without = rivals.iter().filter(|r| !all[**r].set().contains(block));
        let mut aliases: Vec<usize> = without
            .flat_map(|r| all[*r].set())
            .filter(|b| !set.contains(b))
            .copied()
            .collect();
        aliases.sort_unstable();
        aliases.dedup();
        out.push(Inclusion {
            block: Some(*block),
            probability: among(&|h| all[h.set].set().contains(block)),
            power: *power,
            aliases,
        });
    }
    let noise = among(&|h| h.noise);
    if noise > 0.5 {
        let left = &all[first].left;
        let excess = all[first].noise.log_variance.exp_m1().max(0.0);
        let power = excess * left.degrees * (-left.log_noise).exp();
        out.push(Inclusion {
            block: None,
            probability: noise,
            power,
            aliases: Vec::new(),
        });
    }
    out.sort_by(|a, b| b.power.total_cmp(&a.power));
    out
}

/// Coordinates that hold what a set leaves.
fn places(problem: &Problem, best: &Weighed) -> Vec<(usize, f64)> {
    let unlisted = |b: &usize| problem.effects.iter().any(|e| e.block == *b && !e.listed);
    let of_set = best.set().iter().copied().zip(best.powers.iter().copied());
    let mut out: Vec<(usize, f64)> = of_set.filter(|(b, _)| unlisted(b)).collect();
    if let Some((shapes, _)) = &best.nameless {
        let each = shapes.coordinates.iter().zip(&shapes.powers);
        out.extend(each.map(|(c, power)| (problem.coordinates[*c], *power)));
    }
    let sum: f64 = out.iter().map(|(_, power)| power).sum();
    out.iter_mut()
        .for_each(|(_, power)| *power /= sum.max(f64::MIN_POSITIVE));
    out.sort_by(|a, b| b.1.total_cmp(&a.1));
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::posterior::problem::Prior;
    use crate::posterior::sets::weigh;
    use crate::synthetic_problem::SyntheticProblem;
    use effects::random::normal;

    /// Decides on two effects and one coordinate that act by these amounts.
    fn decided(amounts: [f64; 3], louder: f64, white: bool) -> Decision {
        let blocks = [("one", &[1.0][..]), ("other", &[1.0]), ("place", &[1.0])];
        let problem = SyntheticProblem::new(&blocks, &|rng| {
            let mut draw = || normal(rng);
            let columns = [draw(), draw(), draw()];
            let sum: f64 = columns.iter().zip(amounts).map(|(c, a)| c * a).sum();
            let noise = louder * draw();
            vec![1.0, columns[0], columns[1], columns[2], sum + noise]
        });
        let reduced = problem.reduced(&[1, 2, 3]);
        let prior = |block| Prior::of_cause(block, 0.02);
        let effects = [prior(0), prior(1)];
        let problem = Problem {
            coordinates: &[2],
            ..Problem::of_unit_noise(&reduced, &effects, -2.0)
        };
        decide(&problem, &weigh(&problem), white)
    }

    fn blocks(decision: &Decision) -> Vec<Option<usize>> {
        decision.named.iter().map(|n| n.block).collect()
    }

    #[test]
    fn verdicts_follow_from_what_acts() {
        assert_eq!(decided([0.0; 3], 1.0, true).verdict, Verdict::NoGap);
        let one = decided([1.0, 0.0, 0.0], 1.0, true);
        assert_eq!((one.verdict, blocks(&one)), (Verdict::Named, vec![Some(0)]));
        let both = decided([1.0, 0.5, 0.0], 1.0, true);
        assert_eq!(
            (both.verdict, blocks(&both)),
            (Verdict::Named, vec![Some(0), Some(1)])
        );
        let place = decided([0.0, 0.0, 1.0], 1.0, true);
        assert_eq!(
            (place.verdict, &place.places[..]),
            (Verdict::Unknown, &[(2, 1.0)][..])
        );
        let noise = decided([0.0; 3], 1.5, true);
        assert_eq!(
            (noise.verdict, blocks(&noise)),
            (Verdict::Named, vec![None])
        );
        // What is louder and has not been shown to be noise is a gap without a place.
        assert_eq!(decided([0.0; 3], 1.5, false).verdict, Verdict::Unknown);
        // An effect beside something as large that has no name explains nothing.
        assert_eq!(
            decided([1.0, 0.0, 1.0], 1.0, true).verdict,
            Verdict::Unknown
        );
    }

    /// 2,000 rows: a hundredth of the noise's rms is 40 squares, and 0.1 of an amplitude does 20. That is seen, and is not worth a name.
    #[test]
    fn a_trifle_is_no_gap() {
        assert_eq!(decided([0.1, 0.0, 0.0], 1.0, true).verdict, Verdict::NoGap);
        let beside = decided([1.0, 0.1, 0.0], 1.0, true);
        assert_eq!(blocks(&beside), [Some(0)]);
        let noise = decided([0.1, 0.0, 0.0], 1.5, true);
        assert_eq!(blocks(&noise), [None]);
    }

    /// 0.11 of an amplitude does 24 squares: two of them are seen, and that each is one too many is no reason to name the other, nor that
    /// nothing explains what both do.
    #[test]
    fn trifles_that_are_seen_together_are_no_gap() {
        let decision = decided([0.11, 0.11, 0.0], 1.0, true);
        assert_eq!(decision.verdict, Verdict::NoGap, "{:?}", decision.masses);
    }

    /// The effects of the likeliest set, of one that does three times the noise and may lack so much of it, and another that does less.
    fn told(inexactness: f64, shape: bool, listed: bool) -> Decision {
        let blocks = [("one", &[1.0][..]), ("other", &[1.0; 3])];
        let problem = SyntheticProblem::new(&blocks, &|rng| {
            let mut row = vec![1.0];
            row.extend((0..4).map(|_| normal(rng)));
            row.push(3.0 * row[1] + 0.3 * row[2] + normal(rng));
            row
        });
        let reduced = problem.reduced(&[1, 2]);
        let one = Prior {
            block: 0,
            log_odds: -2.0,
            inexactness,
            shape: false,
            listed: true,
        };
        let other = Prior {
            block: 1,
            inexactness: 0.0,
            shape,
            listed,
            ..one
        };
        let effects = [one, other];
        let problem = Problem::of_unit_noise(&reduced, &effects, -2.0);
        let all = weigh(&problem);
        assert_eq!(all[0].set(), [0, 1]);
        decide(&problem, &all, true)
    }

    /// 3 times the noise in 2,000 rows are 18,000 squares: a fifth of the amplitude may lack 720 of them, and the companion does 180.
    #[test]
    fn a_shape_within_what_a_cause_may_lack_is_not_told() {
        assert_eq!(blocks(&told(0.2, true, true)), [Some(0)]);
        let both = told(0.2, false, true);
        assert_eq!(blocks(&both), [Some(0), Some(1)]);
        // The first alone predicts the same as far as its form goes, and is no other cause.
        assert_eq!(both.verdict, Verdict::Named);
        assert_eq!(blocks(&told(0.0, true, true)), [Some(0), Some(1)]);
    }

    /// Of 3 times the noise in 2,000 rows a form that lacks three tenths may lack 1,620 squares; the companion takes 720. It is told unless what the form
    /// lacks is known to lie along its columns.
    #[test]
    fn what_may_lack_along_a_companion_is_not_told_of_it() {
        let told = |along: f64| {
            let problem = SyntheticProblem::new(&[("one", &[1.0]), ("other", &[1.0])], &|rng| {
                let (one, other, noise) = (normal(rng), normal(rng), normal(rng));
                vec![1.0, one, other, 3.0 * one + 0.6 * other + noise]
            });
            let reduced = problem.reduced(&[1, 2]);
            let effects = [Prior::of_cause(0, 0.3), Prior::of_cause(1, 0.0)];
            let problem = Problem {
                along: &along,
                ..Problem::of_unit_noise(&reduced, &effects, -2.0)
            };
            blocks(&decide(&problem, &weigh(&problem), true))
        };
        assert_eq!(told(0.9), [Some(0)]);
        assert_eq!(told(0.001), [Some(0), Some(1)]);
    }

    #[test]
    fn what_is_in_no_catalogue_explains_and_is_not_named() {
        let decision = told(0.0, false, false);
        assert_eq!(decision.verdict, Verdict::Unknown);
        assert_eq!(decision.places, [(1, 1.0)]);
    }

    /// A cause of five columns pays for its freedom beside a shape of one, which predicts the same: the cause is told all the same. It is
    /// not where the shape predicts what the cause cannot.
    #[test]
    fn a_shape_gives_way_to_a_cause_that_predicts_the_same() {
        let verdict = |apart: f64, recurring: &[usize], of_own_course: &[usize]| {
            let blocks = [("cause", &[1.0; 5][..]), ("place", &[1.0])];
            let problem = SyntheticProblem::new(&blocks, &|rng| {
                let mut draw = || normal(rng);
                let (shared, own) = (draw(), draw());
                let place = shared + apart * own;
                let noise = draw();
                vec![
                    1.0,
                    shared,
                    draw(),
                    draw(),
                    draw(),
                    draw(),
                    place,
                    place + noise,
                ]
            });
            let reduced = problem.reduced(&[1, 2]);
            let cause = Prior::of_cause(0, 0.02);
            let effects = [cause];
            let problem = Problem {
                coordinates: &[1],
                recurring,
                of_own_course,
                ..Problem::of_unit_noise(&reduced, &effects, -2.0)
            };
            let all = weigh(&problem);
            assert!(all[0].set().is_empty(), "the shape is the likelier");
            decide(&problem, &all, true).verdict
        };
        assert_eq!(verdict(0.0, &[], &[]), Verdict::Named);
        assert_eq!(verdict(1.0, &[], &[]), Verdict::Unknown);
        // What follows a quantity that recurs is not put down to a course that may be any; to a cause it is.
        assert_eq!(verdict(0.0, &[1], &[0]), Verdict::Unknown);
        assert_eq!(verdict(0.0, &[1], &[]), Verdict::Named);
        assert_eq!(verdict(0.0, &[], &[0]), Verdict::Named);
    }

    /// A cause of the catalogue predicts nearly what one that is in none does. That gives way to it, but not with what a nameless shape takes
    /// beside it.
    #[test]
    fn what_shapes_take_beside_a_cause_of_no_catalogue_stays_unknown() {
        let verdict = |shape: f64| {
            let blocks = [
                ("cause", &[1.0][..]),
                ("no cause", &[1.0]),
                ("place", &[1.0]),
            ];
            let problem = SyntheticProblem::new(&blocks, &|rng| {
                let mut draw = || normal(rng);
                let (unlisted, apart, place, noise) = (draw(), draw(), draw(), draw());
                let cause = unlisted + 0.03 * apart;
                let target = 3.0 * unlisted + shape * place + noise;
                vec![1.0, cause, unlisted, place, target]
            });
            let reduced = problem.reduced(&[1, 2, 3]);
            let cause = Prior::of_cause(0, 0.05);
            let unlisted = Prior {
                listed: false,
                ..Prior::of_cause(1, 0.05)
            };
            let effects = [cause, unlisted];
            let problem = Problem {
                coordinates: &[2],
                ..Problem::of_unit_noise(&reduced, &effects, -2.0)
            };
            decide(&problem, &weigh(&problem), true).verdict
        };
        assert_eq!(verdict(0.0), Verdict::Named);
        assert_eq!(verdict(1.0), Verdict::Unknown);
    }

    /// One column of a course of its own does what one of three columns foretells, and is the likelier for it. It gives way.
    #[test]
    fn a_course_of_its_own_gives_way_to_what_foretells_it() {
        let told = |of_own_course: &[usize]| {
            let columns = [("course", &[1.0][..]), ("foretells", &[1.0; 3])];
            let problem = SyntheticProblem::new(&columns, &|rng| {
                let mut draw = || normal(rng);
                let (course, one, other, noise) = (draw(), draw(), draw(), draw());
                vec![1.0, course, course, one, other, 2.0 * course + noise]
            });
            let reduced = problem.reduced(&[1, 2]);
            let prior = |block| Prior::of_cause(block, 0.02);
            let effects = [prior(0), prior(1)];
            let problem = Problem {
                of_own_course,
                ..Problem::of_unit_noise(&reduced, &effects, -2.0)
            };
            let decision = decide(&problem, &weigh(&problem), true);
            (decision.verdict, blocks(&decision))
        };
        assert_eq!(told(&[]), (Verdict::Alias, vec![Some(0)]));
        assert_eq!(told(&[0]), (Verdict::Named, vec![Some(1)]));
        assert_eq!(told(&[1]), (Verdict::Named, vec![Some(0)]));
    }
}
