//! Shapes over a coordinate that no effect of a set owns: what the set leaves, and where.

use super::evidence::{Fitted, fitted, gain, given};
use super::noise_scale::Left;
use super::problem::Problem;

/// Coordinates that may hold something at once: one that is the cause's, and two that it shows in besides. A bound on the work.
const MOST: usize = 3;

/// The best shapes beside a set.
#[derive(Clone, Debug)]
pub struct Nameless {
    /// Coordinates, by their place in the list that was asked for.
    pub coordinates: Vec<usize>,
    /// Whitened squares over the noise that each does. Among themselves they may cancel.
    pub powers: Vec<f64>,
    /// Whitened squares over the noise that they explain together of what the set leaves.
    pub explained: f64,
    /// What the set leaves with them.
    pub left: Left,
    /// Logarithm of their prior odds.
    pub log_prior: f64,
}

/// Adds coordinate after coordinate to a set as long as the logarithm of the posterior rises by each; none where none does. `alone` is what
/// the set leaves without.
pub fn beside(problem: &Problem, set: &Fitted, alone: &Left) -> Option<Nameless> {
    let Problem {
        coordinates,
        noise,
        stated,
        log_odds,
        ..
    } = *problem;
    let without = problem
        .reduced
        .beside(&set.set, &set.log_variances, coordinates, noise)?;
    let nothing = given(&without, &[], &[], noise)?.log_density;
    let whole = |f: &Fitted| f.given.log_density + f.log_widths - nothing;
    let mut best: Option<Fitted> = None;
    while best.as_ref().map_or(0, |f| f.set.len()) < MOST {
        let (chosen, sizes, before) = match &best {
            Some(f) => (f.set.clone(), f.log_variances.clone(), whole(f)),
            None => (Vec::new(), Vec::new(), 0.0),
        };
        let more = (0..coordinates.len()).filter(|c| !chosen.contains(c));
        let with = more.filter_map(|c| {
            let (gain, size) = gain(&without, &chosen, &sizes, c, noise)?;
            Some((gain, size, c))
        });
        let Some((gain, size, c)) = with.max_by(|a, b| a.0.total_cmp(&b.0)) else {
            break;
        };
        if gain + log_odds <= 0.0 {
            break;
        }
        let start = [&sizes[..], &[size]].concat();
        let next = fitted(&without, &[&chosen[..], &[c]].concat(), &start, noise)?;
        if whole(&next) + log_odds <= before {
            break;
        }
        best = Some(next);
    }
    let f = best?;
    let gain = whole(&f);
    Some(Nameless {
        powers: super::least_size::powers(&without, &f, noise),
        explained: (without.squares - f.given.squares) / noise,
        log_prior: log_odds * f.set.len() as f64,
        left: Left {
            log_density: alone.log_density + gain,
            squares: (alone.squares - (without.squares - f.given.squares) / stated).max(0.0),
            degrees: alone.degrees - f.given.told,
            allowance: alone.allowance + f.allowance / stated,
            ..*alone
        },
        coordinates: f.set,
    })
}
