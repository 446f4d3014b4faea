//! What is asked of the posterior: columns with their priors, and the noise.

use super::reduced::Reduced;

/// What is asked: columns with their priors.
#[derive(Clone, Copy)]
pub struct Problem<'r> {
    /// Normal equations.
    pub reduced: &'r Reduced,
    /// Variance of the whitened residuals by the stated noise.
    pub stated: f64,
    /// Variance at which sets are fitted.
    pub noise: f64,
    /// Effects.
    pub effects: &'r [Prior],
    /// Blocks of shapes over a coordinate.
    pub coordinates: &'r [usize],
    /// Blocks, of effects and of shapes, of lines in the spectrum: the forms of other effects lack nothing of these.
    pub of_lines: &'r [usize],
    /// Blocks of effects that follow a course of their own, which no quantity of the recording foretells.
    pub of_own_course: &'r [usize],
    /// Blocks of effects that the counts show by themselves, whatever the rows say: another set predicts no such counts.
    pub in_the_counts: &'r [usize],
    /// Blocks of shapes over a quantity that takes the same values at other times: a logged column, the speed, the direction. An effect that
    /// follows a course of its own would do as they do by coincidence alone.
    pub recurring: &'r [usize],
    /// Probability, for each two blocks, that what the form of the first lacks lies along the columns of the second.
    pub along: &'r dyn Along,
    /// Logarithm of the prior odds of each coordinate, and of louder noise.
    pub log_odds: f64,
}

/// Probability that what the form of one block lacks lies along the columns of another.
pub trait Along: Sync {
    /// Of two blocks.
    fn along(&self, of: usize, by: usize) -> f64;
}

/// By the blocks' names.
impl Along for Vec<String> {
    fn along(&self, of: usize, by: usize) -> f64 {
        effects::lacks_along(&self[of], &self[by])
    }
}

/// Of blocks without names.
#[cfg(test)]
impl Along for f64 {
    fn along(&self, _: usize, _: usize) -> f64 {
        *self
    }
}

impl Problem<'_> {
    /// Share of an amplitude that the form of an effect may lack as lines in the spectrum, by the share of the amplitude that it may lack in all.
    pub fn in_lines(&self, block: usize, inexactness: f64) -> f64 {
        if self.of_lines.contains(&block) {
            inexactness
        } else {
            inexactness * effects::lacks_in_lines().sqrt()
        }
    }
}

#[cfg(test)]
impl<'r> Problem<'r> {
    /// Of unit noise, with effects and no coordinates.
    pub fn of_unit_noise(reduced: &'r Reduced, effects: &'r [Prior], log_odds: f64) -> Self {
        Self {
            reduced,
            stated: 1.0,
            noise: 1.0,
            effects,
            coordinates: &[],
            of_lines: &[],
            of_own_course: &[],
            in_the_counts: &[],
            recurring: &[],
            along: &0.01,
            log_odds,
        }
    }
}

/// An effect before the data.
#[derive(Clone, Copy, Debug)]
pub struct Prior {
    /// Its block.
    pub block: usize,
    /// Logarithm of its prior odds.
    pub log_odds: f64,
    /// Share of its amplitude that its form may lack.
    pub inexactness: f64,
    /// It describes a gap and is no cause of one.
    pub shape: bool,
    /// It is in the catalogue: what is not explains a gap, and is not named.
    pub listed: bool,
}

#[cfg(test)]
impl Prior {
    /// Of a cause of the catalogue with prior odds of `e^-2`, whose form may lack such a share of its amplitude.
    pub fn of_cause(block: usize, inexactness: f64) -> Self {
        Self {
            block,
            log_odds: -2.0,
            inexactness,
            shape: false,
            listed: true,
        }
    }
}
