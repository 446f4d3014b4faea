//! Small robust statistics.

/// Median; sorts partially in place. `None` of an empty list.
pub fn median(values: &mut [f64]) -> Option<f64> {
    if values.is_empty() {
        return None;
    }
    let middle = values.len() / 2;
    Some(*values.select_nth_unstable_by(middle, f64::total_cmp).1)
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
