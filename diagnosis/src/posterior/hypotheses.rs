//! What sets say of a gap, each under the four hypotheses about what it leaves: and which of them is told.

use super::alias::{class, is_no_trifle, limit};
use super::least_size::least_squares;
use super::noise_scale::NoiseScale;
use super::problem::Problem;
use super::telling::{Found, Places, Telling, without_trifling_shapes};
use super::weighed::Weighed;
use std::collections::BTreeSet;

/// Noise that is louder than stated by less than this in rms is no gap.
const VISIBLE: f64 = crate::figures::limits::VISIBLE_GAP_RATIO;

/// A set of effects does not explain a gap of which shapes hold more than this share. By definition.
const UNEXPLAINED_SHARE: f64 = crate::figures::limits::UNEXPLAINED_SHARE;

/// What a hypothesis says of the gap.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Says {
    /// Nothing that is worth a name.
    NoGap,
    /// Effects, or louder noise, that leave little.
    Named,
    /// A gap that no set explains.
    Unknown,
}

/// A set under one of the four hypotheses about what it leaves.
pub struct Hypothesis {
    /// Place among the sets.
    pub set: usize,
    /// Logarithm of its weight.
    pub log_weight: f64,
    /// What it says.
    pub says: Says,
    /// White noise above the stated one is part of it.
    pub noise: bool,
    /// Whitened squares that nothing named explains.
    pub left: f64,
}

/// All sets under all hypotheses.
pub fn hypotheses(problem: &Problem, all: &[Weighed], noise_is_white: bool) -> Vec<Hypothesis> {
    let places = Places::of(all);
    let weights = all.iter().map(|w| w.log_weight(problem.log_odds));
    let least_weight = weights.fold(f64::NEG_INFINITY, f64::max) + LOG_WEIGHT_THAT_COUNTS;
    let mut out = Vec::new();
    for (k, weighed) in all.iter().enumerate() {
        let shapes = weighed.nameless.as_ref().map(|(_, noise)| *noise);
        let whole = Telling {
            set: without_trifling_shapes(problem, all, &places, k),
            log_change: 0.0,
            trifles: 0.0,
            lacking: weighed.lacking,
            lacking_of_lines: weighed.lacking_of_lines,
        };
        let noises = (weighed.noise, shapes);
        out.extend(forms(problem, all, k, &whole, noises, noise_is_white));
        let weight = weighed.log_weight(problem.log_odds);
        // The set without a part is weighed by itself as well: only where the whole one counts is it asked which of the two is told, since what changes
        // that never makes it likelier. That of nothing is always asked for.
        let found = Found::of(problem, all, &places, k);
        let parts = (weight > least_weight).then(|| {
            let counts = |told: &Telling| weight + told.log_change.min(0.0) > least_weight;
            let each = found.without_a_trifle();
            each.chain(found.without_what_forms_lack()).filter(counts)
        });
        let counts = |told: &Telling| weight + told.log_change > least_weight;
        let nothing = found.nothing().filter(counts);
        for told in parts.into_iter().flatten().chain(nothing) {
            let noises = weighed.noise_if_lacking(problem, told.lacking);
            out.extend(forms(problem, all, k, &told, noises, noise_is_white));
        }
    }
    out
}

/// What is told of a set, by the noise without nameless shapes and with them, under the four hypotheses about what it leaves.
fn forms(
    problem: &Problem,
    all: &[Weighed],
    of: usize,
    told: &Telling,
    (alone, with_shapes): (NoiseScale, Option<NoiseScale>),
    noise_is_white: bool,
) -> [Hypothesis; 4] {
    let weighed = &all[of];
    let least = least_squares(problem.reduced.rows);
    let shapes = weighed.nameless.as_ref().map(|(shapes, _)| shapes);
    let in_shapes: f64 = shapes.map_or(0.0, |shapes| shapes.explained);
    let lines = shapes.map_or(0.0, |shapes| shapes.of_lines(problem));
    let closed = weighed.weight(&alone, 0.0, problem.log_odds);
    let open = shapes
        .zip(with_shapes)
        .map_or([f64::NEG_INFINITY; 2], |(shapes, noise)| {
            weighed.weight(&noise, shapes.log_prior, problem.log_odds)
        });
    let each = [
        (closed[0], 0.0, None),
        (closed[1], 0.0, Some(alone)),
        (open[0], in_shapes, None),
        (open[1], in_shapes, Some(with_shapes.unwrap_or(alone))),
    ];
    each.map(|(log_weight, shaped, louder)| {
        let excess = louder.map_or(0.0, |noise| noise.log_variance.exp_m1().max(0.0));
        let visible = excess > VISIBLE * VISIBLE - 1.0;
        let unlocated = if visible {
            excess * weighed.left.degrees * (-weighed.left.log_noise).exp()
        } else {
            0.0
        };
        // What the effects' forms may lack is no noise, however white it looks.
        let may_lack = least + told.lacking;
        let noise = noise_is_white && unlocated > may_lack;
        let left = told.trifles + shaped + if noise { 0.0 } else { unlocated };
        let of_lines = if shaped > 0.0 { lines } else { 0.0 };
        let trifle = left <= may_lack && of_lines < least + told.lacking_of_lines;
        let set = &all[told.set];
        // Of nothing, and of louder noise alone, no share is asked.
        let most = told.lacking + UNEXPLAINED_SHARE * (set.explained + shaped);
        let explains = set.set().is_empty() || shaped <= most;
        let says = match (set.set().is_empty(), noise) {
            _ if !set.listed || !trifle || !explains => Says::Unknown,
            (true, false) => Says::NoGap,
            _ => Says::Named,
        };
        Hypothesis {
            set: told.set,
            log_weight: log_weight + told.log_change,
            says,
            noise,
            left,
        }
    })
}

