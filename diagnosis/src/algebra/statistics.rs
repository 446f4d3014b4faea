//! Small robust statistics.

/// 97.5 % point of the standard normal distribution: standard deviations on either side of a 95 % interval.
pub const NORMAL_97_5: f64 = 1.96;
/// 95 % point of the standard normal distribution: 95 % of normal numbers are below so many standard deviations.
pub const NORMAL_95: f64 = 1.645;

/// Median; sorts partially in place. `None` of an empty list.
pub fn median(values: &mut [f64]) -> Option<f64> {
    quantile(values, 0.5)
}

/// The value that a share of all stay below; sorts partially in place. `None` of an empty list.
pub fn quantile(values: &mut [f64], share: f64) -> Option<f64> {
    let last = values.len().checked_sub(1)?;
    let at = ((values.len() as f64 * share) as usize).min(last);
    Some(*values.select_nth_unstable_by(at, f64::total_cmp).1)
}

/// Median and 1.4826 times the median absolute deviation (a standard deviation for normal values).
pub fn median_and_deviation(values: &mut [f64]) -> Option<(f64, f64)> {
    let centre = median(values)?;
    values
        .iter_mut()
        .for_each(|value| *value = (*value - centre).abs());
    Some((centre, 1.4826 * median(values)?))
}

/// Root of the mean square; zero of nothing.
pub fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (mut sum, mut count) = (0.0, 0usize);
    for value in values {
        sum += value * value;
        count += 1;
    }
    if count == 0 {
        0.0
    } else {
        (sum / count as f64).sqrt()
    }
}

/// Standard deviation about the mean; zero of nothing.
pub fn deviation(values: &[f64]) -> f64 {
    let mean = values.iter().sum::<f64>() / values.len().max(1) as f64;
    rms(values.iter().map(|v| v - mean))
}

/// Largest less smallest of the values that are numbers; zero of nothing.
pub fn spread(values: &[f64]) -> f64 {
    let known = values.iter().filter(|v| v.is_finite());
    let (low, high) = known.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), v| {
        (l.min(*v), h.max(*v))
    });
    (high - low).max(0.0)
}

/// Finest step that is looked for, in the values' unit: positions in metres have no digits beyond. A definition: a hundredth of a
/// nanometre.
const FINEST: f64 = 1.0e-11;

/// Step of which all differences of neighbours are whole multiples (Euclid's algorithm), as of numbers logged with few digits;
/// zero if there is none.
pub fn step(values: &[f64]) -> f64 {
    let mut step = 0.0;
    for pair in values.windows(2) {
        let mut rest = (pair[1] - pair[0]).abs();
        while rest > FINEST && rest.is_finite() {
            (step, rest) = if step == 0.0 {
                (rest, 0.0)
            } else {
                (
                    rest.min(step),
                    (rest.max(step) / rest.min(step)).fract() * rest.min(step),
                )
            };
            // What is left of a division without remainder, from below or above.
            if rest < 0.01 * step || rest > 0.99 * step {
                rest = 0.0;
            }
        }
        if step > 0.0 && step < 10.0 * FINEST {
            return 0.0;
        }
    }
    step
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn logged_digits_are_found() {
        let smooth: Vec<f64> = (0..100).map(|i| (0.1 * f64::from(i)).sin()).collect();
        assert_eq!(step(&smooth), 0.0);
        let rounded: Vec<f64> = smooth.iter().map(|v| (v * 1e3).round() * 1e-3).collect();
        assert!((step(&rounded) - 1e-3).abs() < 1e-9);
        assert_eq!(step(&[]), 0.0);
    }
}
