//! What can go wrong with a beacon and the light around it, as effects on the electrodes.
//!
//! Two spots on the diode give the sum of their currents: its output is their centroid.

use crate::coordination::electrodes;
use effects::plant::{Channels, Instant, PlantEffect};

/// Time for which all is well after the beacon came in view, s: a session has begun by then.
const WELL_S: f64 = 2.0;
/// Half period of a beacon that comes and goes, s.
const BLINK_S: f64 = 0.5;
/// Where a second beacon stands from the first, platen frame, metres.
const SECOND_M: [f64; 2] = [1.5e-3, -1.0e-3];
/// Stray light on one electrode, over a beacon's sum.
const STRAY_SHARE: f64 = 0.8;

/// A fault.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum BeaconFault {
    /// The beacon comes and goes, twice a second.
    Blinks,
    /// A second beacon, half as bright as the first, is switched on.
    Second,
    /// It is there from the start, and a quarter as bright.
    SecondFromStart,
    /// Stray light drives an electrode to the converter's end.
    StrayLight,
}

/// The fault as an effect of a courier.
#[derive(Clone, Copy, Debug)]
pub struct FaultyBeacon {
    fault: BeaconFault,
    seen_s: Option<f64>,
}

impl FaultyBeacon {
    /// Acts some time after the beacon came in view.
    #[must_use]
    pub fn new(fault: BeaconFault) -> Self {
        Self {
            fault,
            seen_s: None,
        }
    }
}

impl PlantEffect for FaultyBeacon {
    /// A fault has one size.
    fn scale(&mut self, _factor: f64) {}

    fn analog(&mut self, at: &Instant, channels: &mut Channels) {
        let sum_counts = channels.psd_sum_counts;
        if sum_counts == 0.0 {
            return;
        }
        let seen_s = at.time_s - *self.seen_s.get_or_insert(at.time_s);
        match self.fault {
            BeaconFault::SecondFromStart => add_second(at, channels, 0.25),
            _ if seen_s < WELL_S => {}
            BeaconFault::Blinks => {
                if (seen_s / BLINK_S) as u64 % 2 == 0 {
                    channels.electrodes = [0.0; 4];
                }
            }
            BeaconFault::Second => add_second(at, channels, 0.5),
            BeaconFault::StrayLight => channels.electrodes[0] += STRAY_SHARE * sum_counts,
        }
    }
}

/// Adds the currents of a second spot of this brightness over the first's; none if it is beside the diode.
fn add_second(at: &Instant, channels: &mut Channels, brightness: f64) {
    let [xp, xn, yp, yn] = channels.electrodes;
    let first = [(xp - xn) / (xp + xn), (yp - yn) / (yp + yn)];
    let (sine, cosine) = at.pose.theta_rad.sin_cos();
    let aside_m = [
        cosine * SECOND_M[0] + sine * SECOND_M[1],
        cosine * SECOND_M[1] - sine * SECOND_M[0],
    ];
    let scale_m = at.geometry.height_m * at.geometry.tan_full_scale;
    let second = [0, 1].map(|axis| first[axis] - aside_m[axis] / scale_m);
    if second.iter().all(|u| u.abs() <= 1.0) {
        let more = electrodes(second, brightness * channels.psd_sum_counts);
        for (current, more) in channels.electrodes.iter_mut().zip(more) {
            *current += more;
        }
    }
}
