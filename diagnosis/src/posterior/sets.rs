//! All sets of up to four effects, as far as they may matter, by noise near the stated one or louder.

use super::noise_scale::STATED_TO;
use super::problem::Problem;
use super::walk::{among_these, likeliest, walk};
use super::weighed::{Noise, Weighed, sort};

/// Times that louder noise is found anew, by few sets and by all: from what the baseline leaves, each time from what the best set
/// then leaves, which is less, until it stays. Where it has not stayed by then, it is still above the noise. A bound on the work:
/// a noise that is found too large names less, and not more.
const NOISE_ROUNDS: usize = 5;

/// Weighs the sets, the likeliest first. Noise that is louder than stated has sets of its own, fitted at that noise: sizes that are found
/// at less than the true noise follow it, and columns carry as much more of it as it is louder. It is shared by all sets, since each set's
/// own would be paid for by the effects that lower it. It is come to from above: at less than the true noise, what columns and target have
/// in common is taken for an effect. The way there takes only the sets that are the likeliest by the stated noise.
pub fn weigh(problem: &Problem) -> Vec<Weighed> {
    let mut all = walk(problem);
    let Some(found) = louder_noise(&all, problem.log_odds) else {
        return all;
    };
    let of_nothing = all.iter().find(|w| w.set().is_empty());
    let mut at = of_nothing.map_or(found, |w| w.noise.log_variance.max(found));
    let likeliest = likeliest(problem, &all);
    for _ in 0..NOISE_ROUNDS {
        let few = at_noise(problem, at, |problem| among_these(problem, &likeliest));
        let Some(next) = lower(&few, problem.log_odds, at) else {
            break;
        };
        at = next;
    }
    let mut louder = at_noise(problem, at, walk);
    for _ in 1..NOISE_ROUNDS {
        let Some(next) = lower(&louder, problem.log_odds, at) else {
            break;
        };
        at = next;
        louder = at_noise(problem, at, walk);
    }
    all.iter_mut().for_each(|w| w.keep(Noise::Stated));
    louder.iter_mut().for_each(|w| w.keep(Noise::Louder));
    all.extend(louder);
    sort(&mut all, problem.log_odds);
    all
}

/// Weighs sets at louder noise, told by the logarithm of its variance over the stated one.
fn at_noise(
    problem: &Problem,
    log_noise: f64,
    weigh: impl Fn(&Problem) -> Vec<Weighed>,
) -> Vec<Weighed> {
    let times = log_noise.exp();
    let reduced = problem.reduced.at_noise(times);
    weigh(&Problem {
        reduced: &reduced,
        noise: problem.stated * times,
        ..*problem
    })
}

/// The noise that sets which were weighed at some noise ask for, where that is less by more than the stated noise is known to.
fn lower(weighed: &[Weighed], log_odds: f64, at: f64) -> Option<f64> {
    louder_noise(weighed, log_odds).filter(|next| at - next >= STATED_TO)
}

/// Logarithm of the likeliest variance of the noise over the stated one, where louder noise is likelier than the stated one.
fn louder_noise(all: &[Weighed], log_odds: f64) -> Option<f64> {
    let best = |which: usize| {
        let weight = |w: &Weighed| w.closed(log_odds)[which].max(w.open(log_odds)[which]);
        all.iter()
            .map(|w| (weight(w), w))
            .max_by(|a, b| a.0.total_cmp(&b.0))
    };
    let ((stated, _), (louder, w)) = (best(0)?, best(1)?);
    let own = w.noise.log_variance;
    let with_shapes = w.nameless.as_ref().map(|(_, noise)| noise.log_variance);
    let [closed, open] = [w.closed(log_odds)[1], w.open(log_odds)[1]];
    let at = if open > closed { with_shapes? } else { own };
    (louder > stated && at > 0.0).then_some(at)
}
