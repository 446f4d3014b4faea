//! A set of effects with its weight under four hypotheses: with nameless shapes or without, by noise near the stated one or louder.

use super::discrepancy;
use super::evidence::{Fitted, gain, given};
use super::least_size::{Share, lacking, least_squares, powers, shares};
use super::nameless::{Nameless, beside};
use super::noise_scale::{Left, NoiseScale, integrate, log_sum};
use super::problem::Problem;

/// The two kinds of noise.
#[derive(Clone, Copy)]
pub enum Noise {
    /// Near the stated one.
    Stated,
    /// Louder by any factor.
    Louder,
}

/// A set with its weight.
#[derive(Clone, Debug)]
pub struct Weighed {
    /// The fit.
    pub fitted: Fitted,
    /// All its effects are in the catalogue.
    pub listed: bool,
    /// What each effect does, in whitened squares over the noise at which it was fitted.
    pub powers: Vec<f64>,
    /// What each does that the others cannot; nothing where that cannot be told.
    pub shares: Vec<Share>,
    /// Whitened squares that the effects' own forms may lack.
    pub lacking: f64,
    /// Those of them that may be lines in the spectrum.
    pub lacking_of_lines: f64,
    /// Squares of lines in the spectrum that stand in what it leaves; 0 where none do, or none were looked for.
    pub lines: f64,
    /// What the set leaves.
    pub left: Left,
    /// Whitened squares, over the noise at which it was fitted, that it takes off what the baseline leaves.
    pub explained: f64,
    /// What cutting off trifles adds.
    pub log_least: f64,
    /// Logarithm of the prior odds of its effects.
    pub log_prior: f64,
    /// The noise.
    pub noise: NoiseScale,
    /// Nameless shapes beside it, and the noise with them.
    pub nameless: Option<(Nameless, NoiseScale)>,
}

impl Weighed {
    /// Blocks of the set.
    pub fn set(&self) -> &[usize] {
        &self.fitted.set
    }

    /// Logarithm of its weight without nameless shapes, by noise near the stated one and by louder noise.
    pub fn closed(&self, log_odds: f64) -> [f64; 2] {
        self.weight(&self.noise, 0.0, log_odds)
    }

    /// The same with nameless shapes.
    pub fn open(&self, log_odds: f64) -> [f64; 2] {
        match &self.nameless {
            Some((shapes, noise)) => self.weight(noise, shapes.log_prior, log_odds),
            None => [f64::NEG_INFINITY; 2],
        }
    }

    /// Logarithm of its weight under some noise, with prior odds that are not its effects' own.
    pub fn weight(&self, noise: &NoiseScale, log_prior: f64, log_odds: f64) -> [f64; 2] {
        let common = self.log_least + self.log_prior + log_prior;
        [common + noise.stated, common + noise.louder + log_odds]
    }

    /// The noise without nameless shapes and with them, if the effects' forms may lack so many squares.
    pub fn noise_if_lacking(
        &self,
        problem: &Problem,
        lacking: f64,
    ) -> (NoiseScale, Option<NoiseScale>) {
        let of = |left: &Left, lines: f64, kept: &NoiseScale| {
            let noise = discrepancy::noise(left, lacking, lines, problem.reduced.rows);
            noise.only_as(kept)
        };
        let with_shapes = self.nameless.as_ref();
        let with_shapes = with_shapes
            .map(|(shapes, kept)| of(&shapes.left, self.lines_beside(shapes, problem), kept));
        (of(&self.left, self.lines, &self.noise), with_shapes)
    }

    /// Squares of lines that it leaves beside some shapes.
    fn lines_beside(&self, shapes: &Nameless, problem: &Problem) -> f64 {
        if shapes.of_lines(problem) > 0.0 {
            0.0
        } else {
            self.lines
        }
    }

    /// Finds the best nameless shapes beside it.
    pub fn look_for_shapes(&mut self, problem: &Problem) {
        let shapes = beside(problem, &self.fitted, &self.left);
        self.nameless = shapes.map(|shapes| {
            let lines = self.lines_beside(&shapes, problem);
            let noise = discrepancy::noise(&shapes.left, self.lacking, lines, problem.reduced.rows);
            (shapes, noise)
        });
    }

