//! Readings of a pair whose amplitude is gone: they tell no place, however its noise is weighed.
//!
//! Offsets stay as they are where the amplitude falls, so that the error of equation (3) grows as one over it.

use crate::algebra::statistics::median;
use crate::data::observations::Observations;
use serde::{Deserialize, Serialize};
use std::f64::consts::TAU;

/// Below this share of its usual amplitude a pair tells no place: offsets of one to two hundredths, as pairs have them before they are
/// calibrated (paper, 3.1.2), are then an error of 0.1 to 0.2 rad.
const FAINT: f64 = 0.1;
/// Fewer samples are a disturbance, which is looked for elsewhere. A prior: bursts of 1 to 20 ms are drawn
/// (`effects/src/outlier_bursts.rs`), 20 samples of a millisecond at the most.
const HOLDS: usize = 20;

/// Samples of a segment whose amplitude is gone, so that they tell no place.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct WithoutSignal {
    /// The segment, 1 to 4.
    pub segment: usize,
    /// How many samples.
    pub samples: usize,
    /// Least and largest of its positions there, m.
    pub place_m: [f64; 2],
}

/// Leaves the outputs aside where their amplitude is gone; what was left aside of each segment, with a line that tells it.
pub fn leave_aside(o: &mut Observations) -> Vec<(WithoutSignal, String)> {
    (0..4)
        .filter_map(|segment| of_segment(o, segment))
        .collect()
}

fn of_segment(o: &mut Observations, segment: usize) -> Option<(WithoutSignal, String)> {
    let amplitudes = &o.amplitude_counts[segment];
    let mut known: Vec<f64> = amplitudes
        .iter()
        .copied()
        .filter(|a| a.is_finite())
        .collect();
    let usual = median(&mut known)?;
    let faint: Vec<usize> = (0..amplitudes.len())
        .filter(|&i| amplitudes[i] < FAINT * usual)
        .collect();
    if faint.len() < HOLDS {
        return None;
    }
    let position = &o.position_m[segment];
    let ends = |rows: &mut dyn Iterator<Item = f64>| {
        rows.filter(|p| p.is_finite())
            .fold([f64::INFINITY, f64::NEG_INFINITY], |[a, b], p| {
                [a.min(p), b.max(p)]
            })
    };
    let place_m = ends(&mut faint.iter().map(|&i| position[i]));
    let [from, to] = place_m.map(|p| 1e3 * p);
    let [first, last] = ends(&mut position.iter().copied()).map(|p| 1e3 * p);
    let noise_rad = o.pair_noise_counts / (FAINT * usual);
    let noise_um = 1e6 * noise_rad * o.pitch_m / TAU;
    let told = format!(
        "segment {}: its amplitude is below {:.0} % of its usual {usual:.0} counts in {} of {} samples, from {from:.2} to {to:.2} mm of a way from {first:.2} to {last:.2} mm, where noise alone is {noise_um:.2} µm or more: left out",
        segment + 1,
        100.0 * FAINT,
        faint.len(),
        amplitudes.len()
    );
    let without = WithoutSignal {
        segment: segment + 1,
        samples: faint.len(),
        place_m,
    };
    for i in faint {
        o.position_m[segment][i] = f64::NAN;
        o.position_noise_m[segment][i] = f64::NAN;
        o.amplitude_counts[segment][i] = f64::NAN;
        o.pair_counts[segment][i] = [f64::NAN; 2];
    }
    Some((without, told))
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::motion::Pose;
    use effects::plant::Geometry;
    use hal_sim::courier::Courier;
    use hal_sim::presets::ideal;
    use hal_sim::trajectory::{OpenLoop, Plan};

    #[test]
    fn where_an_amplitude_is_gone_it_is_located_and_left_aside() {
        let ends = [Pose::new(0.0, -5.0e-3, 0.0), Pose::new(0.0, 5.0e-3, 0.0)];
        let plan = Plan::new(Pose::default(), Geometry::PAPER, OpenLoop::EXACT, 5);
        let plan = plan.sweep_both_ways("y", ends, 0.05);
        let mut courier = Courier::new(ideal(5), 5).unwrap();
        let recording = hal_sim::record::record(&mut courier, &plan, false);
        let mut o = Observations::new(&recording).unwrap();
        assert_eq!(leave_aside(&mut o), []);
        for i in 0..o.len() {
            if o.position_m[1][i] > 4.0e-3 {
                o.amplitude_counts[1][i] *= 0.05;
            }
        }
        let told = leave_aside(&mut o);
        assert_eq!(told.len(), 1, "{told:?}");
        let (without, line) = &told[0];
        assert!(
            line.starts_with("segment 2") && line.contains("from 4.0"),
            "{line}"
        );
        assert_eq!(without.segment, 2);
        assert!(without.place_m[0] > 4.0e-3, "{without:?}");
        let left = o.position_m[1].iter().copied().filter(|p| p.is_finite());
        assert!(left.fold(0.0, f64::max) <= 4.0e-3);
    }
}
