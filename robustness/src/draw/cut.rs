//! A piece of a recording.

use super::chance::chance;
use effects::random::{ChaCha8Rng, uniform};
use recording::{Recording, Samples};

/// A piece of it from anywhere to anywhere, or all of it.
pub fn cut(whole: &Recording, rng: &mut ChaCha8Rng) -> Recording {
    let length = whole.samples.len();
    let (mut first, mut end) = (0, length);
    if chance(rng, 0.5) {
        end = (length as f64 * uniform(rng, 0.1, 1.0)) as usize;
    }
    if chance(rng, 0.3) {
        first = (end as f64 * uniform(rng, 0.0, 0.7)) as usize;
    }
    let mut samples = Samples::default();
    (first..end.max(first + 1)).for_each(|i| samples.push(&whole.samples.row(i)));
    Recording {
        samples,
        ..whole.clone()
    }
}
