//! Whether a course only rises or only falls: then it is a clock.

/// Turning back by less than this share of the range is no turning back. A prior: a thermometer scatters and steps by 0.1 K, in
/// the few kelvin by which a board warms.
const TURNS_BACK: f64 = 0.05;

/// True if values in order of time only rise, or only fall. Those that are not finite are not there.
pub fn is_one_way(values: &[f64]) -> bool {
    let (mut low, mut high) = (f64::INFINITY, f64::NEG_INFINITY);
    // The most that the course has fallen below its highest so far, and risen above its lowest.
    let (mut fall, mut rise) = (0.0_f64, 0.0_f64);
    for value in values.iter().copied().filter(|v| v.is_finite()) {
        (low, high) = (low.min(value), high.max(value));
        (fall, rise) = (fall.max(high - value), rise.max(value - low));
    }
    high > low && fall.min(rise) < TURNS_BACK * (high - low)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_course_that_comes_back_is_no_clock() {
        let course = |value: fn(f64) -> f64| -> Vec<f64> {
            (0..100).map(|i| value(f64::from(i) / 100.0)).collect()
        };
        assert!(is_one_way(&course(|t| 1.0 - (-3.0 * t).exp())));
        assert!(is_one_way(&course(|t| -t + 0.01 * (50.0 * t).sin())));
        assert!(!is_one_way(&course(|t| (t - 0.5).abs())));
        assert!(!is_one_way(&course(|t| t + 0.2 * (10.0 * t).sin())));
        assert!(!is_one_way(&[1.0; 5]));
        assert!(!is_one_way(&[f64::NAN; 5]));
    }
}
