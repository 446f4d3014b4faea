//! Averages the frames of one pose and checks that the courier stood still.

use super::sample::Sample;
use crate::frame::{Frame, SEGMENTS, Status};
use crate::math::sqrt;

/// Frames of one pose at most. Derived from their mean: its noise is 0.18 of a frame's.
pub const FRAMES: usize = 32;
/// A frame further than this many robust deviations from the median in any channel is left out. Derived from the median deviation
/// of 32 frames, which is known to 21 %: 6 of it are 3.5 at two such errors, by chance one frame in 2,000.
const OUTLIER: f32 = 6.0;
/// Standard deviation over median absolute deviation. Derived from the normal distribution: one over its 75 % point, 0.6745.
const MAD_TO_SIGMA: f32 = 1.4826;
/// Share of the frames that must survive. A prior: fewer are no outliers but a courier that moves, and the pose is tried again.
const KEPT_SHARE: f32 = 0.75;

/// What makes a frame useless for calibration.
pub const UNUSABLE: Status = Status::from_bits_truncate(
    0xffff
        | Status::PARITY.bits()
        | Status::CONVERTER_CRC.bits()
        | Status::CONVERTER_TIMEOUT.bits()
        | Status::NUMERIC.bits()
        | Status::FROZEN.bits()
        | Status::RAIL_1.bits()
        | Status::RAIL_2.bits()
        | Status::RAIL_3.bits()
        | Status::RAIL_4.bits(),
);

/// Means over one pose.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct PoseMean {
    /// Unmodified outputs and temperature.
    pub sample: Sample,
    /// Parity by the calibration in force, metres.
    pub parity_in_force_m: f32,
    /// Amplitudes, counts.
    pub amplitude_counts: [f32; SEGMENTS],
    /// Measured tan psi of the coordination sensor.
    pub tan_psi: [f32; 2],
    /// Mean sum of the coordination sensor's electrodes: the light, counts.
    pub light_counts: f32,
    /// Largest of the channels' standard deviations, metres.
    pub spread_m: f32,
}

/// A courier that did not stand still.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unsteady {
    /// Standard deviation of a channel, or drift between the two halves of the frames, metres.
    pub spread_m: f32,
    /// What the stated noise allows, metres.
    pub limit_m: f32,
}

/// Collects up to [`FRAMES`] frames as deviations from the first.
#[derive(Clone, Debug)]
pub struct Average {
    first: Sample,
    deviation_turns: [[f32; SEGMENTS]; FRAMES],
    parity_in_force_m: [f32; FRAMES],
    tan_psi: [[f32; 2]; FRAMES],
    light_counts: f32,
    amplitude_counts: [f32; SEGMENTS],
    temperature_k: f32,
    count: usize,
}

impl Average {
    /// Nothing collected. A function: a constant of this size would lie in the image's flash.
    pub const fn empty() -> Self {
        Self {
            first: Sample::ZERO,
            deviation_turns: [[0.0; SEGMENTS]; FRAMES],
            parity_in_force_m: [0.0; FRAMES],
            tan_psi: [[0.0; 2]; FRAMES],
            light_counts: 0.0,
            amplitude_counts: [0.0; SEGMENTS],
            temperature_k: 0.0,
            count: 0,
        }
    }

    /// Starts anew.
    pub fn clear(&mut self) {
        self.count = 0;
        self.amplitude_counts = [0.0; SEGMENTS];
        self.temperature_k = 0.0;
        self.light_counts = 0.0;
    }

    /// Frames collected.
    #[must_use]
    pub fn count(&self) -> usize {
        self.count
    }

    /// Adds a usable frame; more than [`FRAMES`] are ignored.
    pub fn add(&mut self, frame: &Frame) {
        if self.count == 0 {
            self.first = Sample::of(frame);
        }
        let Some(deviation) = self.deviation_turns.get_mut(self.count) else {
            return;
        };
        for (segment, deviation) in deviation.iter_mut().enumerate() {
            *deviation = frame.segments[segment]
                .unmodified
                .minus_turns(self.first.unmodified[segment]);
            self.amplitude_counts[segment] += frame.segments[segment].amplitude_counts;
        }
        self.parity_in_force_m[self.count] = frame.parity_m;
        self.tan_psi[self.count] = frame.tan_psi;
        self.light_counts += frame
            .raw
            .electrode_counts
            .iter()
            .map(|&c| f32::from(c))
            .sum::<f32>();
        self.temperature_k += frame.raw.temperature_delta_k;
        self.count += 1;
    }

