//! Whether a set of effects is worth what it has beyond another: what it leaves of the gap, on which parts of the data, and beside what.

use crate::data::folds::FOLDS;
use crate::inference::cross_validation::{CrossValidation, Score};
use crate::selection::limits::MINIMUM_SQUARES;
use effects::Card;

/// A further effect must take this share of the whole gap.
pub const MINIMUM_SHARE: f64 = 0.025;
/// The same beside an effect with very many unknowns, whose own remainder is larger.
pub const MINIMUM_SHARE_BESIDE_FLEXIBLE: f64 = 0.05;
/// And this share of what those before it left.
pub const MINIMUM_OF_REST: f64 = 0.4;

/// Whitened squares beyond `floor`, as a share of those of the baseline.
pub fn unexplained_fraction(validation: &mut CrossValidation, blocks: &[usize], floor: f64) -> f64 {
    let whole_gap = (validation.score(&[]).squares - floor).max(MINIMUM_SQUARES);
    let left = validation.score(blocks).squares;
    // What is of no physical size explains nothing.
    if left.is_finite() {
        (left - floor) / whole_gap
    } else {
        1.0
    }
}

/// What an effect must take to be beyond chance, as a share of the excess.
pub fn least_share(validation: &mut CrossValidation, floor: f64) -> f64 {
    MINIMUM_SQUARES / (validation.score(&[]).squares - floor).max(MINIMUM_SQUARES)
}

/// True if `with` beats `without` on all but one fold and by more than chance.
pub fn steady(with: &Score, without: &Score) -> bool {
    let better = with
        .fold
        .iter()
        .zip(&without.fold)
        .filter(|(a, b)| a < b)
        .count();
    better + 1 >= FOLDS && without.squares - with.squares > MINIMUM_SQUARES
}

/// True if what a set has beyond another is there on every part of the data, is no mere trifle beside what is left, and is
/// either a good part of the whole gap or all that was missing.
pub fn worth(
    validation: &mut CrossValidation,
    set: &[usize],
    chosen: &[usize],
    floor: f64,
) -> bool {
    let (old, new) = (validation.score(chosen), validation.score(set));
    // What the columns could have shown besides speaks against them: hundreds of them leave less by what they hold of the noise.
    if !steady(&new, &old) || new.log_evidence <= old.log_evidence {
        return false;
    }
    let before = unexplained_fraction(validation, chosen, floor);
    // Where less is left than the stated noise, nobody can tell what of it is an effect and what is noise that is stated too high.
    if before <= 0.0 && !chosen.is_empty() {
        return false;
    }
    let before = before.max(1e-6);
    let after = unexplained_fraction(validation, set, floor);
    let gain = before - after;
    if chosen.is_empty() && gain > FIRST_SHARE {
        return true;
    }
    let simple_beside = is_flexible(validation, chosen) && !adds_flexible(validation, set, chosen);
    let most = if simple_beside {
        FIELD_REST_SHARES
    } else {
        (SEARCH_NEARLY_ALL, 0.0)
    };
    let nearly_all = gain > most.0 * before && gain > most.1;
    let closes = nearly_all || closes(validation, &new, (before, gain), floor);
    gain > MINIMUM_OF_REST * before && (gain > minimum_share(validation, set) || closes)
}

/// Share of the gap that the first effect must take.
const FIRST_SHARE: f64 = 0.05;
/// An effect that leaves nothing may be as small a share of the gap as this.
const CLOSING_SHARE: f64 = 0.003;
/// Or smaller still, if it takes this share of what the others left: a stand-in for their second order would not.
pub const SEARCH_COMPLETING_SHARE: f64 = 0.8;
/// However little of a great gap that is, and whatever inexact shape the others leave besides: no stand-in takes this share.
const SEARCH_NEARLY_ALL: f64 = 0.95;
/// The same of one of few unknowns beside one of very many, and of the whole gap: what a field lacks follows the place, and no few
/// unknowns of another's take most of it.
const FIELD_REST_SHARES: (f64, f64) = (0.6, 0.01);
/// Left over a row, beyond the noise and relative to it, where nothing is said to be left: a whitened rms of 1.12.
const CLOSED_EXCESS: f64 = 0.25;

/// True if nothing is left after a set, so that its last effect is no stand-in for a shape that another lacks.
fn closes(
    validation: &CrossValidation,
    after: &Score,
    (before, gain): (f64, f64),
    floor: f64,
) -> bool {
    (gain > CLOSING_SHARE || gain > SEARCH_COMPLETING_SHARE * before)
        && after.squares - floor < CLOSED_EXCESS * validation.rows()
}

fn minimum_share(validation: &CrossValidation, set: &[usize]) -> f64 {
    if is_flexible(validation, set) {
        MINIMUM_SHARE_BESIDE_FLEXIBLE
    } else {
        MINIMUM_SHARE
    }
}

/// True if some effect of a set has very many unknowns.
pub fn is_flexible(validation: &CrossValidation, set: &[usize]) -> bool {
    let name = |b: &usize| validation.columns.blocks[*b].name.as_str();
    set.iter().any(|b| effects::has(name(b), Card::is_flexible))
}

/// True if one with very many unknowns is in a set that is not in another.
fn adds_flexible(validation: &CrossValidation, set: &[usize], chosen: &[usize]) -> bool {
    let added: Vec<usize> = set
        .iter()
        .copied()
        .filter(|b| !chosen.contains(b))
        .collect();
    is_flexible(validation, &added)
}
