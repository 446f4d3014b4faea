//! Sine and cosine of one segment: centred where a converter without sign read them, and scaled to whole counts.

use std::f64::consts::TAU;

/// A pair as whole counts, and what was done to make them so.
#[derive(Clone, Debug, PartialEq)]
pub struct Pair {
    /// `[sine, cosine]` of each sample, whole counts; NaN where not measured.
    pub counts: [Vec<f64>; 2],
    /// Taken off both channels before scaling, in the log's unit after its arithmetic.
    pub centre: [f64; 2],
    /// Counts per unit of the log; 1 where the log has whole counts.
    pub scale: f64,
    /// Median distance from the centre, counts.
    pub amplitude_counts: f64,
    /// Spread of that distance over the median: a circle has little.
    pub roundness: f64,
    /// Steps of the phase between samples, as a path in pitches by the shorter way; NaN where not measured.
    pub phase_turns: Vec<f64>,
}

/// What is known of the converter.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Converter {
    /// Its bits, where stated.
    pub bits: Option<u32>,
    /// The input at its full scale, where stated, in the log's unit after its arithmetic and conversion.
    pub full_scale: Option<f64>,
}

/// Bits that are assumed where none are stated: what the firmware's signal path reads.
pub const USUAL_BITS: u32 = 16;
/// Values that are no counts are scaled so that the largest is at this share of full scale: some room, as a converter's user leaves.
const SHARE_OF_FULL_SCALE: f64 = 0.9;
/// Rounding adds 1/12 of a squared count. Beside noise of three counts that is 0.5 % of its rms.
pub const NOISE_COUNTS_WANTED: f64 = 3.0;
/// Most bits that values which are no counts are scaled to: what a double-precision log may tell and a spreadsheet still shows.
const MOST_BITS: u32 = 24;

/// Centre of the circle that the samples lie on, by Kasa's least squares (I. Kasa, "A curve fitting procedure and its error
/// analysis", IEEE Trans. Instrum. Meas. 25, 1976): exact on any arc; none of fewer than three places that are no line.
#[must_use]
pub fn circle([sine, cosine]: [&[f64]; 2]) -> Option<([f64; 2], f64)> {
    let measured = || {
        sine.iter()
            .zip(cosine)
            .filter(|(s, c)| s.is_finite() && c.is_finite())
    };
    let count = measured().count() as f64;
    let mean = measured().fold([0.0; 2], |[s, c], (x, y)| [s + x / count, c + y / count]);
    // Moments about the mean; the circle's equation u a + v b = (u² + v²) / 2 - const.
    let (mut uu, mut uv, mut vv, mut uz, mut vz, mut zz) = (0.0, 0.0, 0.0, 0.0, 0.0, 0.0);
    for (x, y) in measured() {
        let (u, v) = (x - mean[0], y - mean[1]);
        let z = u * u + v * v;
        uu += u * u / count;
        uv += u * v / count;
        vv += v * v / count;
        uz += 0.5 * u * z / count;
        vz += 0.5 * v * z / count;
        zz += z / count;
    }
    let determinant = uu * vv - uv * uv;
    /// Of a line, or a single place, rounding leaves less than this share.
    const DEGENERATE: f64 = 1.0e-12;
    if !(determinant > DEGENERATE * (uu + vv) * (uu + vv)) {
        return None;
    }
    let (a, b) = (
        (uz * vv - vz * uv) / determinant,
        (vz * uu - uz * uv) / determinant,
    );
    Some(([mean[0] + a, mean[1] + b], (zz + a * a + b * b).sqrt()))
}

/// Whether a pair's circle leaves out its origin: a converter without sign read it, or an amplifier about half its supply.
#[must_use]
pub fn off_centre(pair: [&[f64]; 2]) -> Option<[f64; 2]> {
    let (centre, radius) = circle(pair)?;
    (centre[0].hypot(centre[1]) > radius).then_some(centre)
}

/// True if every value is a whole number.
#[must_use]
pub fn whole(channels: [&[f64]; 2]) -> bool {
    channels.iter().all(|channel| {
        channel
            .iter()
            .all(|value| value.is_nan() || value.fract() == 0.0)
    })
}

/// Bits and counts per unit of values that are no counts. `noise` is theirs, in their unit; 0 where it is not known.
#[must_use]
pub fn scaling(largest: f64, noise: f64, converter: Converter) -> (u32, f64) {
    let full_scale = converter
        .full_scale
        .unwrap_or(largest / SHARE_OF_FULL_SCALE);
    let counts = |bits: u32| 2f64.powi(bits as i32 - 1) / full_scale;
    if let Some(bits) = converter.bits {
        return (bits, counts(bits));
    }
    let enough = |bits: &u32| noise <= 0.0 || noise * counts(*bits) >= NOISE_COUNTS_WANTED;
    let bits = (USUAL_BITS..=MOST_BITS).find(enough).unwrap_or(MOST_BITS);
    (bits, counts(bits))
}

