//! The same couriers answered by the rules of `selection` and by the posterior: which of them either alone has right.

use crate::claim::Claim;
use crate::ideal::{Ideal, ideal};
use crate::judged::Judged;
use crate::those_that_act;
use diagnosis::posterior::diagnosed::Answer;
use diagnosis::selection::Answer as FullAnswer;
use diagnosis::selection::by_posterior::diagnose_by_posterior;
use diagnosis::verdict::answer::Verdict;
use diagnosis::{Options, check, diagnose_fully};
use rayon::prelude::*;
use specimens::{Case, Conditions, Kind};
use std::fmt;
use std::time::Instant;

/// A case with both answers.
pub struct Pair {
    /// By the rules.
    pub rules: Judged,
    /// By the posterior.
    pub posterior: Judged,
    /// By a posterior that is told which effects act: what it gets wrong is no matter of telling them from others.
    pub bound: Judged,
    /// What an ideal observer sees.
    pub ideal: Ideal,
    /// The posterior's answer; none where the recording cannot answer.
    pub answer: Option<Answer>,
    /// Time that both took, s: the rules, the posterior.
    pub took_s: [f64; 2],
}

impl Pair {
    /// Whether each of them is exactly right: what is there and nothing else, in any order; an alias class that holds it.
    #[must_use]
    pub fn right(&self) -> [bool; 2] {
        [exactly(&self.rules), exactly(&self.posterior)]
    }

    /// Whether the posterior that is told which effects may act is exactly right.
    #[must_use]
    pub fn can_be_told(&self) -> bool {
        exactly(&self.bound)
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

/// Answers some cases of a campaign by both; `report` is given each as it is done, with the likeliest sets if `explain`.
pub fn paired(
    cases: impl Iterator<Item = usize>,
    seed: u64,
    conditions: Conditions,
    explain: bool,
    report: impl Fn(&Pair) + Sync,
) -> Vec<Pair> {
    let cases: Vec<Case> = cases
        .map(|number| Case::draw(number, seed, conditions))
        .collect();
    let both = |case: &Case| {
        let recording = case.recorded(0);
        let options = Options::default();
        let start = Instant::now();
        let rules = diagnose_fully(&recording, "paired", &options);
        let middle = Instant::now();
        let (posterior, answer) = diagnose_by_posterior(&recording, "paired", &options, explain);
        let took_s = [
            (middle - start).as_secs_f64(),
            middle.elapsed().as_secs_f64(),
        ];
        let (told, _) = diagnose_by_posterior(&recording, "told", &those_that_act(case), false);
        let second = case.recorded(1);
        let judged = |answer: &FullAnswer, claimed: bool| {
            let model = answer.model.as_ref().filter(|_| claimed);
            let again = model.map(|model| check(model, &second).unwrap_or_default());
            let claim =
                again.map(|again| Claim::new(&answer.diagnosis.held_out, Some(&again), None));
            Judged::new(case, &answer.diagnosis, claim, None)
        };
        let pair = Pair {
            took_s,
            ideal: ideal(case),
            bound: judged(&told, false),
            rules: judged(&rules, true),
            posterior: judged(&posterior, true),
            answer,
        };
        report(&pair);
        pair
    };
    cases.par_iter().map(both).collect()
}

/// Cases of a kind: all, right by both, by the rules alone, by the posterior alone, by neither.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Counts {
    /// All.
    pub cases: usize,
    /// Right by both.
    pub both: usize,
    /// Right by the rules alone.
    pub rules_only: usize,
    /// Right by the posterior alone.
    pub posterior_only: usize,
    /// Cases that an ideal observer has right in the mean.
    pub ideal: f64,
    /// Of the cases each effect of which is worth a name those right by the rules, those right by the posterior, and all.
    pub worth_a_name: [usize; 3],
    /// With something named that is not there: by the rules, and by the posterior.
    pub wrong_names: [usize; 2],
    /// Claims that the second recording confirms, and all claims: by the rules, and by the posterior.
    pub confirmed: [[usize; 2]; 2],
}

impl Counts {
    /// Of some cases.
    pub fn of<'p>(pairs: impl Iterator<Item = &'p Pair>) -> Self {
        let mut out = Self::default();
        for pair in pairs {
            out.cases += 1;
            out.ideal += pair.ideal.seen;
            if pair.ideal.worth_a_name {
                let right = pair.right().map(usize::from);
                out.worth_a_name[0] += right[0];
                out.worth_a_name[1] += right[1];
                out.worth_a_name[2] += 1;
            }
            match pair.right() {
                [true, true] => out.both += 1,
                [true, false] => out.rules_only += 1,
                [false, true] => out.posterior_only += 1,
                [false, false] => {}
            }
            out.wrong_names[0] += usize::from(pair.rules.wrong_culprit());
            out.wrong_names[1] += usize::from(pair.posterior.wrong_culprit());
            for (k, judged) in [&pair.rules, &pair.posterior].into_iter().enumerate() {
                let holds = judged.claim.as_ref().and_then(Claim::holds);
                out.confirmed[k][0] += usize::from(holds == Some(true));
                out.confirmed[k][1] += usize::from(holds.is_some());
            }
        }
        out
    }
}

impl fmt::Display for Counts {
    fn fmt(&self, f: &mut fmt::Formatter) -> fmt::Result {
        let Self {
            cases,
            both,
            rules_only,
            posterior_only,
            ideal,
            worth_a_name: [rules_of_them, of_them, worth],
            wrong_names: [rules, posterior],
            confirmed: [[rules_hold, rules_claim], [hold, claim]],
        } = self;
        let neither = cases - both - rules_only - posterior_only;
        write!(
            f,
            "{cases} cases: right by both {both}, by the rules alone {rules_only}, by the posterior alone {posterior_only}, by neither \
             {neither}, by an ideal observer {ideal:.1}; of {worth} with effects worth a name {rules_of_them} and {of_them} right; wrong names by the rules {rules}, by the posterior {posterior}; claims confirmed {rules_hold} of {rules_claim} and \
             {hold} of {claim}"
        )
    }
}
