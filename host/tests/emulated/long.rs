//! Everything at once for long: calibration after calibration, every sample streamed, flash written in between.

use crate::rig::{Rig, amount, marked, short};
use courier_sensor::link::message::{Action, CalibrateOrder, Reply};
use courier_sensor::link::report::Ending;
use courier_sensor::link::telemetry::Channels;

/// Time between two readings of the stream, of the board's: its ring holds 12 ms.
const READ_MS: u64 = 5;
/// Readings between two looks at the session.
const LOOK: u64 = 10;

/// Figure asked for: no interrupt missed in 60 s at 20 kHz, in `cargo xtask bench` (`COURIER_EMULATED_SECONDS`). Here long enough for
/// some sessions and writes.
#[test]
fn no_interrupt_is_missed_with_calibration_stream_and_flash_at_once() {
    let seconds = amount("COURIER_EMULATED_SECONDS", 12);
    let mut rig = Rig::start(17);
    rig.link.stream(Channels::RECORDING, 1).expect("a stream");
    let begin = rig.status();
    let (mut samples, mut sessions, mut accepted, mut writes) = (0_u64, 0_u32, 0_u32, 0_u32);
    let mut under_way = false;
    for reading in 0..seconds * 1000 / READ_MS {
        rig.run(READ_MS);
        let listened = rig.link.listen(|_| {
            samples += 1;
            Ok(())
        });
        listened.expect("the board is there");
        if reading % LOOK > 0 {
            continue;
        }
        if !under_way {
            // A calibration put in force and written, and the next session at once.
            assert!(matches!(rig.store(1 + writes), Ok(Reply::Place(_))));
            assert_eq!(rig.ask(Action::take_over(marked(1000))), Reply::Done);
            writes += 1;
            let order = CalibrateOrder {
                seed: 1 + u64::from(sessions),
                ..short()
            };
            assert_eq!(rig.ask(Action::Calibrate(order)), Reply::Done);
            (under_way, sessions) = (true, sessions + 1);
        } else if let Some(ending) = rig.progress().ending {
            under_way = false;
            // A session of so few poses may be refused for its condition number, which is no matter here.
            accepted += u32::from(matches!(
                ending,
                Ending::Accepted {
                    stored: Some(_),
                    ..
                }
            ));
        }
    }
    let status = rig.status();
    let taken = u64::from(status.samples.wrapping_sub(begin.samples));
    println!(
        "{seconds} s at 20 kHz: {taken} samples, {} interrupts missed; {sessions} sessions, {accepted} accepted and stored, {writes} \
         calibrations written beside; {samples} samples streamed, {} not: {} frames not taken up while a result was solved or \
         flash written",
        status.missed, status.lost_telemetry, status.dropped_frames
    );
    assert!(taken >= seconds * 20_000, "{taken}");
    assert_eq!(status.missed, 0);
    assert!(
        accepted > 0 && writes > 0,
        "{accepted} accepted, {writes} written"
    );
    let told = samples + u64::from(status.lost_telemetry);
    assert!(
        told + 1000 > taken,
        "{told} of {taken} samples sent or told as lost"
    );
}
