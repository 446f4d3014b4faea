//! The set of specimens: small ones for the ordinary tests first, then the independent simulator's, the project's own, real ones,
//! and [`crate::short`] ones by the hundred.

use crate::rigged::{SMALL, rigged};
use crate::{Specimen, short};
use specimens::rig::{CATALOGUE, Dice, UNLISTED};
use specimens::{Case, Conditions, SIZES_M};

/// The ordinary tests answer so many from the front.
pub const SAMPLE: usize = 12;
/// Samples asked of the independent simulator's others, as its tests ask.
const USUAL: usize = 6000;
/// Couriers of the project's own simulator: a whole survey each, which takes ten times as long as a short specimen.
const DRAWN: usize = 20;
/// The seed that they were drawn from: any would do.
const SEED: u64 = 37;
/// Real recordings, where the shared folder has them.
const REAL: [&str; 9] = [
    "ess-rotary-drive-divided",
    "ess-rotary-normal",
    "magnetic-ring-1",
    "magnetic-ring-1-wrapped",
    "magnetic-ring-2",
    "magnetic-ring-3",
    "magnetic-ring-3-wrapped",
    "moteus-calibration-log",
    "quadrant-diode-aug28",
];

/// Effects of the small ones, of each kind of evidence one, and whether all channels are recorded: else one segment and a reference,
/// which is answered in a tenth of the time.
const SMALL_ONES: [(&[&str], bool); SAMPLE] = [
    (&[], false),
    (&["lateral_dependence"], true),
    (&["tooth_variation"], false),
    (&["psd_nonlinearity"], true),
    (&["thermal_drift"], false),
    (&["velocity_lag"], false),
    (&["beacon_vibration"], true),
    (&["excess_noise"], false),
    (&["adc_clipping"], false),
    (&["quadrature_drift"], false),
    (&["extra_harmonics", "hysteresis"], false),
    (&["warm_harmonics"], false),
];

/// The whole set, drawn anew.
#[must_use]
pub fn list() -> Vec<Specimen> {
    let small = SMALL_ONES.iter().enumerate().map(|(k, (names, whole))| {
        let effects: Vec<_> = names.iter().map(|name| (*name, 2.0e-6)).collect();
        let mut rig = rigged(100 + k as u64, &effects, SMALL);
        if !whole {
            (rig.beacon, rig.reference, rig.segments) = (false, true, 1);
        }
        Specimen::Rig(rig)
    });
    let own = (0..DRAWN).map(|number| Specimen::Drawn(Case::draw(number, SEED, Conditions::Usual)));
    let real = REAL.into_iter().map(|name| Specimen::Real(name.into()));
    let first = small.chain(independent()).chain(own).chain(real);
    first.chain(short::specimens().map(Specimen::Rig)).collect()
}

/// Of the independent simulator: each effect alone, pairs, nothing; in turn with all channels, without a beacon, without counts and
/// against a reference.
fn independent() -> impl Iterator<Item = Specimen> {
    let mut dice = Dice(SEED);
    let size = |dice: &mut Dice| SIZES_M[0] * (SIZES_M[1] / SIZES_M[0]).powf(dice.unit());
    let mut effects: Vec<Vec<(&str, f64)>> = vec![Vec::new(); 4];
    for name in CATALOGUE.into_iter().chain(UNLISTED) {
        effects.push(vec![(name, size(&mut dice))]);
    }
    while effects.len() < 4 + CATALOGUE.len() + UNLISTED.len() + 20 {
        let [a, b] = [0; 2].map(|_| CATALOGUE[dice.pick(CATALOGUE.len())]);
        if a != b {
            effects.push(vec![(a, size(&mut dice)), (b, size(&mut dice))]);
        }
    }
    effects.into_iter().enumerate().map(|(k, effects)| {
        let mut rig = rigged(500 + k as u64, &effects, USUAL);
        match k % 4 {
            1 => rig.beacon = false,
            2 => rig.counts = false,
            3 => rig.reference = true,
            _ => {}
        }
        Specimen::Rig(rig)
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::collections::HashSet;

    #[test]
    fn names_tell_specimens_apart() {
        let names: Vec<String> = list().iter().map(Specimen::name).collect();
        let set: HashSet<&String> = names.iter().collect();
        assert_eq!(set.len(), names.len());
    }
}
