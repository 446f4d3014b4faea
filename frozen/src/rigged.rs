//! A specimen of the independent simulator with all channels, before anything is left out of it.

use crate::specimen::Rigged;
use specimens::Drawn;

/// Samples asked of the small ones.
pub(crate) const SMALL: usize = 600;

/// One with all channels and no reference.
pub(crate) fn rigged(seed: u64, effects: &[(&str, f64)], samples: usize) -> Rigged {
    let drawn = |(name, size_m): &(&str, f64)| Drawn {
        name: (*name).into(),
        size_m: *size_m,
    };
    Rigged {
        seed,
        effects: effects.iter().map(drawn).collect(),
        samples,
        beacon: true,
        counts: true,
        reference: false,
        segments: 4,
    }
}
