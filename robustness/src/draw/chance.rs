//! A choice by chance.

use effects::random::{ChaCha8Rng, uniform};

/// True with this probability.
pub fn chance(rng: &mut ChaCha8Rng, probability: f64) -> bool {
    uniform(rng, 0.0, 1.0) < probability
}
