//! Lines in what the spot's deflection is multiplied by: a lamp beside the beacon flickers, and the diode's sum with it.

use crate::algebra::statistics::rms;
use crate::inference::residuals::Residuals;
use crate::linearization::recording::LinearizedRecording;
use crate::spectra::lines::{Series, lines_hz, subtract};

/// Samples under a beacon from which on it is looked at. Derived from chi-square: a variance of fifty is known to 20 %.
const FEWEST_FLICKER_SAMPLES: usize = 50;

/// Frequencies, Hz, at which the residuals of g_x and g_y swing in proportion to their deflection, strongest first. Lines that are
/// known to be there without it are taken out before; whatever the level, it is taken to be of unit rms. Cost: see [`lines_hz`].
pub fn flicker_hz(linearized: &LinearizedRecording, residuals: &Residuals) -> Vec<f64> {
    let o = linearized.observations;
    let data = [0, 1].map(|axis: usize| {
        let of_it = (0..residuals.sample.len()).filter(|k| residuals.channel[*k] == 1 + axis);
        let sees = of_it.filter(|k| o.sees_beacon(residuals.sample[*k]));
        let list: Vec<usize> = sees.collect();
        let times = list.iter().map(|k| o.t_s[residuals.sample[*k]] - o.t_s[0]);
        let stretch = list.iter().map(|k| o.stretch[residuals.sample[*k]]);
        (
            times.collect::<Vec<f64>>(),
            stretch.collect::<Vec<usize>>(),
            list,
        )
    });
    if data.iter().any(|d| d.0.len() < FEWEST_FLICKER_SAMPLES) {
        return Vec::new();
    }
    let mut list = [0, 1].map(|axis: usize| {
        let (t_s, stretch, rows) = &data[axis];
        let value = rows.iter().map(|k| residuals.white[*k]).collect();
        let mut one = Series {
            t_s,
            value,
            stretch,
        };
        for hz in &linearized.inputs.beacon_lines_hz {
            subtract(&mut one, *hz);
        }
        for (value, k) in one.value.iter_mut().zip(rows) {
            *value *= o.tan_psi[axis][residuals.sample[*k]];
        }
        let level = rms(one.value.iter().copied()).max(1e-30);
        one.value.iter_mut().for_each(|v| *v /= level);
        one
    });
    lines_hz(&mut list)
}
