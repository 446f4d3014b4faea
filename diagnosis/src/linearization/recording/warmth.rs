//! What follows the board's temperature late: a coil's mount or a frame is warmed through by what is around it.

use effects::sensor::LAGS_S;

/// Temperature less the board's of a body that follows it after each of [`LAGS_S`] (Newton's law of cooling), K. Between readings
/// the temperature is taken to go straight, and before the first to have stood. Empty where it was not measured.
pub(super) fn behind_k(t_s: &[f64], temperature_c: &[f64]) -> Vec<[f64; LAGS_S.len()]> {
    let mut known = (t_s.iter().zip(temperature_c)).filter(|(_, c)| c.is_finite());
    let Some((mut last_s, mut last_c)) = known.next().map(|(t, c)| (*t, *c)) else {
        return Vec::new();
    };
    let mut behind = [0.0; LAGS_S.len()];
    let rows = t_s.iter().zip(temperature_c);
    rows.map(|(&t, &c)| {
        if c.is_finite() && t > last_s {
            let rate = (c - last_c) / (t - last_s);
            for (behind, lag) in behind.iter_mut().zip(LAGS_S) {
                let stays = (-(t - last_s) / lag).exp();
                *behind = *behind * stays - rate * lag * (1.0 - stays);
            }
            (last_s, last_c) = (t, c);
        }
        behind
    })
    .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_body_follows_a_ramp_by_its_lag_and_a_rest_to_the_end() {
        // 0.1 K/s for 1000 s, then 1000 s at rest; readings at uneven times, one of them missing.
        let t_s: Vec<f64> = (0..800)
            .map(|i| f64::from(i) * 2.5 + f64::from(i % 3) * 0.1)
            .collect();
        let mut temperature_c: Vec<f64> = t_s.iter().map(|t| 20.0 + 0.1 * t.min(1000.0)).collect();
        temperature_c[100] = f64::NAN;
        let behind = behind_k(&t_s, &temperature_c);
        for (k, lag) in LAGS_S.iter().enumerate() {
            let ramped = behind[399][k];
            assert!((ramped + 0.1 * lag).abs() < 1e-3 * lag, "{ramped}");
            let rested = behind[799][k];
            assert!(rested.abs() < 1e-3 * lag, "{rested}");
        }
        assert_eq!(behind[0], [0.0; LAGS_S.len()]);
    }

    #[test]
    fn how_often_the_temperature_is_read_on_a_straight_course_is_nothing_to_a_body() {
        let course = |t: f64| {
            20.0 + if t < 30.0 {
                0.2 * t
            } else {
                6.0 - 0.1 * (t - 30.0)
            }
        };
        let at_end = |step: usize| {
            let t_s: Vec<f64> = (0..=90).step_by(step).map(|t| t as f64).collect();
            let temperature_c: Vec<f64> = t_s.iter().map(|t| course(*t)).collect();
            behind_k(&t_s, &temperature_c).pop().expect("readings")
        };
        for (often, seldom) in at_end(1).into_iter().zip(at_end(15)) {
            assert!((often - seldom).abs() < 1e-9, "{often} {seldom}");
        }
    }
}
