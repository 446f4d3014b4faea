//! The demonstration with the firmware in QEMU beside the one with the firmware in this process.

use crate::rig::amount;
use courier::board::On;
use courier::demo::{Options, Plan, Preset, Report, run};
use indicatif::ProgressBar;

fn demonstrate(on: On) -> Report {
    let options = Options {
        on,
        preset: Preset::Paper,
        seed: 1,
        poses: Some(amount("COURIER_EMULATED_POSES", 120) as u32),
        plan: Plan::Random,
        waveforms: None,
        rms_m: 0.0,
        record: None,
    };
    run(&options, &ProgressBar::hidden()).expect("it runs to its end")
}

/// The same courier, the same poses; the noise of each sample falls at another place of the motion, since orders take their
/// own time on either board. A residual over 120 poses moves by 1 % with the noise: 0.08 of 4.3 µm, in quadrature, and poses
/// that the courier reaches to 2 µm.
#[test]
fn demonstrates_the_same_as_the_simulated_board() {
    let (here, there) = (demonstrate(On::Sim), demonstrate(On::Emulated));
    assert!(here.accepted && there.accepted, "{there:?}");
    assert_eq!(here.poses, there.poses);
    for (row, other) in here.rows.iter().zip(&there.rows) {
        let (a, b) = (row.here.expect("a figure"), other.here.expect("a figure"));
        println!("{}: {a:.4} simulated, {b:.4} emulated", row.name);
        assert!((b / a - 1.0).abs() < 0.05, "{}: {a} and {b}", row.name);
    }
}
