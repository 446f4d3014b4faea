//! A panic in a command is one line and exit code 70, in a program that goes the way that `courier` goes.

use std::process::Command;

fn said(place: &str) -> (Option<i32>, String, String) {
    let mut command = Command::new(env!("CARGO_BIN_EXE_panics"));
    // Whoever asks for backtraces gets none: they are no line.
    let output = command.arg(place).env("RUST_BACKTRACE", "full").output();
    let output = output.unwrap();
    let text = |bytes: &[u8]| String::from_utf8_lossy(bytes).into_owned();
    (
        output.status.code(),
        text(&output.stdout),
        text(&output.stderr),
    )
}

#[test]
fn a_panic_is_one_line_and_an_exit_code_of_its_own() {
    let (code, out, err) = said("here");
    assert_eq!(
        (code, out.as_str(), err.lines().count()),
        (Some(70), "", 1),
        "{err}"
    );
    assert!(err.starts_with("courier: error of the program"), "{err}");
    let version = env!("CARGO_PKG_VERSION");
    for part in [
        "robustness/src/bin/panics.rs:",
        "wanted more than nothing",
        &format!("courier {version}"),
        "panics here`",
    ] {
        assert!(err.contains(part), "found {err}, wanted {part} in it");
    }
}

#[test]
fn of_a_panic_in_a_thread_the_cause_is_told() {
    let (code, _, err) = said("thread");
    assert_eq!((code, err.lines().count()), (Some(70), 1), "{err}");
    assert!(
        err.contains("in a thread") && !err.contains("has ended"),
        "{err}"
    );
}