/// Fewest bits of a usual converter, of 16 and more, that hold such counts.
#[must_use]
pub fn bits_for(largest: f64) -> u32 {
    /// Converters that are built.
    const BUILT: [u32; 4] = [USUAL_BITS, 18, 24, 32];
    let holds = |bits: &u32| largest <= 2f64.powi(*bits as i32 - 1) - 1.0;
    BUILT.into_iter().find(holds).unwrap_or(32)
}

impl Pair {
    /// A pair of `values` less `centre`, times `scale`, in whole counts.
    #[must_use]
    pub fn new(values: [&[f64]; 2], centre: [f64; 2], scale: f64) -> Self {
        let counts = [0, 1].map(|k: usize| -> Vec<f64> {
            values[k]
                .iter()
                .map(|value| ((value - centre[k]) * scale).round())
                .collect()
        });
        let mut radii: Vec<f64> = (0..counts[0].len())
            .map(|i| counts[0][i].hypot(counts[1][i]))
            .filter(|r| r.is_finite())
            .collect();
        radii.sort_by(f64::total_cmp);
        let at = |share: f64| {
            radii
                .get((share * radii.len() as f64) as usize)
                .copied()
                .unwrap_or(0.0)
        };
        let amplitude_counts = at(0.5);
        let phase = |i: usize| counts[0][i].atan2(counts[1][i]) / TAU;
        Self {
            phase_turns: (0..counts[0].len()).map(phase).collect(),
            // A Gaussian's middle two thirds are two deviations wide.
            roundness: 0.5 * (at(5.0 / 6.0) - at(1.0 / 6.0)) / amplitude_counts.max(1.0),
            counts,
            centre,
            scale,
            amplitude_counts,
        }
    }

    /// Distance from the centre and way along the circle, counts: noise is the same in both, and a motion moves neither but evenly.
    #[must_use]
    pub fn polar(&self, turns: &[f64]) -> [Vec<f64>; 2] {
        let radius = (0..turns.len())
            .map(|i| self.counts[0][i].hypot(self.counts[1][i]))
            .collect();
        let way = turns
            .iter()
            .map(|turns| turns * TAU * self.amplitude_counts)
            .collect();
        [radius, way]
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn arc(from: f64, to: f64, centre: [f64; 2], radius: f64) -> [Vec<f64>; 2] {
        let angle = |k: i32| from + (to - from) * f64::from(k) / 200.0;
        [
            (0..=200)
                .map(|k| centre[0] + radius * angle(k).sin())
                .collect(),
            (0..=200)
                .map(|k| centre[1] + radius * angle(k).cos())
                .collect(),
        ]
    }

    #[test]
    fn a_converter_without_sign_is_seen_and_a_short_way_is_not_taken_for_one() {
        let of = |[s, c]: [Vec<f64>; 2]| off_centre([&s, &c]);
        let centre = of(arc(0.0, 40.0, [2048.0, 2040.0], 1500.0)).unwrap();
        assert!(
            (centre[0] - 2048.0).hypot(centre[1] - 2040.0) < 20.0,
            "{centre:?}"
        );
        assert_eq!(of(arc(0.2, 1.3, [10.0, -20.0], 1500.0)), None);
        assert_eq!(of(arc(0.0, 40.0, [100.0, 50.0], 1500.0)), None);
        assert_eq!(of([vec![1.0; 5], vec![2.0; 5]]), None);
    }

    #[test]
    fn volts_become_counts_finer_than_their_noise() {
        let (bits, counts) = scaling(1.8, 1.0e-3, Converter::default());
        assert!(bits == 16 && (1.8 * counts / 32_768.0 - 0.9).abs() < 1e-9);
        let (bits, counts) = scaling(1.8, 1.0e-5, Converter::default());
        assert!(
            bits == 21 && 1.0e-5 * counts >= NOISE_COUNTS_WANTED,
            "{bits}"
        );
        assert_eq!(
            scaling(
                1.8,
                1.0e-3,
                Converter {
                    bits: Some(12),
                    full_scale: Some(2.5)
                }
            ),
            (12, 2048.0 / 2.5)
        );
        assert_eq!([32_767.0, 40_000.0, 4.0e6].map(bits_for), [16, 18, 24]);
    }
}
