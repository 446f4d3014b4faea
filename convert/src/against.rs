//! A segment's travel against the reference's: units, signs and pitches that were stated wrongly show here.

use crate::teeth::{OWN_ERROR_PITCHES, UNSURE_STEP};

/// Pieces that are wanted: the median of fewer tells little.
const PIECES: usize = 5;
/// A piece ends once the segment has come this far, pitches: its own error is some percent of a pitch.
const PIECE_PITCHES: f64 = 1.0;
/// A shorter way tells no ratio, pitches: of this one the segment's own error at both ends is half, so that sign and size are told to a
/// factor of two.
const LEAST_TRAVEL_PITCHES: f64 = 4.0 * OWN_ERROR_PITCHES;

/// Travel of the segment over that of the reference, signed; the median over pieces of a pitch. Of a way of few pitches it is
/// the slope over all of it, since within a pitch the sensor's own error changes the ratio by tens of percent. Both are paths in pitches, NaN
/// where not measured. None where they hardly move.
#[must_use]
pub fn ratio(own: &[f64], reference: &[f64]) -> Option<f64> {
    let both = measured(own, reference);
    let (lowest, highest) = both
        .iter()
        .fold((f64::INFINITY, f64::NEG_INFINITY), |(low, high), (a, _)| {
            (low.min(*a), high.max(*a))
        });
    if !(highest - lowest > LEAST_TRAVEL_PITCHES) {
        return None;
    }
    let (sure, all) = pieces(&both, PIECE_PITCHES);
    let mut ratios = if sure.len() >= PIECES { sure } else { all };
    if ratios.len() < PIECES {
        return slope(own, reference).map(|(slope, _)| slope);
    }
    ratios.sort_by(f64::total_cmp);
    Some(ratios[ratios.len() / 2])
}

/// Places where both were measured.
fn measured(own: &[f64], reference: &[f64]) -> Vec<(f64, f64)> {
    own.iter()
        .copied()
        .zip(reference.iter().copied())
        .filter(|(own, reference)| own.is_finite() && reference.is_finite())
        .collect()
}

/// Ratios of pieces without long steps, and of all.
fn pieces(both: &[(f64, f64)], length: f64) -> (Vec<f64>, Vec<f64>) {
    let (mut sure, mut all) = (Vec::new(), Vec::new());
    let (mut start, mut long) = (0, false);
    for index in 1..both.len() {
        long |= (both[index].0 - both[index - 1].0).abs() > UNSURE_STEP;
        let (own, reference) = (both[index].0 - both[start].0, both[index].1 - both[start].1);
        if own.abs() >= length {
            let ratio = own / reference;
            all.push(ratio);
            if !long {
                sure.push(ratio);
            }
            (start, long) = (index, false);
        }
    }
    (sure, all)
}

/// Rms of what steps of the segment differ by from the reference's, whole pitches apart; 0.29 of two that have nothing to do with
/// each other.
#[must_use]
pub fn misfit(own: &[f64], reference: &[f64]) -> f64 {
    let (mut count, mut square) = (0_u64, 0.0);
    for index in 1..own.len() {
        let step = own[index] - own[index - 1] - reference[index] + reference[index - 1];
        if step.is_finite() {
            count += 1;
            square += (step - step.round()).powi(2);
        }
    }
    (square / count as f64).sqrt()
}

/// Slope of the segment's place over the reference's, and their greatest distance after it, pitches; over the whole recording.
#[must_use]
pub fn slope(own: &[f64], reference: &[f64]) -> Option<(f64, f64)> {
    let both = measured(own, reference);
    let count = both.len() as f64;
    let (own_mean, reference_mean) = both
        .iter()
        .fold((0.0, 0.0), |(a, b), (x, y)| (a + x / count, b + y / count));
    let (mut square, mut product) = (0.0, 0.0);
    for (own, reference) in &both {
        square += (reference - reference_mean).powi(2);
        product += (reference - reference_mean) * (own - own_mean);
    }
    let slope = product / square;
    let distance = |(own, reference): &(f64, f64)| {
        (own - own_mean - slope * (reference - reference_mean)).abs()
    };
    slope
        .is_finite()
        .then(|| (slope, both.iter().map(distance).fold(0.0, f64::max)))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ratios_of_wrong_units_signs_and_pitches() {
        let own: Vec<f64> = (0..4000)
            .map(|k| 6.0 * (0.004 * f64::from(k)).sin())
            .collect();
        for factor in [1.0, -1.0, 1000.0, 1.0 / 25.4, -25.0] {
            let reference: Vec<f64> = own
                .iter()
                .map(|place| (place + 0.02 * (place * std::f64::consts::TAU).sin()) / factor + 3.0)
                .collect();
            let found = ratio(&own, &reference).unwrap();
            assert!((found / factor - 1.0).abs() < 0.02, "{factor}: {found:?}");
            let (slope, distance) = slope(&own, &reference).unwrap();
            assert!(
                (slope / factor - 1.0).abs() < 0.005 && distance < 0.05,
                "{factor}: {slope} {distance}"
            );
        }
        let other: Vec<f64> = (0..4000).map(|k| (0.05 * f64::from(k)).cos()).collect();
        let (_, distance) = slope(&own, &other).unwrap();
        assert!(distance > 3.0, "{distance}");
        // One pitch there and back, with an error that changes the local ratio by half.
        let short: Vec<f64> = (0..400)
            .map(|k| 0.5 * (0.03 * f64::from(k)).sin())
            .collect();
        let read = short
            .iter()
            .map(|place| place + 0.02 * (25.1 * place).sin());
        let found = ratio(&read.collect::<Vec<_>>(), &short).unwrap();
        assert!((found - 1.0).abs() < 0.1, "{found}");
        assert_eq!(ratio(&[1.0; 50], &[1.0; 50]), None);
    }

    /// Counted wrongly, a quick part goes the other way: what was counted for sure decides, however little it is.
    #[test]
    fn steps_that_are_unsure_do_not_tell_the_ratio() {
        let (mut own, mut reference) = (vec![0.0], vec![0.0]);
        let slow = (0..100).map(|_| [0.1, 0.1]);
        let quick = (0..300).map(|_| [-0.46, 0.54]);
        for [read, went] in slow.chain(quick) {
            own.push(own[own.len() - 1] + read);
            reference.push(reference[reference.len() - 1] + went);
        }
        let found = ratio(&own, &reference).unwrap();
        assert!((found - 1.0).abs() < 0.01, "{found}");
    }
}