    /// Mean of the frames that agree with their median.
    ///
    /// # Errors
    /// The courier did not stand still: spread, or drift between the two halves, above what `noise_m`, a frame's noise,
    /// allows.
    pub fn finish(&self, pitch_m: f32, noise_m: f32) -> Result<PoseMean, Unsteady> {
        let frames = &self.deviation_turns[..self.count];
        let (medians, allowed) = self.medians_and_allowance(noise_m / pitch_m);
        let mut sums = Sums::default();
        let mut halves = [Sums::default(), Sums::default()];
        for (i, frame) in frames.iter().enumerate() {
            let off = frame
                .iter()
                .zip(&medians)
                .zip(&allowed)
                .any(|((d, m), a)| (d - m).abs() > *a);
            if !off {
                sums.add(frame, &medians, self.parity_in_force_m[i], self.tan_psi[i]);
                halves[2 * i / self.count].add(frame, &medians, 0.0, [0.0; 2]);
            }
        }
        let spread_m = sums.spread() * pitch_m;
        let drift_m = halves[0].apart(&halves[1]) * pitch_m;
        // A standard deviation of n values scatters by 1 / sqrt(2 n); a difference of half means by 2 / sqrt(n).
        let spread_limit = noise_m * (1.0 + 4.0 / sqrt(2.0 * sums.count.max(1.0)));
        let drift_limit = 5.0 * noise_m * 2.0 / sqrt(sums.count.max(1.0));
        if sums.count < KEPT_SHARE * self.count as f32 || self.count == 0 {
            let spread_m = allowed.iter().fold(spread_m, |a, b| a.max(b * pitch_m));
            return Err(Unsteady {
                spread_m,
                limit_m: spread_limit,
            });
        }
        if spread_m > spread_limit {
            return Err(Unsteady {
                spread_m,
                limit_m: spread_limit,
            });
        }
        if drift_m > drift_limit {
            return Err(Unsteady {
                spread_m: drift_m,
                limit_m: drift_limit,
            });
        }
        Ok(self.mean(&sums, &medians, spread_m))
    }

    fn mean(&self, sums: &Sums, medians: &[f32; SEGMENTS], spread_m: f32) -> PoseMean {
        let all = self.count as f32;
        let mut sample = Sample {
            temperature_delta_k: self.temperature_k / all,
            ..self.first
        };
        for (segment, output) in sample.unmodified.iter_mut().enumerate() {
            output.fraction_turns += medians[segment] + sums.sum[segment] / sums.count;
        }
        PoseMean {
            sample,
            parity_in_force_m: sums.parity / sums.count,
            amplitude_counts: self.amplitude_counts.map(|a| a / all),
            tan_psi: sums.tan_psi.map(|t| t / sums.count),
            light_counts: self.light_counts / all,
            spread_m,
        }
    }

    fn medians_and_allowance(&self, noise_turns: f32) -> ([f32; SEGMENTS], [f32; SEGMENTS]) {
        let (mut medians, mut allowed) = ([0.0; SEGMENTS], [0.0; SEGMENTS]);
        for segment in 0..SEGMENTS {
            let mut column = [0.0; FRAMES];
            for (to, frame) in column.iter_mut().zip(&self.deviation_turns[..self.count]) {
                *to = frame[segment];
            }
            let column = &mut column[..self.count];
            medians[segment] = median(column);
            column
                .iter_mut()
                .for_each(|d| *d = (*d - medians[segment]).abs());
            let sigma = MAD_TO_SIGMA * median(column);
            // Few frames may agree by chance, or by quantisation: a tenth of the stated noise is the least believed.
            allowed[segment] = OUTLIER * sigma.max(0.1 * noise_turns);
        }
        (medians, allowed)
    }
}

#[derive(Clone, Copy, Debug, Default)]
struct Sums {
    sum: [f32; SEGMENTS],
    squares: [f32; SEGMENTS],
    parity: f32,
    tan_psi: [f32; 2],
    count: f32,
}

impl Sums {
    fn add(
        &mut self,
        frame: &[f32; SEGMENTS],
        medians: &[f32; SEGMENTS],
        parity: f32,
        tan_psi: [f32; 2],
    ) {
        for segment in 0..SEGMENTS {
            let d = frame[segment] - medians[segment];
            self.sum[segment] += d;
            self.squares[segment] += d * d;
        }
        self.parity += parity;
        self.tan_psi = [self.tan_psi[0] + tan_psi[0], self.tan_psi[1] + tan_psi[1]];
        self.count += 1.0;
    }

    fn spread(&self) -> f32 {
        let n = self.count.max(2.0);
        let variance = |i: usize| (self.squares[i] - self.sum[i] * self.sum[i] / n) / (n - 1.0);
        sqrt((0..SEGMENTS).map(variance).fold(0.0, f32::max))
    }

    fn apart(&self, other: &Self) -> f32 {
        let mean = |s: &Self, i: usize| s.sum[i] / s.count.max(1.0);
        (0..SEGMENTS)
            .map(|i| (mean(self, i) - mean(other, i)).abs())
            .fold(0.0, f32::max)
    }
}

/// Median of a few values, which it sorts (by insertion: core's sorts are 3.5 KiB of flash); zero of none.
fn median(values: &mut [f32]) -> f32 {
    for end in 1..values.len() {
        for place in (1..=end).rev() {
            if values[place - 1].total_cmp(&values[place]).is_le() {
                break;
            }
            values.swap(place - 1, place);
        }
    }
    let half = values.len() / 2;
    match (values.get(half), values.len() % 2) {
        (Some(upper), 0) => (values[half - 1] + upper) / 2.0,
        (Some(middle), _) => *middle,
        (None, _) => 0.0,
    }
}
