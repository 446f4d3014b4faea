//! Simulated couriers, each beside what bounds it: a diagnosis that is told which effects act, and an ideal observer.

use crate::claim::Claim;
use crate::ideal::{Ideal, ideal};
use crate::judged::Judged;
use crate::those_that_act;
use diagnosis::figures::{Answer, Decision};
use diagnosis::verdict::answer::Verdict;
use diagnosis::{Options, check, diagnose_fully};
use rayon::prelude::*;
use specimens::{Case, Conditions, Kind};
use std::fmt;
use std::time::Instant;

/// A case with its bounds.
pub struct Bounded {
    /// As it is diagnosed.
    pub judged: Judged,
    /// By a diagnosis that is told which effects act: what it gets wrong is no matter of telling them from others.
    pub told: Judged,
    /// What an ideal observer sees.
    pub ideal: Ideal,
    /// How it was decided; none where the recording cannot answer.
    pub decision: Option<Decision>,
    /// Time that the diagnosis took, s.
    pub took_s: f64,
}

impl Bounded {
    /// Whether the diagnosis is exactly right: what is there and nothing else, in any order; an alias class that holds it.
    #[must_use]
    pub fn is_right(&self) -> bool {
        exactly(&self.judged)
    }

    /// Whether the diagnosis that is told which effects may act is exactly right.
    #[must_use]
    pub fn can_be_told(&self) -> bool {
        exactly(&self.told)
    }
}

/// Whether an answer names what is there and nothing else, where each name may stand for one of its aliases.
fn exactly(judged: &Judged) -> bool {
    let (truth, told) = (judged.truth(), judged.told());
    if matches!(judged.case.kind, Kind::None | Kind::Unlisted) {
        return judged.right();
    }
    let in_class = |name: &&str| {
        let own = told.contains(name);
        own || judged.verdict == Verdict::Alias && judged.aliases.iter().any(|n| n == name)
    };
    told.len() == truth.len() && truth.iter().all(in_class)
}

/// Diagnoses some cases of a campaign; `report` is given each as it is done, with the likeliest sets if `explain`.
pub fn bounded(
    cases: impl Iterator<Item = usize>,
    seed: u64,
    conditions: Conditions,
    explain: bool,
    report: impl Fn(&Bounded) + Sync,
) -> Vec<Bounded> {
    let cases: Vec<Case> = cases
        .map(|number| Case::draw(number, seed, conditions))
        .collect();
    let each = |case: &Case| {
        let recording = case.recorded(0);
        let options = Options {
            explain,
            ..Options::default()
        };
        let start = Instant::now();
        let answer = diagnose_fully(&recording, "case", &options);
        let took_s = start.elapsed().as_secs_f64();
        let told = diagnose_fully(&recording, "told", &those_that_act(case));
        let again = answer.model.as_ref().map(|model| {
            let second = case.recorded(1);
            check(model, &second).unwrap_or_default()
        });
        let claim = again.map(|again| Claim::new(&answer.diagnosis.held_out, Some(&again), None));
        let judged = |answer: &Answer, claim| Judged::new(case, &answer.diagnosis, claim, None);
        let out = Bounded {
            took_s,
            ideal: ideal(case),
            told: judged(&told, None),
            judged: judged(&answer, claim),
            decision: answer.decision,
        };
        report(&out);
        out
    };
    cases.par_iter().map(each).collect()
}

/// Cases of a kind: all of them, and how many of them are right.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counts {
    /// All.
    pub cases: usize,
    /// Right.
    pub right: usize,
    /// Right where it is told which effects act.
    pub can_be_told: usize,
    /// Cases that an ideal observer has right in the mean.
    pub ideal: f64,
    /// Of the cases each effect of which is worth a name those that are right, and all.
    pub worth_a_name: [usize; 2],
    /// With something named that is not there.
    pub wrong_names: usize,
    /// Claims that the second recording confirms, and all claims.
    pub confirmed: [usize; 2],
}

impl Counts {
    /// Of some cases.
    pub fn of<'p>(cases: impl Iterator<Item = &'p Bounded>) -> Self {
        let mut out = Self::default();
        for case in cases {
            let right = usize::from(case.is_right());
            out.cases += 1;
            out.right += right;
            out.can_be_told += usize::from(case.can_be_told());
            out.ideal += case.ideal.seen;
            if case.ideal.worth_a_name {
                out.worth_a_name[0] += right;
                out.worth_a_name[1] += 1;
            }
            out.wrong_names += usize::from(case.judged.wrong_culprit());
            let holds = case.judged.claim.as_ref().and_then(Claim::holds);
            out.confirmed[0] += usize::from(holds == Some(true));
            out.confirmed[1] += usize::from(holds.is_some());
        }
        out
    }
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self {
            cases,
            right,
            can_be_told,
            ideal,
            worth_a_name: [of_them, worth],
            wrong_names,
            confirmed: [hold, claim],
        } = self;
        write!(
            f,
            "{cases} cases: right {right}, where it is told which act {can_be_told}, by an ideal observer {ideal:.1}; of {worth} with effects \
             worth a name {of_them} right; wrong names {wrong_names}; claims confirmed {hold} of {claim}"
        )
    }
}
