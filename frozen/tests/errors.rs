//! What is told of a command line that asks for nothing.

use std::process::Command;

/// One line, and exit code 2, whatever the environment asks of a program that fails.
#[test]
fn a_name_that_is_not_kept_gets_one_line() {
    let run = Command::new(env!("CARGO_BIN_EXE_frozen"))
        .args(["compare", "--only", "no such specimen"])
        .env("RUST_BACKTRACE", "1")
        .output()
        .expect("the command runs");
    assert_eq!(run.status.code(), Some(2));
    let told = String::from_utf8(run.stderr).expect("text");
    assert_eq!(told.lines().count(), 1, "{told}");
    assert!(
        told.starts_with("frozen: ") && told.contains("no such specimen"),
        "{told}"
    );
}
