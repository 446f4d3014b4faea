//! `cargo demo`'s own program: it does what `courier demo` does, whose tests are `host/tests/suite/demo.rs`.

use std::process::{Command, Output};

fn demo(arguments: &[&str]) -> Output {
    let mut command = Command::new(env!("CARGO_BIN_EXE_courier-demo"));
    command
        .args(arguments)
        .env_remove("RUST_BACKTRACE")
        .output()
        .unwrap()
}

#[test]
fn a_calibration_is_accepted_and_told() {
    let done = demo(&["--preset", "ideal", "--plan", "optimal", "--poses", "60"]);
    let told = String::from_utf8(done.stdout).unwrap();
    assert_eq!(done.status.code(), Some(0), "{told}");
    assert!(told.contains("accepted: held-out g_p residual"), "{told}");
    assert!(told.contains("θ_y error, fly-by, calibrated"), "{told}");
    assert_eq!(String::from_utf8_lossy(&done.stderr), "");
}

#[test]
fn help_and_refusals_are_those_of_the_command() {
    let help = String::from_utf8(demo(&["--help"]).stdout).unwrap();
    assert!(help.starts_with("Show the main job"), "{help}");
    assert!(help.contains("Usage: cargo demo"), "{help}");
    let refused = demo(&["--poses", "1"]);
    assert_eq!(refused.status.code(), Some(2));
    let told = String::from_utf8(refused.stderr).unwrap();
    assert!(
        told.starts_with("courier: ") && told.contains("40..=20000"),
        "{told}"
    );
    assert_eq!(told.trim_end().lines().count(), 1, "{told}");
}
