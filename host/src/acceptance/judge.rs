//! Whether a step of the acceptance has passed: values in, verdicts out.

use courier_sensor::frame::Status;
use courier_sensor::health::{Trouble, troubles};
use courier_sensor::link::message::{BoardStatus, Health, Hello, ResetCause};
use serde::Serialize;

/// Cycles of the sensor board's processor in a second (170 MHz).
const G474_HZ: f32 = 170.0e6;
/// What the chip's thermometer may be off, kelvin: the factory reads its first point at 30 °C within 5 K (data sheet DS12288), and the chip is
/// some 5 K warmer than what is beside it.
const TEMPERATURE_K: f32 = 10.0;
/// Bits that are states and no faults.
const STATES: Status = Status::UNCALIBRATED.union(Status::BEACON_MISSING);

/// One step and its verdict.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Step {
    /// Its name.
    pub step: &'static str,
    /// Whether it has passed; none if it cannot be measured on this board or was not asked for.
    pub passed: Option<bool>,
    /// What was found.
    pub found: String,
    /// What was wanted.
    pub wanted: String,
    /// Where in a trace that was found, seconds of its own time.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub at_s: Option<f64>,
}

impl Step {
    pub(crate) fn new(
        step: &'static str,
        passed: bool,
        found: String,
        wanted: impl Into<String>,
    ) -> Self {
        Self {
            step,
            passed: Some(passed),
            found,
            wanted: wanted.into(),
            at_s: None,
        }
    }

    pub(crate) fn not_measured(step: &'static str, why: &str, wanted: impl Into<String>) -> Self {
        Self {
            step,
            passed: None,
            found: why.to_owned(),
            wanted: wanted.into(),
            at_s: None,
        }
    }

    /// The same, found at this instant of a trace.
    pub(crate) fn at(self, at_s: f64) -> Self {
        Self {
            at_s: Some(at_s),
            ..self
        }
    }
}

/// What was seen while the board sampled.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Sampled {
    /// Samples taken.
    pub samples: u32,
    /// Sampling instants missed.
    pub missed: u32,
    /// Frames that the background was too late for.
    pub dropped: u32,
    /// Samples that came over the link.
    pub received: u64,
    /// Samples that the link lost.
    pub lost: u32,
    /// Status bits of all frames meanwhile.
    pub status_seen: u32,
    /// Whether a calibration was in force, so that it could be stored.
    pub calibrated: bool,
    /// Commits that were stored.
    pub stored: u16,
    /// Whether what is in force is still the same, number by number.
    pub unchanged: bool,
}

/// What the board has found out about itself.
pub fn self_test(health: &Health) -> Step {
    let found: Vec<String> = troubles(health).iter().map(Trouble::to_string).collect();
    match found.is_empty() {
        true => Step::new("self-test", true, "no trouble".into(), "no trouble"),
        false => Step::new("self-test", false, found.join("; "), "no trouble"),
    }
}

/// The board's thermometer against another.
pub fn temperature(found_c: Option<f32>, reference_c: Option<f32>) -> Step {
    const NAME: &str = "temperature";
    let Some(reference_c) = reference_c else {
        return Step::not_measured(NAME, "--temperature-c states it", "a reference");
    };
    let wanted = format!("{reference_c:.1} °C ± {TEMPERATURE_K} K");
    match found_c {
        None => Step::new(NAME, false, "no thermometer".into(), wanted),
        Some(found_c) => {
            let close = (found_c - reference_c).abs() <= TEMPERATURE_K;
            Step::new(NAME, close, format!("{found_c:.1} °C"), wanted)
        }
    }
}

/// Whether a board that was told to restart says so and has what is stored in force, or nothing stored.
pub fn restarted_as_ordered(status: &BoardStatus) -> bool {
    status.reset == ResetCause::Requested && status.health.faults_in_a_row == 0
}

/// Restarts by order.
pub fn restarts(wanted: u16, good: u16) -> Step {
    if wanted == 0 {
        return Step::not_measured("restarts", "none were asked for", "some");
    }
    let found = format!("{good} of {wanted} as ordered, with what is stored in force");
    Step::new("restarts", good == wanted, found, format!("{wanted}"))
}

/// What was seen while the board sampled.
pub fn sampling(seen: &Sampled, commits: u16) -> [Step; 4] {
    let instants = format!(
        "{} of {} instants missed, {} frames not taken up",
        seen.missed,
        u64::from(seen.samples) + u64::from(seen.missed),
        seen.dropped
    );
    let faults = Status::from_bits_truncate(seen.status_seen) - STATES;
    let names: Vec<&str> = faults.iter_names().map(|(name, _)| name).collect();
    let bits = match names.is_empty() {
        true => "no fault".to_owned(),
        false => names.join(" "),
    };
    let link = format!("{} samples came, {} were lost", seen.received, seen.lost);
    [
        Step::new(
            "instants",
            seen.missed == 0 && seen.samples > 0,
            instants,
            "none missed",
        ),
        Step::new("status", names.is_empty(), bits, "no fault"),
        Step::new(
            "link",
            seen.lost == 0 && seen.received > 0,
            link,
            "none lost",
        ),
        stored(seen, commits),
    ]
}

