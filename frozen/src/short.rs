//! Specimens that are answered in about half a second: every effect in every layout of channels, several couriers each, and pairs.
//!
//! A whole survey shows more of an effect. What a change of the code alters shows in short ones as well, and there are enough of them
//! to meet most of its ways.

use crate::rigged::{SMALL, rigged};
use crate::specimen::Rigged;
use specimens::SIZES_M;
use specimens::rig::{CATALOGUE, Dice, LATER, UNLISTED};

/// Channels that are recorded.
#[derive(Clone, Copy)]
struct Layout {
    segments: usize,
    counts: bool,
    reference: bool,
    beacon: bool,
    /// Couriers with each effect, and without any.
    couriers: usize,
}

/// Every layout, with fewer couriers where an answer takes longer.
const LAYOUTS: [Layout; 7] = [
    layout(1, true, true, false, 6),
    layout(1, false, true, false, 4),
    layout(2, true, true, false, 3),
    layout(2, false, true, false, 2),
    layout(4, true, false, false, 3),
    layout(4, false, false, false, 2),
    layout(4, true, false, true, 2),
];
/// Couriers with two effects, the layouts in turn.
const PAIRS: usize = 160;
/// Seed of the first. Each specimen has a seed of its own.
const FIRST_SEED: u64 = 10_000;
/// Sizes are stated in whole hundredths of a micrometre.
const SIZES_A_METRE: f64 = 1.0e8;

const fn layout(
    segments: usize,
    counts: bool,
    reference: bool,
    beacon: bool,
    couriers: usize,
) -> Layout {
    Layout {
        segments,
        counts,
        reference,
        beacon,
        couriers,
    }
}

/// All of them: alone by layout, courier and effect, then the pairs.
pub fn specimens() -> impl Iterator<Item = Rigged> {
    let mut dice = Dice(FIRST_SEED);
    let mut size_m = move || {
        let drawn = SIZES_M[0] * (SIZES_M[1] / SIZES_M[0]).powf(dice.unit());
        (drawn * SIZES_A_METRE).round() / SIZES_A_METRE
    };
    let mut drawn: Vec<(Layout, Vec<(&str, f64)>)> = Vec::new();
    for layout in LAYOUTS {
        for _ in 0..layout.couriers {
            drawn.push((layout, Vec::new()));
            for name in CATALOGUE.into_iter().chain(LATER).chain(UNLISTED) {
                drawn.push((layout, vec![(name, size_m())]));
            }
        }
    }
    let known: Vec<&str> = CATALOGUE.into_iter().chain(LATER).collect();
    for k in 0..PAIRS {
        // Each effect with each other one, farther apart at each turn.
        let (first, apart) = (k % known.len(), 1 + k / known.len());
        let names = [known[first], known[(first + apart) % known.len()]];
        let pair = names.map(|name| (name, size_m()));
        drawn.push((LAYOUTS[k % LAYOUTS.len()], pair.to_vec()));
    }
    (FIRST_SEED..).zip(drawn).map(|(seed, (layout, effects))| {
        let mut rig = rigged(seed, &effects, SMALL);
        (rig.segments, rig.counts) = (layout.segments, layout.counts);
        (rig.reference, rig.beacon) = (layout.reference, layout.beacon);
        rig
    })
}
