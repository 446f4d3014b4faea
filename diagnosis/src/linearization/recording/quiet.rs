//! Where a segment does not move, its reading's own noise is not its place: a shape evaluated at the reading would follow the
//! noise and seem to explain it.

use super::LinearizedRecording;

/// Neighbours on either side that a resting segment's place is the mean of. Derived from that mean: of fifty it is known to 0.14
/// of a reading's noise, which then is no part of what a column is formed of.
const REST_HALF_WINDOW: usize = 25;

impl LinearizedRecording<'_> {
    /// What leads from each segment's reading to its place by the neighbours, m; zero in motion and at separate poses.
    pub(super) fn quiet(&self) -> [Vec<f64>; 4] {
        std::array::from_fn(|s| {
            let position = &self.observations.position_m[s];
            if !self.scope.segments[s] {
                return Vec::new();
            }
            let mut out = vec![0.0; position.len()];
            let mut start = 0;
            while start < position.len() {
                let end = self.rest_ends(s, start);
                smooth(&position[start..end], &mut out[start..end]);
                start = end.max(start + 1);
            }
            out
        })
    }

    /// True if a segment's place is that of its neighbours and not its own reading's.
    pub fn is_quiet(&self, segment: usize, i: usize) -> bool {
        self.quiet_m[segment].get(i).is_some_and(|q| *q != 0.0)
    }

    /// End of the rest that begins at a sample: without a break, smooth and without clear speed.
    fn rest_ends(&self, s: usize, start: usize) -> usize {
        let rests = |i: &usize| {
            self.motion.smooth[*i]
                && self.motion.speed_m_s[s][*i] == 0.0
                && self.observations.position_m[s][*i].is_finite()
                && self.observations.unbroken[*i] == self.observations.unbroken[start]
        };
        (start..self.len())
            .find(|i| !rests(i))
            .unwrap_or(self.len())
    }
}

/// Mean over the neighbours less the value; windows shrink evenly towards the ends.
fn smooth(value: &[f64], out: &mut [f64]) {
    let first = value.first().copied().unwrap_or(0.0);
    let mut sums = vec![0.0; value.len() + 1];
    for (i, v) in value.iter().enumerate() {
        sums[i + 1] = sums[i] + (v - first);
    }
    for i in 0..value.len() {
        let half = REST_HALF_WINDOW.min(i).min(value.len() - 1 - i);
        let (low, high) = (i - half, i + half + 1);
        out[i] = first + (sums[high] - sums[low]) / (high - low) as f64 - value[i];
    }
}