/// What a set with nameless shapes predicts a set of causes may predict as well: then it is these that the hypothesis tells of. Such causes leave
/// what the other set leaves, as far as noise and their own inexactness go (9), none is a trifle. What their freedom costs them is not asked:
/// shapes that are likelier than the causes at the amounts that fit best are more than a description, and stay. Lines give way to a cause that makes
/// lines. Whatever the coordinates that it shows in, what has no name is one cause, and one stands in for it. A cause that is in no catalogue is no shape
/// and gives way to none. Nor do shapes over a quantity that recurs give way to an effect that follows a course of its own: it may follow any.
pub fn give_way_to_causes(problem: &Problem, all: &[Weighed], hypotheses: &mut [Hypothesis]) {
    let rows = problem.reduced.rows - problem.reduced.baseline as f64;
    let causes: Vec<(usize, f64)> = hypotheses
        .iter()
        .filter(|h| h.says == Says::Named && !h.noise && h.left == 0.0)
        .filter(|h| !all[h.set].set().is_empty() && is_no_trifle(&all[h.set]))
        .map(|h| (h.set, h.log_weight))
        .collect();
    for h in hypotheses.iter_mut().filter(|h| h.says == Says::Unknown) {
        let own = &all[h.set];
        let Some((shapes, _)) = own.nameless.as_ref().filter(|_| own.listed) else {
            continue;
        };
        let (left, lines) = (&shapes.left, shapes.of_lines(problem));
        let told = rows - left.degrees;
        let mut coordinates = shapes.coordinates.iter();
        let over_what_recurs =
            coordinates.any(|c| problem.recurring.contains(&problem.coordinates[*c]));
        let follows_anything = |e: &usize| over_what_recurs && problem.of_own_course.contains(e);
        let predicts_the_same = |k: usize| {
            let other = &all[k];
            let more = (other.left.squares - left.squares) * (-own.left.log_noise).exp();
            let has_more = |e: &usize| problem.of_lines.contains(e) && !own.set().contains(e);
            let lines_are_told =
                other.set().iter().any(has_more) || lines <= limit(told) + other.lacking_of_lines;
            other.set().len() <= own.set().len() + 1
                && !other.set().iter().any(follows_anything)
                && other.left.log_noise == own.left.log_noise
                && lines_are_told
                && more <= limit(told) + other.lacking
        };
        let is_refuted = |k: usize, log_weight: f64| {
            let freedom = all[k].log_freedom(problem);
            freedom.is_none_or(|f| log_weight - all[k].log_prior + f < h.log_weight)
        };
        let same = causes
            .iter()
            .filter(|(k, log_weight)| predicts_the_same(*k) && !is_refuted(*k, *log_weight));
        if let Some((k, _)) = same.max_by(|a, b| a.1.total_cmp(&b.1)) {
            (h.set, h.says, h.left) = (*k, Says::Named, 0.0);
        }
    }
}

/// Sets of less than this share of the likeliest's weight are left as they are. Derived from the number of sets, some two thousand: all of them
/// together change no probability by a hundredth (2000 e^-12.5 is 0.007).
pub(super) const LOG_WEIGHT_THAT_COUNTS: f64 = -12.5;

/// An effect that follows a course of its own predicts whatever a quantity that the recording has foretells, and would do so by coincidence
/// alone: where a set without it, of no more effects, predicts the same (9), it is this one that its hypothesis tells of.
pub fn own_courses_give_way(problem: &Problem, all: &[Weighed], hypotheses: &mut [Hypothesis]) {
    if problem.of_own_course.is_empty() {
        return;
    }
    let own = |k: usize| {
        let each = all[k].set().iter();
        each.filter(|b| problem.of_own_course.contains(b)).count()
    };
    let named = |h: &&Hypothesis| h.says == Says::Named && !h.noise;
    let weights = hypotheses.iter().map(|h| h.log_weight);
    let least = weights.fold(f64::NEG_INFINITY, f64::max) + LOG_WEIGHT_THAT_COUNTS;
    let told: BTreeSet<usize> = hypotheses.iter().filter(named).map(|h| h.set).collect();
    let counts = hypotheses.iter().filter(named);
    let asked: BTreeSet<usize> = counts
        .filter(|h| h.log_weight > least && own(h.set) > 0)
        .map(|h| h.set)
        .collect();
    for of in asked {
        let rivals = class(problem, all, of).into_iter().map(|(k, _)| k);
        let foretold = rivals.filter(|k| own(*k) < own(of) && told.contains(k));
        // Sets are ordered by weight.
        if let Some(k) = foretold.min() {
            let same = hypotheses.iter_mut().filter(|h| h.set == of);
            same.for_each(|h| h.set = k);
        }
    }
}
