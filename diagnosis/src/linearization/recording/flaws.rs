//! A pair's vector (sine, cosine) without flaws that are known: offset of sine and of cosine, gain of the sine less one and quadrature
//! angle (rad).

use super::LinearizedRecording;
use crate::data::clip::{Figure, Rails, at_rails};

impl LinearizedRecording<'_> {
    /// A sample's vector over the pair's mean amplitude, without a wander as far as it is known.
    pub(super) fn without(&self, segment: usize, i: usize, flaws: [f64; 4]) -> [f64; 2] {
        without(self.over_mean(segment, i), flaws)
    }

    fn over_mean(&self, segment: usize, i: usize) -> [f64; 2] {
        let mean = self.mean(segment);
        self.observations.pair_counts[segment][i].map(|counts| counts / mean)
    }

    fn mean(&self, segment: usize) -> f64 {
        let mean = self.normal.ln_amplitude[segment].first();
        mean.copied().unwrap_or(0.0).exp()
    }

    /// Angle, rad, by which the wander turns a sample's vector; zero where no wander is known. A channel that stands at a rail stays
    /// there: its wave, which the other channel tells, is cut again without the wander.
    pub(super) fn pair_turn_rad(&self, segment: usize, i: usize) -> f64 {
        let Some(flaws) = self.amplitudes.pair_course[segment].get(i) else {
            return 0.0;
        };
        let read = self.over_mean(segment, i);
        let mut clean = without(read, *flaws);
        if let Some(cut) = &self.observations.cut_figures[segment] {
            let mean = self.mean(segment);
            let at_rails = at_rails(self.observations, segment, i);
            let whole = whole(&cut.figure, clean.map(|v| mean * v), at_rails);
            clean = between(&cut.rails_counts, whole).map(|counts| counts / mean);
        }
        let ([s, c], [sine, cosine]) = (read, clean);
        (s * cosine - c * sine).atan2(s * sine + c * cosine)
    }

    /// Half of the quadrature angle's wander, rad; zero where no wander is known.
    pub(super) fn half_quadrature_angle_rad(&self, segment: usize, i: usize) -> f64 {
        let flaws = self.amplitudes.pair_course[segment].get(i);
        flaws.map_or(0.0, |flaws| 0.5 * flaws[3])
    }
}

/// A vector, counts, of which one channel may stand at a rail: there the figure's point by the other channel.
fn whole(figure: &Figure, [sine, cosine]: [f64; 2], at_rails: [bool; 2]) -> [f64; 2] {
    match at_rails {
        [true, false] => figure.at_cosine(cosine, sine),
        [false, true] => figure.at_sine(sine, cosine),
        _ => [sine, cosine],
    }
}

/// A vector, counts, between rails.
fn between(rails: &Rails, vector: [f64; 2]) -> [f64; 2] {
    std::array::from_fn(|channel| {
        let [lower, upper] = rails[channel];
        let value = vector[channel];
        let value = upper.map_or(value, |upper| value.min(upper));
        lower.map_or(value, |lower| value.max(lower))
    })
}

/// A vector without flaws: offset of sine and of cosine, gain of the sine less one and quadrature angle (rad).
fn without([sine, cosine]: [f64; 2], flaws: [f64; 4]) -> [f64; 2] {
    let [sine_offset, cosine_offset, gain, angle] = flaws;
    let sine = (sine - sine_offset) / (1.0 + 0.5 * gain);
    let cosine = (cosine - cosine_offset) / (1.0 - 0.5 * gain);
    // Half of the angle in either channel: the amplitude does not tell which of the two turns.
    let (half, rest) = (0.5 * angle, 1.0 - 0.25 * angle * angle);
    [(sine - half * cosine) / rest, (cosine - half * sine) / rest]
}
