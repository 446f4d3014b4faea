//! Readings that are taken less often than samples: between two of them a slow quantity goes straight.

/// A list with its gaps filled over time: between readings straight, before the first and after the last as they are. Without any
/// reading it stays. Times ascend. Linear in samples.
pub fn filled(t_s: &[f64], mut values: Vec<f64>) -> Vec<f64> {
    let known: Vec<usize> = (0..values.len())
        .filter(|i| values[*i].is_finite())
        .collect();
    let (Some(&first), Some(&last)) = (known.first(), known.last()) else {
        return values;
    };
    let (start, end) = (values[first], values[last]);
    values[..first].fill(start);
    values[last..].fill(end);
    for pair in known.windows(2) {
        let (a, b) = (pair[0], pair[1]);
        let (from, to, time_s) = (values[a], values[b], t_s[b] - t_s[a]);
        for i in a + 1..b {
            let part = ((t_s[i] - t_s[a]) / time_s.max(1e-12)).clamp(0.0, 1.0);
            values[i] = from + part * (to - from);
        }
    }
    values
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn gaps_are_straight_and_ends_stand() {
        let gap = f64::NAN;
        let t_s = [0.0, 1.0, 2.0, 5.0, 6.0, 7.0];
        let found = filled(&t_s, vec![gap, 20.0, gap, gap, 25.0, gap]);
        assert_eq!(found, [20.0, 20.0, 21.0, 24.0, 25.0, 25.0]);
        assert!(filled(&t_s, vec![gap; 6]).iter().all(|v| v.is_nan()));
        assert!(filled(&[], Vec::new()).is_empty());
    }
}
