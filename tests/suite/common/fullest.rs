//! The largest calibration that a record and a link's frame must hold.

use courier_sensor::calibration::record::{Beacon, Calibration, Instant, Poses};
use courier_sensor::calibration::{Plan, Range, Sample};
use courier_sensor::geometry::Geometry;
use courier_sensor::model::{ErrorModel, Term, TermTable};

/// Every list is full, every number as long as can be.
pub fn fullest() -> Calibration {
    let mut calibration = Calibration::identity(Geometry::PAPER);
    let mut table = TermTable::default();
    for (own, lateral) in (1..=16).flat_map(|own| (-4..=4).map(move |lateral| (own, lateral))) {
        let _ = table.push(Term {
            own_order: own,
            lateral_order: lateral,
            ..Term::default()
        });
    }
    calibration.model = ErrorModel::zero(table);
    calibration
        .model
        .coefficients
        .iter_mut()
        .flatten()
        .flatten()
        .for_each(|k| *k = 999.0);
    calibration.made = Instant {
        unix_s: Some(u64::MAX),
        uptime_s: u32::MAX,
    };
    calibration.beacon = Some(Beacon {
        origin_teeth: [i32::MAX; 2],
        origin_m: [1.0; 2],
        sensor: [1.0; 16],
        segment_sd_m: 1.0e-6,
        displacement_sd_m: 1.0e-6,
    });
    let range = Range {
        travel_m: 1.0,
        turn_rad: 0.1,
    };
    let counts = [u16::MAX; 2];
    calibration.poses = Some(Poses::new(
        Plan::Optimal,
        u64::MAX,
        range,
        &Sample::ZERO,
        counts,
    ));
    calibration
}
