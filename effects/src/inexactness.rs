//! How far each effect's form is from what sensors do, measured on couriers that no figure is published from.
//!
//! `inexactness.csv` has, courier by courier, the whitened squares that the true effect alone explains of a recording and those that it
//! leaves above the noise. `cargo run --release -p blind --example inexactness -- SEED COUNT` writes it.

use std::collections::HashMap;
use std::sync::OnceLock;

/// The measurements: effect, simulator, number, size in µm rms, samples, squares explained, squares left.
const MEASURED: &str = include_str!("../inexactness.csv");
/// Standard deviation of the share of its amplitude that a form lacks, before anything is measured. A prior without data: a few percent.
const BEFORE: f64 = 0.05;
/// Couriers that the prior counts for. A prior: a few measured ones say more.
const PRIOR_COURIERS: f64 = 2.0;
/// Squares from which on a courier tells. Derived from chi-square: what is left shows from some fifty squares on, and that is
/// then a share of the amplitude of less than 0.07, the root of fifty in ten thousand.
const EXPLAINED_FROM: f64 = 1.0e4;
/// A courier that leaves more of its squares was not described by the form at all, and tells nothing of how exact it is. A prior:
/// a form that lacks half of the amplitude describes something else.
const LEFT_TO: f64 = 0.25;
/// The 97.5 % point of the standard normal distribution: 95 % of normal numbers are within so many standard deviations.
const WITHIN: f64 = 1.96;

/// Share of its amplitude that an effect's form may lack, with 95 % probability.
#[must_use]
pub fn inexactness(effect: &str) -> f64 {
    static SHARES: OnceLock<HashMap<&str, Vec<f64>>> = OnceLock::new();
    let shares = SHARES.get_or_init(|| shares(MEASURED));
    WITHIN * deviation(shares.get(effect).map_or(&[], Vec::as_slice))
}

/// What each other effect takes of what a form lacks: effect, simulator, number, squares left, other, its columns, those told, squares taken.
const TAKEN: &str = include_str!("../form_errors.csv");
/// Share of what lacks from which on it lies along the other's columns. By definition: most of it.
const MOST_OF_IT: f64 = 0.5;

/// Name of the shapes of lines in the spectrum among the others.
const LINES: &str = "frequency";

/// Share of what forms lack that is lines in the spectrum, in the mean of all measured couriers. What follows the motion has lines where the motion
/// has some.
#[must_use]
pub fn lacks_in_lines() -> f64 {
    static SHARE: OnceLock<f64> = OnceLock::new();
    *SHARE.get_or_init(|| {
        let taken = TAKEN.lines().filter_map(taken);
        let shares: Vec<f64> = taken
            .filter(|t| t.other == LINES)
            .map(|t| (t.squares / t.left).clamp(0.0, 1.0))
            .collect();
        shares.iter().sum::<f64>() / shares.len().max(1) as f64
    })
}

/// What one block takes of what an effect's form lacks.
struct Taken<'a> {
    effect: &'a str,
    other: &'a str,
    left: f64,
    squares: f64,
}

/// A line of the measurements.
fn taken(line: &str) -> Option<Taken<'_>> {
    let cells: Vec<&str> = line.split(',').collect();
    let number = |k: usize| cells.get(k).and_then(|cell| cell.parse::<f64>().ok());
    Some(Taken {
        effect: cells[0],
        left: number(3)?,
        other: cells[4],
        squares: number(7)?,
    })
}

/// Probability that what an effect's form lacks lies along the columns of another: as often as it did on the couriers of this pair, beside what is so of all
/// pairs, which counts for as many couriers as the prior does.
#[must_use]
pub fn lacks_along(effect: &str, other: &str) -> f64 {
    static COUNTS: OnceLock<HashMap<(&str, &str), (f64, f64)>> = OnceLock::new();
    static OF_ALL: OnceLock<f64> = OnceLock::new();
    let counts = COUNTS.get_or_init(|| counts(TAKEN));
    let of_all = *OF_ALL.get_or_init(|| {
        let sum = |of: fn(&(f64, f64)) -> f64| counts.values().map(of).sum::<f64>();
        sum(|count| count.0) / sum(|count| count.1)
    });
    let (along, of) = counts.get(&(effect, other)).copied().unwrap_or_default();
    (along + PRIOR_COURIERS * of_all) / (of + PRIOR_COURIERS)
}

/// How many couriers of each pair of effects there are of which the other takes most, and how many in all.
fn counts(text: &str) -> HashMap<(&str, &str), (f64, f64)> {
    let mut out: HashMap<(&str, &str), (f64, f64)> = HashMap::new();
    let of_effects = text.lines().filter_map(taken).filter(|t| t.other != LINES);
    for taken in of_effects {
        let count = out.entry((taken.effect, taken.other)).or_default();
        count.0 += f64::from(u8::from(taken.squares > MOST_OF_IT * taken.left));
        count.1 += 1.0;
    }
    out
}

/// Standard deviation of the share of the amplitude, of measured shares of the squares and the prior.
fn deviation(shares: &[f64]) -> f64 {
    let sum: f64 = shares.iter().sum();
    ((sum + PRIOR_COURIERS * BEFORE * BEFORE) / (shares.len() as f64 + PRIOR_COURIERS)).sqrt()
}

/// Shares of the squares that are left, by effect.
fn shares(text: &str) -> HashMap<&str, Vec<f64>> {
    let mut out: HashMap<&str, Vec<f64>> = HashMap::new();
    for line in text.lines() {
        let cells: Vec<&str> = line.split(',').collect();
        let number = |k: usize| cells.get(k).and_then(|cell| cell.parse::<f64>().ok());
        // The header and comments have no numbers there.
        let (Some(explained), Some(left)) = (number(5), number(6)) else {
            continue;
        };
        if explained >= EXPLAINED_FROM && left <= LEFT_TO * explained {
            out.entry(cells[0]).or_default().push(left / explained);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_fitted_effect_was_measured() {
        let found = shares(MEASURED);
        for card in crate::cards().filter(|card| card.detection.is_fitted()) {
            let count = found.get(card.name).map_or(0, Vec::len);
            assert!(count >= 3, "{}: {count} couriers", card.name);
        }
    }

    #[test]
    fn measured_shares_take_the_place_of_the_prior() {
        assert!((deviation(&[]) - BEFORE).abs() < 1e-12);
        let coarse = deviation(&[0.04; 8]);
        assert!((0.17..0.2).contains(&coarse), "{coarse}");
        let exact = deviation(&[0.0; 30]);
        assert!(exact < 0.015, "{exact}");
    }

    /// What clips is told to lack harmonics, as it did; of a pair that was not measured the share of all is told.
    #[test]
    fn what_lacks_along_another_is_measured_by_pairs() {
        let of_all = lacks_along("no effect", "no other");
        assert!((0.01..0.1).contains(&of_all), "{of_all}");
        assert!(lacks_along("adc_clipping", "extra_harmonics") > 5.0 * of_all);
        assert!(lacks_along("lateral_dependence", "thermal_drift") < of_all);
        assert!((0.05..0.2).contains(&lacks_in_lines()));
    }

    #[test]
    fn what_tells_nothing_is_left_out() {
        let text = "effect,simulator,number,size_um,samples,explained,left\na,x,0,1,9,2e4,200\na,x,1,1,9,5e3,0\na,x,2,1,9,2e4,9e3";
        assert_eq!(shares(text).get("a"), Some(&vec![0.01]));
    }
}
