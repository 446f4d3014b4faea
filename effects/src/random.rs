//! Draws that every effect uses: one seeded generator, three distributions.

pub use rand_chacha::ChaCha8Rng;
pub use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal, StandardUniform};

/// Standard normal.
pub fn normal(rng: &mut ChaCha8Rng) -> f64 {
    StandardNormal.sample(rng)
}

/// Uniform in `low..high`.
pub fn uniform(rng: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    let unit: f64 = StandardUniform.sample(rng);
    low + (high - low) * unit
}

/// Log-uniform in `low..high`, both positive: a scale of which only the decade is known.
pub fn log_uniform(rng: &mut ChaCha8Rng, low: f64, high: f64) -> f64 {
    uniform(rng, low.ln(), high.ln()).exp()
}

/// One of `0..count`; `count` of zero gives zero.
pub fn index(rng: &mut ChaCha8Rng, count: usize) -> usize {
    (uniform(rng, 0.0, count as f64) as usize).min(count.saturating_sub(1))
}

/// Plus or minus one.
pub fn sign(rng: &mut ChaCha8Rng) -> f64 {
    if uniform(rng, 0.0, 1.0) < 0.5 {
        -1.0
    } else {
        1.0
    }
}

/// An independent generator, seeded from this one: an effect that draws while it runs owns one.
#[must_use]
pub fn fork(rng: &mut ChaCha8Rng) -> ChaCha8Rng {
    ChaCha8Rng::from_rng(rng)
}
