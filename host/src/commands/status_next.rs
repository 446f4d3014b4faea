//! What to do next with a board, from its state.

use super::status_map;
use courier_sensor::calibration::recalibration::State;
use courier_sensor::calibration::rest_watch::RestVerdict;
use courier_sensor::calibration::watch::Standing;
use courier_sensor::frame::Status;
use courier_sensor::health::troubles;
use courier_sensor::link::message::{
    Activity, BoardStatus, InForce, RecordRefusal, Refusal, ResetCause, SlotRefusal, StoredMap,
};

/// Bits that are states and no faults.
const STATES: Status = Status::UNCALIBRATED
    .union(Status::BEACON_MISSING)
    .union(Status::CALIBRATION_DRIFT);

/// What to do next, the most urgent first; never empty. `joint`: whether the calibration in force is a joint one, with a beacon.
pub fn next(status: &BoardStatus, joint: bool) -> Vec<String> {
    if status.activity != Activity::Idle {
        return vec!["a calibration is under way: wait, or end it with `courier abort`".to_owned()];
    }
    let mut steps = Vec::new();
    let troubles = troubles(&status.health).into_iter();
    steps.extend(troubles.map(|trouble| format!("{trouble}: {}", trouble.remedy())));
    steps.extend(restarted(status.reset));
    steps.extend(faults(status));
    steps.extend(stored(status.boot));
    steps.extend(calibration(status, joint));
    if status.missed > 0 || status.dropped_frames > 0 {
        steps.push(format!(
            "{} samples were missed and {} not taken up: line `OVERRUN` of docs/faults.md",
            status.missed, status.dropped_frames
        ));
    }
    if steps.is_empty() {
        steps.push(
            "nothing: `courier monitor` shows the pose, `courier record DIR --survey X,Y,THETA` records what `courier diagnose DIR` needs"
                .to_owned(),
        );
    }
    steps
}

fn restarted(reset: ResetCause) -> Option<String> {
    let cause = match reset {
        ResetCause::PowerOn | ResetCause::Pin | ResetCause::Requested => return None,
        ResetCause::BrownOut => "its supply was too low: check the supply",
        ResetCause::Watchdog => "its watchdog: `courier log` shows what it says of it",
        ResetCause::Panic | ResetCause::HardFault => {
            "a fault of the firmware: report the line `last fault` above"
        }
    };
    Some(format!("the board restarted by {cause}"))
}

fn faults(status: &BoardStatus) -> Option<String> {
    let bits = Status::from_bits_truncate(status.status | status.status_seen) - STATES;
    let names: Vec<&str> = bits.iter_names().map(|(name, _)| name).collect();
    (!bits.is_empty()).then(|| format!("{bits}: docs/faults.md, {}", names.join(", ")))
}

/// Why no stored calibration came in force, unless there is none.
fn stored(boot: Option<Refusal>) -> Option<String> {
    match boot? {
        Refusal::NotCalibrated | Refusal::SafeMode | Refusal::Slots(SlotRefusal::NoneInForce) => {
            None
        }
        why @ Refusal::Slots(SlotRefusal::Record(RecordRefusal::OtherDevice(_))) => Some(format!(
            "the stored calibration did not come in force ({why}): `courier export --slot`, then `courier import --other-device` takes it over"
        )),
        why => Some(format!(
            "the stored calibration did not come in force ({why}): `courier slots` lists both, `courier rollback` goes back to the other"
        )),
    }
}

fn calibration(status: &BoardStatus, joint: bool) -> Vec<String> {
    let mut steps = Vec::new();
    match status.in_force {
        InForce::None => {
            steps.push("no calibration is in force: `courier calibrate` makes one, `courier import FILE` loads one".to_owned());
        }
        InForce::Unsaved => steps.push(
            "the calibration in force is lost at the next restart: `courier commit` stores it"
                .to_owned(),
        ),
        InForce::Stored(_) => {}
    }
    match status.watch.standing {
        _ if matches!(status.recalibration.state, State::Proposed(_)) => steps.push(
            "a better calibration is proposed (line `recalibration`): `courier recalibrate accept` puts it in force"
                .to_owned(),
        ),
        Standing::Drifting => steps.push(
            "the calibration has drifted (line `in service`): plan a new one, `courier calibrate`"
                .to_owned(),
        ),
        Standing::Stale => steps.push(
            "the calibration is stale (line `in service`): `courier calibrate` makes a new one"
                .to_owned(),
        ),
        _ => {}
    }
    let is_told =
        |verdict: &RestVerdict| matches!(verdict.standing, Standing::Drifting | Standing::Stale);
    if is_told(&status.parity_watch) {
        steps.push(
            "g_p has changed (line `g_p in service`): if that goes with the temperature, let it come back; otherwise look for what has moved, then `courier calibrate`"
                .to_owned(),
        );
    }
    if is_told(&status.beacon_watch) {
        steps.push(
            "g_x or g_y has changed (line `beacon in service`): put back what has moved, or `courier calibrate --joint`"
                .to_owned(),
        );
    }
    if joint && status.map.is_none() && status.stored_map == StoredMap::None {
        steps.push(
            "no tooth map is stored: if you have made one, `courier load MAP.json` stores it"
                .to_owned(),
        );
    }
    steps.extend(status_map::next(&status.stored_map));
    steps
}

