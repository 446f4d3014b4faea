//! Lines in one quadrature pair: what hums in a channel changes the phase times its sine or cosine, and the amplitude with it.

use crate::linearization::recording::LinearizedRecording;
use crate::spectra::lines::{Series, lines_hz};

/// Variance of an amplitude over its noise from which on it is looked at. Derived from chi-square: of 200 samples
/// (`MINIMUM_SAMPLES`) a variance is known to 10 %, so that this is three deviations.
const HUM_RATIO: f64 = 1.3;

/// Frequencies, Hz, that hum in the sine or the cosine of a segment, strongest first. Cost: see [`lines_hz`].
pub fn hum_hz(linearized: &LinearizedRecording, segment: usize) -> Vec<f64> {
    let o = linearized.observations;
    let left = linearized.amplitude_left(segment);
    let of = |channel: usize| -> (Vec<f64>, Vec<f64>, Vec<usize>) {
        let mut out = (Vec::new(), Vec::new(), Vec::new());
        for &(i, value) in &left {
            let pair = o.pair_counts[segment][i];
            out.0.push(o.t_s[i] - o.t_s[0]);
            out.1
                .push(value * pair[channel] / pair[0].hypot(pair[1]).max(1.0));
            out.2.push(o.stretch[i]);
        }
        out
    };
    if crate::algebra::statistics::rms(left.iter().map(|l| l.1)) < HUM_RATIO.sqrt() {
        return Vec::new();
    }
    let data = [of(0), of(1)];
    let series = |d: &(Vec<f64>, Vec<f64>, Vec<usize>)| d.1.clone();
    let mut list = [0, 1].map(|k| Series {
        t_s: &data[k].0,
        value: series(&data[k]),
        stretch: &data[k].2,
    });
    lines_hz(&mut list)
}
