//! What would do in the place of a named effect.

/// Odds of an effect's rivals against it, by the rules of `selection`: each is what would do in the effect's place.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Rivals {
    /// Of those that are told as its aliases, together.
    pub aliases: f64,
    /// Of all others of the catalogue, together.
    pub others: f64,
    /// Of what is in no catalogue and predicts the same: such as an error of the reference.
    pub unlisted: f64,
}

impl Rivals {
    /// The effect's own weight among all of them.
    #[must_use]
    pub fn own_weight(&self) -> f64 {
        1.0 / (1.0 + self.aliases + self.others + self.unlisted)
    }
}
