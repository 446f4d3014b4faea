//! A pair's vector (sine, cosine) without flaws that are known: offset of sine and of cosine, gain of the sine less one and quadrature
//! angle (rad).

use super::LinearizedRecording;

impl LinearizedRecording<'_> {
    /// A sample's vector over the pair's mean amplitude, without a wander as far as it is known.
    pub(super) fn without(&self, segment: usize, i: usize, flaws: [f64; 4]) -> [f64; 2] {
        let [sine, cosine] = self.over_mean(segment, i);
        let [sine_offset, cosine_offset, gain, angle] = flaws;
        let sine = (sine - sine_offset) / (1.0 + 0.5 * gain);
        let cosine = (cosine - cosine_offset) / (1.0 - 0.5 * gain);
        // Half of the angle in either channel: the amplitude does not tell which of the two turns.
        let (half, rest) = (0.5 * angle, 1.0 - 0.25 * angle * angle);
        [(sine - half * cosine) / rest, (cosine - half * sine) / rest]
    }

    fn over_mean(&self, segment: usize, i: usize) -> [f64; 2] {
        let mean = self.normal.ln_amplitude[segment].first();
        let mean = mean.copied().unwrap_or(0.0).exp();
        self.observations.pair_counts[segment][i].map(|counts| counts / mean)
    }

    /// Angle, rad, by which the wander turns a sample's vector; zero where no wander is known.
    pub(super) fn pair_turn_rad(&self, segment: usize, i: usize) -> f64 {
        let Some(flaws) = self.amplitudes.pair_course[segment].get(i) else {
            return 0.0;
        };
        let ([s, c], [sine, cosine]) =
            (self.over_mean(segment, i), self.without(segment, i, *flaws));
        (s * cosine - c * sine).atan2(s * sine + c * cosine)
    }

    /// Half of the quadrature angle's wander, rad; zero where no wander is known.
    pub(super) fn half_quadrature_angle_rad(&self, segment: usize, i: usize) -> f64 {
        let flaws = self.amplitudes.pair_course[segment].get(i);
        flaws.map_or(0.0, |flaws| 0.5 * flaws[3])
    }
}
