//! Short disturbances, marked before anything is fitted.

use crate::statistics::median_and_deviation;

/// Samples in a piece over which a disturbance must stand out.
const PIECE: usize = 60;
/// By this many robust deviations.
const OUTSIDE: f64 = 7.0;

/// Marks samples that stand out of their neighbourhood. `rows` are (sample, channel, whitened residual) in time order.
pub fn disturbed(rows: &[(usize, usize, f64)], samples: usize, stretch: &[usize]) -> Vec<bool> {
    let mut marked = vec![false; samples];
    for channel in 0..effects::sensor::CHANNELS {
        let list: Vec<(usize, f64)> = rows
            .iter()
            .filter(|r| r.1 == channel)
            .map(|r| (r.0, r.2))
            .collect();
        let mut start = 0;
        while start < list.len() {
            let mut end = start;
            while end < list.len()
                && end - start < PIECE
                && stretch[list[end].0] == stretch[list[start].0]
            {
                end += 1;
            }
            let mut values: Vec<f64> = list[start..end].iter().map(|r| r.1).collect();
            if let Some((centre, deviation)) =
                median_and_deviation(&mut values).filter(|_| end - start >= 20)
            {
                let limit = OUTSIDE * deviation.max(1.0);
                for (i, value) in &list[start..end] {
                    if (value - centre).abs() > limit {
                        marked[*i] = true;
                    }
                }
            }
            start = end;
        }
    }
    marked
}
