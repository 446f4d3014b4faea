//! The coefficients of a stored calibration as unknowns.

use crate::estimate::{Unknown, Wave};
use courier_sensor::calibration::record::Calibration;
use courier_sensor::frame::SEGMENTS;

/// Every coefficient of the error model but the constants.
pub fn coefficients(calibration: &Calibration) -> (Vec<Unknown>, Vec<f64>) {
    let mut list = Vec::new();
    for (term, rows) in calibration
        .model
        .terms
        .iter()
        .zip(&calibration.model.coefficients)
    {
        for segment in 0..SEGMENTS {
            for part in usize::from(!term.periodic())..2 {
                let wave = Wave {
                    segment,
                    term: *term,
                    cosine: part == 1,
                    share: 1.0,
                };
                list.push((Unknown::of_wave(wave), f64::from(rows[segment][part])));
            }
        }
    }
    list.into_iter().unzip()
}
