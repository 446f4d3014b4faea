//! The time from each sample of a log to the next.

/// Median of the intervals of time, s.
#[must_use]
pub fn interval_s(t_s: &[f64]) -> f64 {
    let mut intervals: Vec<f64> = t_s.windows(2).map(|pair| pair[1] - pair[0]).collect();
    intervals.sort_by(f64::total_cmp);
    intervals.get(intervals.len() / 2).copied().unwrap_or(1.0)
}

/// Whether each sample came one usual interval after the one before, by half of one.
#[must_use]
pub fn follows(t_s: &[f64]) -> Vec<bool> {
    let usual_s = interval_s(t_s);
    let one = |pair: &[f64]| ((pair[1] - pair[0]) / usual_s - 1.0).abs() < 0.5;
    std::iter::once(false)
        .chain(t_s.windows(2).map(one))
        .collect()
}