/// Commits.
fn stored(seen: &Sampled, commits: u16) -> Step {
    const NAME: &str = "commits";
    if commits == 0 {
        return Step::not_measured(NAME, "none were asked for", "some");
    }
    let wanted = format!("{commits} stored, and the calibration in force the same");
    if !seen.calibrated {
        let found = "no calibration in force to store (`courier calibrate` makes one)";
        return Step::new(NAME, false, found.into(), wanted);
    }
    let same = if seen.unchanged {
        "the same"
    } else {
        "another"
    };
    let found = format!(
        "{} of {commits} stored, the calibration in force is {same}",
        seen.stored
    );
    Step::new(
        NAME,
        seen.stored == commits && seen.unchanged,
        found,
        wanted,
    )
}

/// The longest sampling interrupt against the time from one sample to the next.
pub fn interrupt(cycles: Option<u32>, board: &Hello) -> Step {
    let limit = G474_HZ / board.rate_hz;
    let wanted = format!("below {limit:.0} cycles");
    match cycles {
        None => Step::not_measured("interrupt", "this board does not count cycles", wanted),
        Some(cycles) => {
            let passed = (cycles as f32) < limit;
            Step::new(
                "interrupt",
                passed,
                format!("{cycles} cycles at most"),
                wanted,
            )
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use courier_sensor::device::Device;
    use courier_sensor::link::message::{ConverterFault, ConverterTest};

    const GOOD: Sampled = Sampled {
        samples: 20_000,
        missed: 0,
        dropped: 0,
        received: 1000,
        lost: 0,
        status_seen: STATES.bits(),
        calibrated: true,
        stored: 2,
        unchanged: true,
    };

    fn failed(seen: Sampled) -> Vec<&'static str> {
        let steps = sampling(&seen, 2);
        let failed = steps.iter().filter(|step| step.passed == Some(false));
        failed.map(|step| step.step).collect()
    }

    #[test]
    fn each_flaw_of_a_run_fails_its_step_alone() {
        assert_eq!(failed(GOOD), [""; 0]);
        let crc = Status::CONVERTER_CRC.bits();
        let cases = [
            (Sampled { missed: 1, ..GOOD }, "instants"),
            (Sampled { samples: 0, ..GOOD }, "instants"),
            (
                Sampled {
                    status_seen: crc,
                    ..GOOD
                },
                "status",
            ),
            (Sampled { lost: 1, ..GOOD }, "link"),
            (
                Sampled {
                    received: 0,
                    ..GOOD
                },
                "link",
            ),
            (Sampled { stored: 1, ..GOOD }, "commits"),
            (
                Sampled {
                    unchanged: false,
                    ..GOOD
                },
                "commits",
            ),
            (
                Sampled {
                    calibrated: false,
                    ..GOOD
                },
                "commits",
            ),
        ];
        for (seen, step) in cases {
            assert_eq!(failed(seen), [step], "{seen:?}");
        }
        assert_eq!(stored(&GOOD, 0).passed, None);
    }

    #[test]
    fn self_test_temperature_restarts_and_interrupt_are_judged() {
        let health = Health::default();
        assert_eq!(self_test(&health).passed, Some(true));
        let converters = ConverterTest::Failed(ConverterFault::BusyStuck);
        let step = self_test(&Health {
            converters,
            ..health
        });
        assert_eq!(step.passed, Some(false));
        assert!(step.found.contains("BUSY"), "{step:?}");
        for (found, reference, passed) in [
            (Some(25.0), Some(20.0), Some(true)),
            (Some(31.0), Some(20.0), Some(false)),
            (None, Some(20.0), Some(false)),
            (Some(25.0), None, None),
        ] {
            assert_eq!(temperature(found, reference).passed, passed);
        }
        assert_eq!(restarts(3, 3).passed, Some(true));
        assert_eq!(restarts(3, 2).passed, Some(false));
        assert_eq!(restarts(0, 0).passed, None);
        let board = Hello {
            protocol: 0,
            firmware: "0".try_into().unwrap(),
            board: "g474".try_into().unwrap(),
            device: Device::default(),
            rate_hz: 20_000.0,
        };
        assert_eq!(interrupt(Some(8_499), &board).passed, Some(true));
        assert_eq!(interrupt(Some(8_500), &board).passed, Some(false));
        assert_eq!(interrupt(None, &board).passed, None);
    }
}
