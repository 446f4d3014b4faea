//! Where all readings together say that each segment is: where effects hide a segment's own way, the others and the beacon tell it.

use super::{LinearizedRecording, SampleRows, at};
use crate::algebra::statistics::median;
use effects::sensor::READINGS;
use nalgebra::{Matrix3, Vector3};

/// Places of the segments, and how far the readings' noise moves them.
pub struct ConstrainedPositions {
    /// One a sample and segment, m; empty where a segment is absent.
    pub place_m: [Vec<f64>; 4],
    /// Noise of the places over that of the segments' own, rms.
    pub louder: [f64; 4],
}

impl LinearizedRecording<'_> {
    /// Each segment where its position and the effects found so far say, less what the residual says of it: the mean given the
    /// constraints, all readings off by their noise, and each segment besides by as much as the residual shows that effects still hide.
    /// The beacon keeps no memory of its way. The channels' zeros are this recording's own: what is left in the median says nothing.
    /// Linear in samples.
    pub fn constrained_positions(&self) -> ConstrainedPositions {
        let mut place_m: [Vec<f64>; 4] = std::array::from_fn(|s| {
            let places = self.calibrated_m[s].iter().enumerate();
            places
                .map(|(i, p)| p + at(&self.displacement.total_m[s], i))
                .collect()
        });
        let left: Vec<SampleResidual> = (0..self.len()).map(|i| self.left(i)).collect();
        let zero_m: [f64; 3] = std::array::from_fn(|channel| {
            let of_it = left.iter().filter_map(|l| l.of_channel_m(channel));
            median(&mut of_it.collect::<Vec<_>>()).unwrap_or(0.0)
        });
        let hidden_m2 = self.hidden_m2(&left, zero_m);
        let mut noise = [0.0; 4];
        let mut estimate = 0.0;
        for (i, left) in left.iter().enumerate() {
            let Some(constraint_correction) =
                self.constraint_correction(i, left, zero_m, hidden_m2)
            else {
                continue;
            };
            estimate += 1.0;
            for s in 0..4 {
                place_m[s][i] -= constraint_correction.off_m[s];
                noise[s] += constraint_correction.noise[s];
            }
        }
        let louder = noise.map(|sum| {
            if estimate > 0.0 {
                (sum / estimate).sqrt()
            } else {
                1.0
            }
        });
        ConstrainedPositions { place_m, louder }
    }

    /// What the effects found so far leave of one sample's residual.
    fn left(&self, i: usize) -> SampleResidual {
        let rows = self.rows(i);
        let left_m = std::array::from_fn(|row| {
            let slopes = rows.by_reading[row];
            let by_segments = (0..4).map(|s| slopes[s] * at(&self.displacement.total_m[s], i));
            let channels_m = at(&self.displacement.channels_m[rows.channel[row]], i);
            rows.residual_m[row] + by_segments.sum::<f64>() + channels_m
        });
        SampleResidual { rows, left_m }
    }

    /// Variance of the segments that the residual shows beside the noise, m².
    fn hidden_m2(&self, left: &[SampleResidual], zero_m: [f64; 3]) -> f64 {
        let (mut excess_m2, mut share) = (0.0, 0.0);
        for (i, left) in left.iter().enumerate().filter(|(i, _)| self.mask[*i]) {
            let stated = self.reading_variance(i);
            for row in (0..left.rows.count).filter(|row| left.left_m[*row].is_finite()) {
                let slopes = &left.rows.by_reading[row];
                let noise: f64 = (0..READINGS).map(|r| slopes[r].powi(2) * stated[r]).sum();
                let off_m = left.left_m[row] - zero_m[left.rows.channel[row]];
                excess_m2 += off_m * off_m - noise;
                share += slopes[..4].iter().map(|s| s * s).sum::<f64>();
            }
        }
        (excess_m2 / share).max(0.0)
    }

    /// What that says of the segments; none where nothing is left.
    fn constraint_correction(
        &self,
        i: usize,
        left: &SampleResidual,
        zero_m: [f64; 3],
        hidden_m2: f64,
    ) -> Option<ConstraintCorrection> {
        let rows = &left.rows;
        let stated = self.reading_variance(i);
        let hidden = |r: usize| if r < 4 { hidden_m2 } else { 0.0 };
        let variance: [f64; READINGS] = std::array::from_fn(|r| stated[r] + hidden(r));
        let mut covariance = Matrix3::identity();
        let mut left_m = Vector3::zeros();
        for a in 0..rows.count {
            left_m[a] = left.left_m[a] - zero_m[rows.channel[a]];
            let slopes = &rows.by_reading[a];
            for b in 0..rows.count {
                let products =
                    (0..READINGS).map(|r| slopes[r] * variance[r] * rows.by_reading[b][r]);
                covariance[(a, b)] = products.sum();
            }
        }
        if rows.count == 0 || left_m.iter().any(|m| !m.is_finite()) {
            return None;
        }
        let inverse = covariance.try_inverse()?;
        let gain = |s: usize| {
            let own: [f64; 3] =
                std::array::from_fn(|a| rows.by_reading.get(a).map_or(0.0, |d| d[s]));
            inverse * Vector3::from(own) * variance[s]
        };
        let noise = |s: usize| {
            let gain = gain(s);
            let of = |r: usize| {
                let unit = if r == s { 1.0 } else { 0.0 };
                let taken: f64 = (0..rows.count)
                    .map(|a| gain[a] * rows.by_reading[a][r])
                    .sum();
                (unit - taken).powi(2) * stated[r]
            };
            (0..READINGS).map(of).sum::<f64>() / stated[s]
        };
        Some(ConstraintCorrection {
            off_m: std::array::from_fn(|s| gain(s).dot(&left_m)),
            noise: std::array::from_fn(noise),
        })
    }
}

/// One sample's residual.
struct SampleResidual {
    rows: SampleRows,
    left_m: [f64; 3],
}

impl SampleResidual {
    fn of_channel_m(&self, channel: usize) -> Option<f64> {
        let row = (0..self.rows.count).find(|row| self.rows.channel[*row] == channel)?;
        Some(self.left_m[row]).filter(|m| m.is_finite())
    }
}

/// What one sample says.
struct ConstraintCorrection {
    /// How far each segment is from where it was taken to be, m.
    off_m: [f64; 4],
    /// Variance of the place over that of the segment's own.
    noise: [f64; 4],
}