#[cfg(test)]
mod tests {
    use super::*;
    use courier_sensor::calibration::slots::Place;
    use courier_sensor::device::Device;

    const STORED: InForce = InForce::Stored(Place {
        slot: 0,
        sequence: 1,
    });

    fn told(status: BoardStatus, joint: bool) -> String {
        let steps = next(&status, joint);
        assert!(!steps.is_empty());
        steps.join("\n")
    }

    #[test]
    fn every_cause_of_a_restart_that_is_a_fault_is_told() {
        let good = [ResetCause::PowerOn, ResetCause::Pin, ResetCause::Requested];
        let bad = [
            (ResetCause::BrownOut, "supply"),
            (ResetCause::Watchdog, "courier log"),
            (ResetCause::Panic, "last fault"),
            (ResetCause::HardFault, "last fault"),
        ];
        let status = |reset| BoardStatus {
            reset,
            in_force: STORED,
            ..BoardStatus::default()
        };
        for reset in good {
            assert!(told(status(reset), false).starts_with("nothing"));
        }
        for (reset, word) in bad {
            let text = told(status(reset), false);
            assert!(
                text.contains("restarted by") && text.contains(word),
                "{text}"
            );
        }
    }

    #[test]
    fn every_bit_that_is_a_fault_names_its_page_and_no_state_does() {
        for (name, bit) in Status::all().iter_names() {
            let seen = BoardStatus {
                status_seen: bit.bits(),
                in_force: STORED,
                ..BoardStatus::default()
            };
            let text = told(seen, false);
            let fault = !STATES.contains(bit);
            assert_eq!(text.contains("docs/faults.md"), fault, "{name}: {text}");
            assert_eq!(text.contains(name), fault, "{name}: {text}");
        }
    }

    #[test]
    fn the_calibration_decides_what_is_next() {
        let status = |in_force, boot| BoardStatus {
            in_force,
            boot,
            ..BoardStatus::default()
        };
        let new = Some(Refusal::NotCalibrated);
        let torn = Some(Refusal::Slots(SlotRefusal::Record(RecordRefusal::Torn)));
        let other = RecordRefusal::OtherDevice(Device(*b"paper-000002"));
        let of_another = Refusal::Slots(SlotRefusal::Record(other));
        let cases = [
            (
                status(InForce::None, new),
                false,
                vec!["courier calibrate"],
                vec!["slots"],
            ),
            (
                status(InForce::None, torn),
                false,
                vec!["courier calibrate", "courier slots", "torn"],
                vec![],
            ),
            (
                status(InForce::Unsaved, None),
                false,
                vec!["courier commit"],
                vec!["courier calibrate"],
            ),
            (
                status(InForce::None, Some(of_another)),
                false,
                vec!["is of another board, paper-000002", "--other-device"],
                vec!["rollback"],
            ),
            (
                status(STORED, None),
                true,
                vec!["courier load MAP.json"],
                vec!["courier calibrate"],
            ),
            (
                status(STORED, None),
                false,
                vec!["nothing", "courier monitor"],
                vec!["courier load"],
            ),
        ];
        for (status, joint, wanted, unwanted) in cases {
            let text = told(status, joint);
            assert!(wanted.iter().all(|word| text.contains(word)), "{text}");
            assert!(!unwanted.iter().any(|word| text.contains(word)), "{text}");
        }
        let missed = BoardStatus {
            missed: 3,
            in_force: STORED,
            ..BoardStatus::default()
        };
        assert!(told(missed, false).contains("3 samples were missed"));
        for activity in [Activity::Calibrating, Activity::Solving] {
            let busy = BoardStatus {
                activity,
                ..BoardStatus::default()
            };
            assert!(told(busy, false).contains("courier abort"));
        }
    }
}