    /// Finds the lines that stand in what it leaves: its effects' forms lack nothing of them.
    pub fn look_for_lines(&mut self, problem: &Problem) {
        let Fitted {
            set, log_variances, ..
        } = &self.fitted;
        let others = problem.of_lines.iter().filter(|b| !set.contains(b));
        let gains =
            others.filter_map(|b| gain(problem.reduced, set, log_variances, *b, problem.noise));
        let most = gains.map(|(gain, _)| gain).fold(0.0, f64::max);
        let squares = 2.0 * most;
        if squares > least_squares(problem.reduced.rows) {
            self.lines = squares;
            let others = (squares - self.lacking_of_lines).max(0.0);
            self.noise = discrepancy::noise(&self.left, self.lacking, others, problem.reduced.rows);
        }
    }

    /// Leaves it the weight by one of the two kinds of noise.
    pub fn keep(&mut self, noise: Noise) {
        let with_shapes = self.nameless.iter_mut().map(|n| &mut n.1);
        for scale in with_shapes.chain([&mut self.noise]) {
            match noise {
                Noise::Stated => scale.louder = f64::NEG_INFINITY,
                Noise::Louder => scale.stated = f64::NEG_INFINITY,
            }
        }
    }

    /// Logarithm of its whole weight if the forms of its effects lack nothing: what they leave is shapes without a name or noise.
    pub fn log_weight_of_forms(&self, log_odds: f64) -> f64 {
        let of = |left: &Left, kept: &NoiseScale, log_prior: f64| {
            self.weight(&integrate(left, 0.0).only_as(kept), log_prior, log_odds)
        };
        let alone = of(&self.left, &self.noise, 0.0);
        let with_shapes = self.nameless.iter();
        let with_shapes = with_shapes.flat_map(|(s, kept)| of(&s.left, kept, s.log_prior));
        log_sum(alone.into_iter().chain(with_shapes))
    }

    /// Logarithm of what its freedom costs it: how much likelier the data are at the amounts that fit best than in the mean over all amounts and
    /// sizes before the data. None where the baseline's equations cannot be solved.
    pub fn log_freedom(&self, problem: &Problem) -> Option<f64> {
        let noise = problem.stated * self.left.log_noise.exp();
        let nothing = given(problem.reduced, &[], &[], noise)?.log_density;
        let at_best = nothing + 0.5 * self.explained;
        Some(at_best - self.fitted.given.log_density - self.fitted.log_widths)
    }

    /// Logarithm of its whole weight.
    pub fn log_weight(&self, log_odds: f64) -> f64 {
        log_sum(self.closed(log_odds).into_iter().chain(self.open(log_odds)))
    }
}

/// Sorts, the likeliest first.
pub fn sort(all: &mut [Weighed], log_odds: f64) {
    all.sort_by(|a, b| b.log_weight(log_odds).total_cmp(&a.log_weight(log_odds)));
}

/// A set's weight from its fit.
pub fn weighed(problem: &Problem, fitted: Fitted) -> Weighed {
    let Problem { reduced, noise, .. } = *problem;
    let of = |b: &usize| problem.effects.iter().find(|e| e.block == *b);
    let priors = || fitted.set.iter().filter_map(of);
    let powers = powers(reduced, &fitted, noise);
    let inexactness = priors().map(|e| e.inexactness);
    let each: Vec<(f64, f64)> = powers.iter().copied().zip(inexactness).collect();
    let explained = (reduced.squares - fitted.given.squares) / noise;
    let in_lines = each.iter().zip(&fitted.set);
    let in_lines = in_lines.map(|((power, share), b)| (*power, problem.in_lines(*b, *share)));
    let lacking_of_lines = lacking(explained, in_lines);
    let lacking = lacking(explained, each.iter().copied());
    let left = Left::of(reduced, &fitted, noise, problem.stated);
    let shares = shares(problem, &fitted, explained, &each);
    let log_least = |all: &Vec<Share>| all.iter().map(|share| share.log_least).sum();
    Weighed {
        listed: priors().all(|e| e.listed),
        log_least: shares.as_ref().map_or(f64::NEG_INFINITY, log_least),
        shares: shares.unwrap_or_default(),
        log_prior: priors().map(|e| e.log_odds).sum(),
        noise: discrepancy::noise(&left, lacking, 0.0, reduced.rows),
        nameless: None,
        lines: 0.0,
        explained,
        fitted,
        powers,
        lacking,
        lacking_of_lines,
        left,
    }
}
