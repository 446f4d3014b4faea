//! The acceptance of the image, by the command as built.

use crate::common::{asked, json_in};
use crate::rig::{on_chip, option};

#[test]
fn the_image_passes_what_needs_no_instrument_and_says_what_it_cannot_measure() {
    let folder = tempfile::tempdir().unwrap();
    let (board, name) = (option(), if on_chip() { "g474" } else { "emulated" });
    let words =
        "acceptance --seconds 0.3 --commits 0 --restarts 1 --temperature-c 22 --json=told.json";
    let ran = asked(folder.path(), &format!("{board} {words}"));
    assert_eq!(ran.code, 0, "{} {}", ran.out, ran.err);
    let told = json_in(folder.path().join("told.json"));
    assert_eq!(told["passed"], true, "{told}");
    assert_eq!(told["board"]["board"], name);
    let verdict = |name: &str| {
        let steps = told["steps"].as_array().unwrap();
        let step = steps.iter().find(|step| step["step"] == name);
        step.unwrap_or_else(|| panic!("no {name} in {told}"))["passed"].clone()
    };
    for name in [
        "self-test",
        "temperature",
        "restarts",
        "instants",
        "status",
        "link",
    ] {
        assert_eq!(verdict(name), true, "{name}: {told}");
    }
    assert!(verdict("commits").is_null(), "{told}");
    // The emulated board has no counter of cycles.
    match on_chip() {
        true => assert_eq!(verdict("interrupt"), true, "{told}"),
        false => assert!(verdict("interrupt").is_null(), "{told}"),
    }
    // A reference that the board cannot agree with.
    let words = "acceptance --seconds 0.1 --commits 0 --restarts 0 --temperature-c 90";
    let ran = asked(folder.path(), &format!("{board} {words}"));
    assert_eq!(ran.code, 1, "{} {}", ran.out, ran.err);
    assert!(ran.out.contains("FAILED: found 22.0 °C"), "{}", ran.out);
    assert!(ran.out.contains("failed: 1 step"), "{}", ran.out);
}
