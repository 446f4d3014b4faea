//! Noise of a board's channels, measured while the courier rests.
//!
//! Samples that follow each other are cut into blocks. A parabola fitted to each channel of a block takes out what
//! the courier moves in it, and what remains is noise: eight samples less the parabola's three coefficients are five degrees of
//! freedom. Blocks in which the courier moves are left out, since there the parabola would not follow the wave. Whether it moves is
//! told by slope and curvature of the positions, which do not depend on what remains beside them: leaving blocks out by them
//! does not make the noise look smaller.

use super::ROUNDING_VARIANCE;

/// Segments of a sample.
pub const SEGMENTS: usize = 4;
/// Channels of a sample: sine and cosine of four segments, then four electrodes.
pub const CHANNELS: usize = 2 * SEGMENTS + 4;
/// Samples of a block.
const BLOCK: usize = 8;
/// Degrees of freedom beside a parabola.
const FREEDOM: f64 = (BLOCK - 3) as f64;
/// Median of chi-square with five degrees of freedom, as tables have it.
const CHI_SQUARE_MEDIAN: f64 = 4.351_460;
/// Fisher's F with 2 and 5 degrees of freedom, which one resting block in a thousand exceeds, as tables have it.
const F_OF_REST: f64 = 37.12;
/// Still blocks that tell the noise of eight channels to one percent: a median of n chi-squares with five degrees of freedom scatters
/// by sqrt(pi / 2) * sqrt(2 / 5 / n), the noise by half of that, and the mean over eight channels by sqrt(8) less.
const FEWEST_BLOCKS: usize = 200;
/// A channel is at the converter's end from here on, counts: the signal path's limit.
const CONVERTER_END_COUNTS: f64 = 32_760.0;
/// Orthogonal polynomials of degree 1 and 2 on eight equally spaced places, and their squared lengths.
const SLOPE: [f64; BLOCK] = [-7.0, -5.0, -3.0, -1.0, 1.0, 3.0, 5.0, 7.0];
const CURVATURE: [f64; BLOCK] = [7.0, 1.0, -3.0, -5.0, -5.0, -3.0, 1.0, 7.0];
const SQUARES: [f64; 2] = [168.0, 168.0];

/// Noise of both kinds of channels, rms counts before rounding.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Noise {
    /// Of a quadrature channel.
    pub quadrature_counts: f64,
    /// Of an electrode.
    pub electrode_counts: f64,
}

/// Why the noise could not be measured.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
pub enum Unmeasured {
    /// Too few samples followed each other.
    #[error(
        "found {blocks} stretches of {BLOCK} samples without a gap, wanted {FEWEST_BLOCKS}: the link is too slow"
    )]
    Gaps {
        /// Whole blocks.
        blocks: usize,
    },
    /// The courier moved.
    #[error(
        "found the courier at rest in {still} of {blocks} stretches of {BLOCK} samples, wanted {FEWEST_BLOCKS}: let it rest for half a second"
    )]
    Moving {
        /// Blocks at rest.
        still: usize,
        /// Whole blocks.
        blocks: usize,
    },
}

/// One sample as the noise is measured from.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Reading {
    /// Number of the sample.
    pub sequence: u32,
    /// Counts of all channels.
    pub counts: [f64; CHANNELS],
    /// Unmodified outputs of the segments, pitches.
    pub position_turns: [f64; SEGMENTS],
}

/// Noise of readings, of which those that follow each other are so many samples apart.
///
/// # Errors
/// [`Unmeasured`]: too few of them follow each other, or the courier moves.
pub fn measure(readings: &[Reading], samples_apart: u32) -> Result<Noise, Unmeasured> {
    let whole: Vec<&[Reading]> = blocks(readings, samples_apart).collect();
    let still: Vec<&[Reading]> = whole.iter().copied().filter(|block| rests(block)).collect();
    if whole.len() < FEWEST_BLOCKS {
        return Err(Unmeasured::Gaps {
            blocks: whole.len(),
        });
    }
    if still.len() < FEWEST_BLOCKS {
        return Err(Unmeasured::Moving {
            still: still.len(),
            blocks: whole.len(),
        });
    }
    Ok(Noise {
        quadrature_counts: noise_counts(&still, 0..2 * SEGMENTS),
        electrode_counts: noise_counts(&still, 2 * SEGMENTS..CHANNELS),
    })
}

/// Stretches of [`BLOCK`] readings without a gap.
fn blocks(readings: &[Reading], samples_apart: u32) -> impl Iterator<Item = &[Reading]> {
    readings
        .chunk_by(move |a, b| a.sequence.wrapping_add(samples_apart) == b.sequence)
        .flat_map(|run| run.chunks_exact(BLOCK))
}

/// No segment's position has a slope or a curvature that its scatter does not explain.
fn rests(block: &[Reading]) -> bool {
    (0..SEGMENTS).all(|segment| {
        let [moved, scattered] = parts(block, |reading| reading.position_turns[segment]);
        moved / 2.0 <= F_OF_REST * scattered / FREEDOM
    })
}

/// Sums of squares of a block: of slope and curvature, and of what remains beside a parabola.
fn parts(block: &[Reading], value: impl Fn(&Reading) -> f64) -> [f64; 2] {
    let first = block.first().map_or(0.0, &value);
    let values: Vec<f64> = block.iter().map(|reading| value(reading) - first).collect();
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let all: f64 = values.iter().map(|value| (value - mean).powi(2)).sum();
    let along =
        |shape: &[f64; BLOCK]| -> f64 { values.iter().zip(shape).map(|(v, s)| v * s).sum() };
    let moved = along(&SLOPE).powi(2) / SQUARES[0] + along(&CURVATURE).powi(2) / SQUARES[1];
    [moved, (all - moved).max(0.0)]
}

