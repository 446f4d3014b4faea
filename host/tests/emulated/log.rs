//! The log, from the image's numbers to text, by the command as built.

use crate::common::{asked, json};
use crate::rig::option;

#[test]
fn a_start_is_logged_with_the_name_of_its_cause() {
    let folder = tempfile::tempdir().unwrap();
    let told = asked(
        folder.path(),
        &format!("{} log --seconds 0.2 --json", option()),
    )
    .quiet();
    let messages: Vec<String> = told
        .lines()
        .map(|line| json(line)["message"].to_string())
        .collect();
    for wanted in ["\"start, cause PowerOn\"", "\"converters ready\""] {
        assert!(messages.iter().any(|message| message == wanted), "{told}");
    }
    let text = asked(folder.path(), &format!("{} log --seconds 0.2", option())).quiet();
    let start = text
        .lines()
        .find(|line| line.contains("start, cause PowerOn"));
    assert!(
        start.is_some_and(|line| line.contains("src/board/start.rs:")),
        "{text}"
    );
}

#[test]
fn what_is_no_image_has_no_texts() {
    let folder = tempfile::tempdir().unwrap();
    std::fs::write(folder.path().join("other"), "text").unwrap();
    for file in ["other", "nothing", "."] {
        let words = format!("{} log --elf {file}", option());
        asked(folder.path(), &words).refused(&[file, "an image of this firmware was wanted"]);
    }
}
