//! Offsets of a pair's channels that change with the place, as a stray field does: smooth functions of where the segment is.

use super::sample::Sample;
use super::wander::FLAW_SIZE;
use effects::basis::legendre;

/// Highest degree over the places. As was measured on 2,000 sources as `effects::stray_field` draws them, at 40 to 80 mm: five
/// leave 0.7 % of the field over ±30 mm in the median, and 2.6 % or less of 95 in 100.
const OFFSET_DEGREE: usize = 5;
/// Degrees along and across whose sum is at most [`OFFSET_DEGREE`]; of each an offset of the sine and one of the cosine.
pub(super) const COLUMNS: usize = (OFFSET_DEGREE + 1) * (OFFSET_DEGREE + 2);
/// The first of them are the same everywhere. By definition those of degree 0: one of the sine and one of the cosine.
pub(super) const SAME_EVERYWHERE: usize = 2;
/// Least range along either direction over which an offset is asked for, m. A prior: a source is further away than a courier is
/// high, some 30 mm, and changes by a sixth over less.
const LEAST_RANGE_M: f64 = 5.0e-3;

/// Middle and half range of a segment's places along and across.
#[derive(Clone, Copy, Debug)]
pub(super) struct Places {
    middle_m: [f64; 2],
    half_m: [f64; 2],
}

impl Places {
    /// Of some samples; none where they lie too close together.
    pub(super) fn of(samples: &[Sample]) -> Option<Self> {
        let range =
            |d: usize| super::range(&samples.iter().map(|s| s.place_m[d]).collect::<Vec<_>>());
        let [along, across] = [range(0)?, range(1)?];
        let ranges = [along, across];
        let wide = ranges.iter().any(|[from, to]| to - from > LEAST_RANGE_M);
        wide.then(|| Self {
            middle_m: ranges.map(|[from, to]| 0.5 * (from + to)),
            half_m: ranges.map(|[from, to]| (0.5 * (to - from)).max(0.5 * LEAST_RANGE_M)),
        })
    }

    /// Columns from the first on and their entries: what a unit of each adds to the logarithm of the amplitude.
    pub(super) fn entries(&self, sample: &Sample, first: usize) -> Vec<(usize, f64)> {
        let [u, v] = [0, 1].map(|d| (sample.place_m[d] - self.middle_m[d]) / self.half_m[d]);
        let [_, (sine, cosine), ..] = sample.phase;
        let degrees =
            (0..=OFFSET_DEGREE).flat_map(|sum| (0..=sum).map(move |along| (along, sum - along)));
        let both = degrees.flat_map(|(along, across)| {
            let shape = FLAW_SIZE * legendre(along, u) * legendre(across, v);
            [shape * sine, shape * cosine]
        });
        (first..).zip(both).collect()
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn there_is_a_column_for_each_degree_and_channel() {
        let at = |along: f64, across: f64| Sample::at([along, across], 0.7);
        let samples = [at(-0.02, -0.01), at(0.02, 0.01)];
        let places = Places::of(&samples).expect("far apart");
        let entries = places.entries(&at(0.02, 0.0), 7);
        assert_eq!(entries.len(), COLUMNS);
        assert_eq!(entries.last().map(|e| e.0), Some(7 + COLUMNS - 1));
        assert!((entries[0].1 - FLAW_SIZE * 0.7_f64.sin()).abs() < 1e-12);
        assert!(Places::of(&[at(0.0, 0.0), at(1e-3, 1e-3)]).is_none());
    }
}
