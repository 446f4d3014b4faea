//! All sets of up to four effects, as far as they may matter, by noise near the stated one or louder.

use super::noise_scale::STATED_TO;
use super::problem::Problem;
use super::walk::walk;
use super::weighed::{Noise, Weighed, sort};

/// Times that the louder noise is found: it follows from the squares that the best set leaves, of which the set's own choice is a small
/// part, so that it stays from the second time on.
const NOISE_ROUNDS: usize = 3;

/// Weighs the sets, the likeliest first. Noise that is louder than stated has sets of its own, fitted at that noise: sizes that are found
/// at less than the true noise follow it. It is shared by all sets, since each set's own would be paid for by the effects that lower it.
pub fn weigh(problem: &Problem) -> Vec<Weighed> {
    let mut stated = walk(problem);
    let mut louder: Option<(f64, Vec<Weighed>)> = None;
    for _ in 0..NOISE_ROUNDS {
        let (at, latest) = louder
            .as_ref()
            .map_or((0.0, &stated), |(at, all)| (*at, all));
        let Some(next) = louder_noise(latest, problem.log_odds) else {
            break;
        };
        if (next - at).abs() < STATED_TO {
            break;
        }
        let noise = problem.stated * next.exp();
        louder = Some((next, walk(&Problem { noise, ..*problem })));
    }
    if let Some((_, louder)) = louder {
        stated.iter_mut().for_each(|w| w.keep(Noise::Stated));
        stated.extend(louder.into_iter().map(|mut w| {
            w.keep(Noise::Louder);
            w
        }));
        sort(&mut stated, problem.log_odds);
    }
    stated
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