/// Noise of a kind of channels: the mean of their variances, each a median over the blocks, so that a burst of bad samples does not
/// count. A channel at the converter's end has no noise to show and is left out.
fn noise_counts(blocks: &[&[Reading]], channels: std::ops::Range<usize>) -> f64 {
    let variances: Vec<f64> = channels
        .filter(|channel| !is_clipped(blocks, *channel))
        .map(|channel| {
            let mut squares: Vec<f64> = blocks
                .iter()
                .map(|block| parts(block, |reading| reading.counts[channel])[1])
                .collect();
            let middle = squares.len() / 2;
            *squares.select_nth_unstable_by(middle, f64::total_cmp).1 / CHI_SQUARE_MEDIAN
        })
        .collect();
    let mean = variances.iter().sum::<f64>() / variances.len().max(1) as f64;
    (mean - ROUNDING_VARIANCE).max(0.0).sqrt()
}

/// Most of its readings are at the converter's end.
fn is_clipped(blocks: &[&[Reading]], channel: usize) -> bool {
    let at_end = blocks
        .iter()
        .flat_map(|block| block.iter())
        .filter(|reading| reading.counts[channel].abs() >= CONVERTER_END_COUNTS);
    2 * at_end.count() > BLOCK * blocks.len()
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, Normal};
    use std::f64::consts::TAU;

    const STATED: Noise = Noise {
        quadrature_counts: 20.0,
        electrode_counts: 2.0,
    };

    /// Half a second at 20 kHz of a courier whose segments have the sixth harmonic of a poor sensor and move by so many turns a
    /// sample, from somewhere.
    fn made(seed: u64, turns_a_sample: f64, count: u32) -> Vec<Reading> {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let [pair, electrode] = [STATED.quadrature_counts, STATED.electrode_counts]
            .map(|size| Normal::new(0.0, size).unwrap());
        let start: [f64; SEGMENTS] = std::array::from_fn(|s| 0.37 * seed as f64 + 0.11 * s as f64);
        let reading = |sequence: u32| {
            let mut counts = [0.0; CHANNELS];
            let mut position_turns = [0.0; SEGMENTS];
            for segment in 0..SEGMENTS {
                let turns = start[segment] + turns_a_sample * f64::from(sequence);
                let seen = turns + 0.01 * (6.0 * TAU * turns).sin();
                let (sine, cosine) = (TAU * seen).sin_cos();
                let [sine, cosine] =
                    [sine, cosine].map(|wave| (2.0e4 * wave + pair.sample(&mut rng)).round());
                counts[2 * segment] = sine;
                counts[2 * segment + 1] = cosine;
                let phase = sine.atan2(cosine) / TAU;
                position_turns[segment] = phase + (seen - phase).round();
            }
            for count in &mut counts[2 * SEGMENTS..] {
                *count = (1.5e4 + electrode.sample(&mut rng)).round();
            }
            Reading {
                sequence,
                counts,
                position_turns,
            }
        };
        (0..count).map(reading).collect()
    }

    fn assert_near(found: Noise, what: &str) {
        let ratios = [
            found.quadrature_counts / STATED.quadrature_counts,
            found.electrode_counts / STATED.electrode_counts,
        ];
        assert!((ratios[0] - 1.0).abs() < 0.02, "{what}: {ratios:?}");
        assert!((ratios[1] - 1.0).abs() < 0.03, "{what}: {ratios:?}");
    }

    #[test]
    fn noise_at_rest_is_what_was_put_in() {
        let mut sum = 0.0;
        for seed in 0..20 {
            let found = measure(&made(seed, 0.0, 10_000), 1).unwrap();
            assert_near(found, &format!("seed {seed}"));
            sum += found.quadrature_counts;
        }
        let mean = sum / 20.0 / STATED.quadrature_counts;
        assert!((mean - 1.0).abs() < 0.003, "biased: {mean}");
    }

    /// The resting part is found by itself, and nothing is told of a courier that never rests, however fast it goes.
    #[test]
    fn a_moving_courier_shows_no_noise() {
        for turns_a_sample in [0.002, 0.01, 0.07, 0.2, 0.5] {
            let mut readings = made(3, turns_a_sample, 6000);
            let refused = measure(&readings, 1).unwrap_err();
            assert!(
                matches!(refused, Unmeasured::Moving { still, .. } if still < 20),
                "{turns_a_sample}: {refused}"
            );
            let rest = made(4, 0.0, 4000).into_iter().map(|reading| Reading {
                sequence: reading.sequence + 6000,
                ..reading
            });
            readings.extend(rest);
            assert_near(measure(&readings, 1).unwrap(), &turns_a_sample.to_string());
        }
    }

    #[test]
    fn gaps_bursts_and_a_clipped_channel_do_not_count() {
        let mut readings = made(5, 0.0, 10_000);
        for reading in readings.iter_mut().step_by(97) {
            reading.counts[3] += 3000.0;
            reading.counts[0] = 32_767.0;
        }
        readings
            .iter_mut()
            .for_each(|reading| reading.counts[6] = 32_767.0);
        readings.retain(|reading| reading.sequence % 50 != 0);
        assert_near(measure(&readings, 1).unwrap(), "gaps");
        let sparse: Vec<Reading> = readings.into_iter().step_by(2).collect();
        assert_eq!(
            measure(&sparse, 1).unwrap_err(),
            Unmeasured::Gaps { blocks: 0 }
        );
    }
}
