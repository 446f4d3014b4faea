//! What rounding alone may do to an answer.
//!
//! One machine gives the same bits each time. Another processor multiplies matrices with or without fused multiplication, and another
//! system's library rounds `sin` and `exp` elsewhere. An answer whose system of equations is nearly singular, or that stands at a
//! border between two words, may then come out otherwise though no line of the code was changed. Which answers are such ones is
//! measured: readings are changed by no more than what their arithmetic rounds away, and the specimen is answered again.

use crate::answer::answer;
use crate::{Answer, Difference, Specimen, compare};
use recording::{Recording, Samples};

/// Draws of rounding for each answer that differs. The chance that a thing which rounding does in half of all draws is met by
/// none of them is 1 in 256.
const DRAWS: u64 = 8;

/// How much farther than the farthest draw a kept number may lie. In 19 sets of 20 the farthest of eight draws of a normal error lies at
/// one standard deviation or more, so that this allows five and more. A change of the code that matters moves a number by many orders of
/// magnitude more than rounding does.
const BEYOND_THE_DRAWS: f64 = 5.0;

/// A recording whose positions, pairs and diode readings are changed in their last places, otherwise for each `draw`.
///
/// Draw 0 makes every other row larger by one unit of the last place. The others change every number by up to the square root of the
/// number of rows, in such units: what rounding leaves in a sum over so many rows (Higham 2002, section 4.2).
#[must_use]
pub fn shaken(recording: &Recording, draw: u64) -> Recording {
    let most = if draw == 0 {
        1
    } else {
        (recording.samples.len() as f64).sqrt() as i64
    };
    let mut state = draw;
    let mut samples = Samples::default();
    for i in 0..recording.samples.len() {
        let mut row = recording.samples.row(i);
        let mut changed = |x: f64| {
            let units = if draw == 0 {
                i64::from(i % 2 == 0)
            } else {
                (next(&mut state) % (2 * most as u64 + 1)) as i64 - most
            };
            by_units(x, units)
        };
        row.position_m = row.position_m.map(|p| p.map(&mut changed));
        row.quadrature_counts = row
            .quadrature_counts
            .map(|q| q.map(|pair| pair.map(&mut changed)));
        samples.push(&row);
    }
    Recording {
        samples,
        ..recording.clone()
    }
}

/// `x` moved by so many units of its last place. Zero and what is no number stay.
fn by_units(x: f64, units: i64) -> f64 {
    if x == 0.0 || !x.is_finite() {
        return x;
    }
    f64::from_bits(x.to_bits().wrapping_add_signed(units))
}

/// Parts the differences from a kept answer into those that rounding alone makes as large in today's answer `now`, and all others.
///
/// # Errors
/// A real recording cannot be read.
pub fn what_rounding_does(
    specimen: &Specimen,
    now: &Answer,
    found: Vec<Difference>,
) -> Result<(Vec<Difference>, Vec<Difference>), recording::Error> {
    let Some(first) = specimen.first()? else {
        return Ok((Vec::new(), found));
    };
    let second = specimen.second();
    let moved: Vec<Difference> = (1..=DRAWS)
        .map(|draw| answer(&shaken(&first, draw), second.as_ref()))
        .flat_map(|drawn| compare(now, &drawn, 0.0))
        .collect();
    Ok(found.into_iter().partition(|one| is_rounding(one, &moved)))
}

/// Whether one of the draws moved the same place about as far. A word that changes is a word that some draw changes too.
fn is_rounding(one: &Difference, moved: &[Difference]) -> bool {
    let here = moved.iter().filter(|m| m.at == one.at);
    let farthest = here.fold(0.0, |most: f64, m| most.max(m.relative));
    if one.relative.is_finite() {
        one.relative <= BEYOND_THE_DRAWS * farthest
    } else {
        farthest.is_infinite()
    }
}

/// The next number of a fixed sequence (splitmix64, Steele et al. 2014).
fn next(state: &mut u64) -> u64 {
    *state = state.wrapping_add(0x9e37_79b9_7f4a_7c15);
    let mut z = *state;
    z = (z ^ (z >> 30)).wrapping_mul(0xbf58_476d_1ce4_e5b9);
    z = (z ^ (z >> 27)).wrapping_mul(0x94d0_49bb_1331_11eb);
    z ^ (z >> 31)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    fn difference(at: &str, relative: f64) -> Difference {
        Difference {
            at: at.into(),
            kept: json!(0),
            now: json!(1),
            relative,
        }
    }

    #[test]
    fn a_number_is_rounding_where_a_draw_moves_it_as_far() {
        let moved = [difference("/a", 1.0e-4), difference("/b", f64::INFINITY)];
        assert!(is_rounding(&difference("/a", 2.0e-4), &moved));
        assert!(!is_rounding(&difference("/a", 1.0e-2), &moved));
        assert!(!is_rounding(&difference("/a", f64::INFINITY), &moved));
        assert!(is_rounding(&difference("/b", f64::INFINITY), &moved));
        assert!(!is_rounding(&difference("/c", 1.0e-9), &moved));
    }

    #[test]
    fn units_of_the_last_place_go_both_ways() {
        assert_eq!(by_units(1.0, 1), 1.0_f64.next_up());
        assert_eq!(by_units(-1.0, -1), (-1.0_f64).next_up());
        assert_eq!(by_units(0.0, 5), 0.0);
        assert!(by_units(f64::NAN, 5).is_nan());
    }
}
