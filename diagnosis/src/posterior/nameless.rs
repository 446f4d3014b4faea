//! Shapes over a coordinate that no effect of a set owns: what the set leaves, and where.

use super::eliminated::Eliminated;
use super::evidence::{Fitted, fitted, gain, given};
use super::noise_scale::Left;
use super::problem::Problem;
use nalgebra::DVector;

/// Coordinates that may hold something at once: one that is the cause's, and two that it shows in besides. A bound on the work:
/// what a fourth would show is left to the noise's scale.
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

impl Nameless {
    /// Whitened squares over the noise that lines in the spectrum do among them, and not more than all explain.
    pub fn of_lines(&self, problem: &Problem) -> f64 {
        let each = self.coordinates.iter().zip(&self.powers);
        let lines = each.filter(|(c, _)| problem.of_lines.contains(&problem.coordinates[**c]));
        lines
            .map(|(_, power)| power)
            .sum::<f64>()
            .min(self.explained)
    }
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
    let reduced = problem.reduced;
    let eliminated = Eliminated::new(reduced, &set.set, &set.log_variances, noise)?;
    let left = |blocks: &[usize]| reduced.beside(&set.set, &eliminated, blocks, noise);
    // Most sets leave nothing that any one of them describes: then their products with each other are not asked for.
    let describes = |c: &usize| {
        let alone = gain(&left(&[*c]), &[], &[], 0, noise);
        alone.is_some_and(|(gain, _)| gain + log_odds > 0.0)
    };
    if !coordinates.iter().any(describes) {
        return None;
    }
    let without = left(coordinates);
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
    let blocks: Vec<usize> = f.set.iter().map(|c| coordinates[*c]).collect();
    let together = given(
        problem.reduced,
        &[&set.set[..], &blocks].concat(),
        &[&set.log_variances[..], &f.log_variances].concat(),
        noise,
    )?;
    let (list, amounts) = changed(problem, set, &eliminated, &f, &blocks);
    let (times, of_set) = (noise / stated, reduced.columns(&set.set));
    let mut whole = amounts.clone();
    let mut own = whole.rows_mut(0, of_set.len());
    own += &set.given.coefficients;
    let rebuilt = reduced.log_rebuilt(&list, &whole, times, noise)
        - reduced.log_rebuilt(&of_set, &set.given.coefficients, times, noise);
    Some(Nameless {
        powers: super::least_size::powers(&without, &f, noise),
        explained: (set.given.squares - together.squares) / noise,
        log_prior: log_odds * f.set.len() as f64,
        left: Left {
            log_density: alone.log_density + gain + rebuilt,
            // Of the fit of both: the shapes relieve the set's amounts as well, which what they take off the eliminated equations holds.
            squares: together.squares / stated,
            degrees: alone.degrees + set.given.told - together.told,
            allowance: alone.allowance + reduced.allowance(&list, &amounts) / stated,
            ..*alone
        }
        .no_less_than_noise(),
        coordinates: f.set,
    })
}

/// Columns of a set and of shapes beside it, with what the shapes change of their amounts: those of what the set gives way by as well.
fn changed(
    problem: &Problem,
    set: &Fitted,
    eliminated: &Eliminated,
    shapes: &Fitted,
    blocks: &[usize],
) -> (Vec<usize>, DVector<f64>) {
    let Problem { reduced, noise, .. } = *problem;
    let (of_set, of_shapes) = (reduced.columns(&set.set), reduced.columns(blocks));
    let amounts = &shapes.given.coefficients;
    let across = reduced.across(&of_set, &of_shapes) * amounts / noise;
    let gives_way = eliminated.solve(&across);
    let change: Vec<f64> = gives_way
        .iter()
        .map(|g| -g)
        .chain(amounts.iter().copied())
        .collect();
    ([of_set, of_shapes].concat(), DVector::from_vec(change))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic_problem::SyntheticProblem;
    use effects::random::normal;

    /// A set at sixty times the size that it is given, and shapes that can do the same: they relieve it of that, and both leave the noise.
    #[test]
    fn what_shapes_leave_is_no_less_than_the_noise() {
        let blocks = [("set", &[1.0][..]), ("shapes", &[1.0, 1.0])];
        let problem = SyntheticProblem::new(&blocks, &|rng| {
            let (one, other, noise) = (normal(rng), normal(rng), normal(rng));
            let set = one + 0.3 * other;
            vec![1.0, set, one, other, 30.0 * set + noise]
        });
        let reduced = problem.reduced(&[1, 2]);
        let strained = fitted_at(&reduced, &[2.0 * 0.5_f64.ln()]);
        let alone = Left::of(&reduced, &strained, 1.0, 1.0);
        let problem = Problem {
            coordinates: &[1],
            ..Problem::of_unit_noise(&reduced, &[], -3.0)
        };
        let found = beside(&problem, &strained, &alone).unwrap();
        assert_eq!(found.coordinates, [0]);
        assert!(found.left.squares > 0.9 * reduced.rows, "{found:?}");
        assert!(found.left.squares <= alone.squares, "{found:?} {alone:?}");
    }

    fn fitted_at(reduced: &crate::posterior::reduced::Reduced, log_variances: &[f64]) -> Fitted {
        Fitted {
            set: vec![0],
            log_variances: log_variances.to_vec(),
            given: given(reduced, &[0], log_variances, 1.0).unwrap(),
            log_widths: 0.0,
            allowance: 0.0,
        }
    }
}
