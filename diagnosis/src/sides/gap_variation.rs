//! the air gap changes over the platen or with tilt: the amplitude with it, and the error with both.
// --- sensor side: the amplitude, and where it is not known the place, times harmonics ---

use effects::sensor::{Moment, Regressor, SensorEffect, Survey};

/// Sensor side: low orders of the own phase that grow with the logarithm of the amplitude.
pub struct GapModel;

impl SensorEffect for GapModel {
    fn name(&self) -> &'static str {
        "gap_variation"
    }

    fn sentence(&self) -> &'static str {
        "the air gap changes over the platen or with tilt: the amplitude with it, and the error with both"
    }

    fn telling_motion(&self) -> &'static str {
        "fly-bys over the whole platen with raw counts, so that the amplitude is seen beside the error"
    }

    fn regressors(&self, survey: &Survey) -> Vec<Regressor> {
        let mut list = Vec::new();
        for s in (0..4).filter(|s| survey.segments[*s]) {
            let mut family = |label: &str, unit, size_m: f64, factor: fn(&Moment, usize) -> f64| {
                let name = format!("{label}offset, segment {}", s + 1);
                list.push(Regressor::reading(name, unit, size_m, s, move |m| {
                    factor(m, s)
                }));
                for order in [1, 2, 4, 6] {
                    Regressor::harmonic(&mut list, s, order, (label, unit, size_m), move |m| {
                        factor(m, s)
                    });
                }
            };
            if survey.counts {
                family("amplitude times ", "m", 2.0e-6, |m, s| m.ln_amplitude[s]);
            } else if survey.travel_m[s] > 3.0 * survey.pitch_m {
                family("place along times ", "1", 1.5e-6, |m, s| m.place_m[s][0]);
                family("place across times ", "1", 1.5e-6, |m, s| m.place_m[s][1]);
            }
        }
        list
    }
}
