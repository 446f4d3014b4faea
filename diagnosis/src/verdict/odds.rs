//! What the probability of a named effect is made of.

/// Odds of a named effect.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Odds {
    /// Logarithm of the posterior's odds that it acts, or one of those that it stands for, in a set that explains the gap.
    pub ln_posterior: f64,
    /// Odds against it of what is in no catalogue and predicts the same: such as an error of the reference.
    pub unlisted: f64,
}

impl Odds {
    /// The effect's own weight among all that would do in its place.
    #[must_use]
    pub fn weight(&self) -> f64 {
        1.0 / (1.0 + (-self.ln_posterior).exp() + self.unlisted)
    }
}
