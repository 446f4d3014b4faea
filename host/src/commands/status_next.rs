//! What to do next with a board, from its state.

use courier_sensor::device::Device;
use courier_sensor::frame::Status;
use courier_sensor::link::message::{
    Activity, BoardStatus, InForce, Refusal, ResetCause, SlotRefusal,
};

/// Bits that are states and no faults.
const STATES: Status = Status::UNCALIBRATED.union(Status::BEACON_MISSING);

/// What is known of the calibration in force beside the board's state.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct InUse {
    /// The board that made it.
    pub device: Device,
    /// Whether it is a joint one, with a beacon.
    pub joint: bool,
}

/// What to do next, the most urgent first; never empty.
pub fn next(status: &BoardStatus, device: Device, in_use: Option<InUse>) -> Vec<String> {
    if status.activity != Activity::Idle {
        return vec!["a calibration is under way: wait, or end it with `courier abort`".to_owned()];
    }
    let mut steps = Vec::new();
    steps.extend(restarted(status.reset));
    steps.extend(faults(status));
    steps.extend(stored(status.boot));
    steps.extend(calibration(status, device, in_use));
    if status.missed > 0 || status.dropped_frames > 0 {
        steps.push(format!(
            "{} samples were missed and {} frames dropped: line `OVERRUN` of docs/faults.md",
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
        Refusal::NotCalibrated | Refusal::Slots(SlotRefusal::NoneInForce) => None,
        why => Some(format!(
            "the stored calibration did not come in force ({why}): `courier slots` lists both, `courier rollback` goes back to the other"
        )),
    }
}

fn calibration(status: &BoardStatus, device: Device, in_use: Option<InUse>) -> Vec<String> {
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
    let Some(in_use) = in_use else {
        return steps;
    };
    if in_use.device != device {
        steps.push(format!(
            "the calibration in force was made on {}, this is {device}: `courier calibrate` makes one for it",
            in_use.device
        ));
    }
    if in_use.joint && status.map.is_none() {
        steps.push(
            "no tooth map is in force; one is lost at each restart: if you have made one, `courier load MAP.json` puts it back".to_owned(),
        );
    }
    steps
}

#[cfg(test)]
mod tests {
    use super::*;
    use courier_sensor::calibration::slots::Place;
    use courier_sensor::link::message::RecordRefusal;

    const OWN: Device = Device(*b"paper-000001");
    const OTHER: Device = Device(*b"paper-000002");
    const STORED: InForce = InForce::Stored(Place {
        slot: 0,
        sequence: 1,
    });

    fn told(status: BoardStatus, in_use: Option<InUse>) -> String {
        let steps = next(&status, OWN, in_use);
        assert!(!steps.is_empty());
        steps.join("\n")
    }

    fn in_use(device: Device, joint: bool) -> Option<InUse> {
        Some(InUse { device, joint })
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
            assert!(told(status(reset), in_use(OWN, false)).starts_with("nothing"));
        }
        for (reset, word) in bad {
            let text = told(status(reset), in_use(OWN, false));
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
            let text = told(seen, in_use(OWN, false));
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
        let cases = [
            (
                status(InForce::None, new),
                None,
                vec!["courier calibrate"],
                vec!["slots"],
            ),
            (
                status(InForce::None, torn),
                None,
                vec!["courier calibrate", "courier slots", "torn"],
                vec![],
            ),
            (
                status(InForce::Unsaved, None),
                in_use(OWN, false),
                vec!["courier commit"],
                vec!["courier calibrate"],
            ),
            (
                status(STORED, None),
                in_use(OTHER, false),
                vec!["made on paper-000002, this is paper-000001"],
                vec!["load MAP"],
            ),
            (
                status(STORED, None),
                in_use(OWN, true),
                vec!["courier load MAP.json"],
                vec!["courier calibrate"],
            ),
            (
                status(STORED, None),
                in_use(OWN, false),
                vec!["nothing", "courier monitor"],
                vec!["courier load"],
            ),
        ];
        for (status, in_use, wanted, unwanted) in cases {
            let text = told(status, in_use);
            assert!(wanted.iter().all(|word| text.contains(word)), "{text}");
            assert!(!unwanted.iter().any(|word| text.contains(word)), "{text}");
        }
        let missed = BoardStatus {
            missed: 3,
            in_force: STORED,
            ..BoardStatus::default()
        };
        assert!(told(missed, in_use(OWN, false)).contains("3 samples were missed"));
        for activity in [Activity::Calibrating, Activity::Solving] {
            let busy = BoardStatus {
                activity,
                ..BoardStatus::default()
            };
            assert!(told(busy, None).contains("courier abort"));
        }
    }
}
