//! What has become of a board's stored tooth maps, in words.

use crate::terminal::micrometres;
use courier_sensor::frame::Coordinate;
use courier_sensor::link::message::StoredMap;
use courier_sensor::maps::fit::{CELLS, ParityOfMap};
use courier_sensor::maps::homing::{MOST_LEFT_TURNS, Unusable};

/// In one line. `name`: of the map that the state is about, if it is known.
pub fn text(state: &StoredMap, name: Option<&str>) -> String {
    let map = |slot: &u8| match name {
        Some(name) => format!("`{name}`"),
        None => format!("the map in slot {slot}"),
    };
    match state {
        StoredMap::None => "none stored".to_owned(),
        StoredMap::Ordered => {
            "as ordered by a host; those stored are left out until the board restarts".to_owned()
        }
        StoredMap::OtherCalibration { slot } => {
            format!(
                "{} belongs to another calibration than the one in force",
                map(slot)
            )
        }
        StoredMap::Waits(Unusable::NoBeacon) => "map waits for a beacon".to_owned(),
        StoredMap::Waits(lacks) => format!("map waits for {lacks}"),
        StoredMap::Looking => "looking for the map's teeth by the beacon".to_owned(),
        StoredMap::NotWhole { slot, ahead } => format!(
            "{} does not fit: the board counts {} teeth ahead of it, wanted whole numbers within {MOST_LEFT_TURNS}: the beacon or the mark was moved, or it is another one",
            map(slot),
            teeth(ahead)
        ),
        StoredMap::OtherPlaten { slot, parity } => format!(
            "{} does not fit: {}: this is another platen, or the beacon or the mark was moved by whole teeth",
            map(slot),
            told(parity)
        ),
        StoredMap::Refused { slot, refusal } => format!("{} cannot be used: {refusal}", map(slot)),
        StoredMap::InForce {
            slot,
            ahead,
            uptime_s,
            parity,
        } => {
            let fits = match parity.fits() {
                None => format!(
                    "not yet confirmed by g_p: {} of {CELLS} cells passed",
                    parity.cells
                ),
                Some(_) => format!("confirmed: {}", told(parity)),
            };
            format!(
                "{} since {uptime_s:.2} s after the start, {} teeth ahead, {fits}",
                map(slot),
                teeth(ahead)
            )
        }
    }
}

fn teeth(ahead: &[Coordinate; 2]) -> String {
    let [x, y] = ahead.map(|ahead| f64::from(ahead.teeth) + f64::from(ahead.fraction_turns));
    format!("{x:.2}, {y:.2}")
}

fn told(parity: &ParityOfMap) -> String {
    let [found, wanted] = [parity.parity_m, parity.wanted_m].map(|m| micrometres(m.into()));
    format!(
        "g_p {found} µm rms in {} cells, wanted {wanted} or less",
        parity.cells
    )
}

/// The slot that a state is about.
pub fn slot(state: &StoredMap) -> Option<u8> {
    match state {
        StoredMap::OtherCalibration { slot }
        | StoredMap::NotWhole { slot, .. }
        | StoredMap::OtherPlaten { slot, .. }
        | StoredMap::Refused { slot, .. }
        | StoredMap::InForce { slot, .. } => Some(*slot),
        StoredMap::None | StoredMap::Ordered | StoredMap::Waits(_) | StoredMap::Looking => None,
    }
}

/// What to do about it, where something is to be done.
pub fn next(state: &StoredMap) -> Option<String> {
    let what = match state {
        StoredMap::Waits(Unusable::NoBeacon) => {
            "a stored tooth map waits for a beacon: bring the courier under the one that it was made under"
        }
        StoredMap::Waits(Unusable::NoBeaconNorMark) => {
            "a stored tooth map waits for a beacon or its mark: let the courier cross the mark at 10 mm/s or less, or bring it under the beacon"
        }
        StoredMap::OtherCalibration { .. } => {
            "a stored tooth map belongs to another calibration: `courier rollback` if that is the one before, or make it anew (`courier map`, `courier load`)"
        }
        StoredMap::NotWhole { .. } | StoredMap::OtherPlaten { .. } => {
            "the stored tooth map does not fit: docs/faults.md, tooth maps that stay"
        }
        StoredMap::Refused { .. } => {
            "a stored tooth map cannot be used: `courier maps` lists them, `courier load MAP.json` stores it anew"
        }
        _ => return None,
    };
    Some(what.to_owned())
}
