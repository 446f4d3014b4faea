//! What the starts have in common by which whole teeth are tried.

use courier_sensor::frame::Coordinate;
use rand_chacha::ChaCha8Rng;
use rand_distr::{Distribution, StandardNormal};

/// Starts of each kind. By definition of what is asked for: right teeth in so many.
pub const TRIES: usize = 10_000;
/// The platen's tooth pitch, metres (the paper, 3.1).
pub const PITCH_M: f64 = 1.016e-3;

/// A normal deviate of this standard deviation.
pub fn normal(rng: &mut ChaCha8Rng, sd: f64) -> f64 {
    let value: f64 = StandardNormal.sample(rng);
    sd * value
}

/// Of a place in teeth.
pub fn coordinate(teeth: f64) -> Coordinate {
    Coordinate {
        teeth: teeth.round() as i32,
        fraction_turns: (teeth - teeth.round()) as f32,
    }
}
