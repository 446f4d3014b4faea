//! Two commands at one board, and commands that are killed.

use crate::common::{CALIBRATE, Ran, asked};
use std::fs::{OpenOptions, TryLockError};
use std::io::ErrorKind;
use std::path::Path;
use std::process::{Child, Command, Stdio};
use std::time::{Duration, Instant};

/// A running `courier` in `folder`.
fn started(folder: &Path, words: &str) -> Child {
    Command::new(env!("CARGO_BIN_EXE_courier"))
        .args(words.split_whitespace())
        .current_dir(folder)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .stderr(Stdio::null())
        .spawn()
        .unwrap()
}

/// Waits for something to come true; a test that hangs fails.
fn wait_for(what: &str, mut is_true: impl FnMut() -> bool) {
    let begin = Instant::now();
    while !is_true() {
        assert!(begin.elapsed() < Duration::from_secs(60), "no {what}");
        std::thread::sleep(Duration::from_millis(5));
    }
}

fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).into_iter().flatten().flatten();
    entries
        .map(|entry| entry.file_name().to_string_lossy().into_owned())
        .collect()
}

/// Whether somebody has an unfinished recording in `folder` locked. Its file is there a moment before its lock.
fn is_under_way(folder: &Path) -> bool {
    names(folder)
        .iter()
        .filter(|name| name.starts_with(".courier-unfinished"))
        .filter_map(|name| OpenOptions::new().write(true).open(folder.join(name)).ok())
        .any(|file| matches!(file.try_lock(), Err(TryLockError::WouldBlock)))
}

/// The second command is refused in one line that says who has the board, and what the first one stores is not lost.
#[test]
fn a_second_command_at_one_flash_is_refused() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    asked(folder, CALIBRATE).quiet();
    asked(folder, "--sim-preset ideal --sim-flash a.bin export a.json").quiet();
    let mut first = started(folder, "--sim-flash a.bin monitor");
    // The holder is written into the file once it is locked. Where a locked file cannot be read, that is told by the error.
    let lock = folder.join(".a.bin.lock");
    wait_for("lock", || match std::fs::read(&lock) {
        Ok(holder) => !holder.is_empty(),
        Err(error) => error.kind() != ErrorKind::NotFound,
    });
    let second = asked(folder, "--sim-preset ideal --sim-flash a.bin import a.json");
    let process = format!("process {}", first.id());
    // On systems where a locked file cannot be read, its holder is not known.
    let holder = if cfg!(windows) {
        "another command"
    } else {
        &process
    };
    second.refused(&["--sim-flash: a.bin: found it in use by", holder]);
    first.kill().unwrap();
    first.wait().unwrap();
    asked(folder, "--sim-preset ideal --sim-flash a.bin import a.json").quiet();
    assert!(!names(folder).contains(&".a.bin.lock".to_owned()));
}

/// Of several commands at once each either stores or says that it did not.
#[test]
fn nothing_that_was_said_to_be_stored_is_lost() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    asked(folder, CALIBRATE).quiet();
    asked(folder, "--sim-preset ideal --sim-flash a.bin export a.json").quiet();
    let words = "--sim-preset ideal --sim-flash a.bin import a.json --json";
    let imports: Vec<Ran> = std::thread::scope(|scope| {
        let threads: Vec<_> = (0..4)
            .map(|_| scope.spawn(|| asked(folder, words)))
            .collect();
        threads
            .into_iter()
            .map(|thread| thread.join().unwrap())
            .collect()
    });
    let (done, refused): (Vec<Ran>, Vec<Ran>) = imports.into_iter().partition(|ran| ran.code == 0);
    refused.iter().for_each(|ran| ran.refused(&["in use by"]));
    let mut stored: Vec<u64> = done
        .into_iter()
        .map(|ran| ran.json()["stored"]["sequence"].as_u64().unwrap())
        .collect();
    stored.sort_unstable();
    assert!(!stored.is_empty());
    assert_eq!(stored, (2..2 + stored.len() as u64).collect::<Vec<u64>>());
}

/// A recording that was killed leaves nothing that the next one stumbles over; one that is under way is left alone.
#[test]
fn a_killed_recording_makes_room_for_the_next() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let place = folder.join("r");
    for force in ["", " --force"] {
        let mut killed = started(folder, "record r --seconds 86400 --force");
        wait_for("unfinished recording", || is_under_way(&place));
        let busy = asked(folder, &format!("record r --seconds 0.1{force}"));
        busy.refused(&["another command is writing"]);
        killed.kill().unwrap();
        killed.wait().unwrap();
        asked(folder, &format!("record r --seconds 0.1{force}")).quiet();
        let mut left = names(&place);
        left.sort_unstable();
        assert_eq!(left, ["recording.toml", "samples.csv"]);
        if force.is_empty() {
            std::fs::remove_dir_all(&place).unwrap();
        }
    }
}

/// Interrupted by the user, a recording takes away what it has made, and what was there before stays.
#[cfg(unix)]
#[test]
fn an_interrupted_recording_leaves_nothing() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    for signal in ["INT", "TERM"] {
        let mut interrupted = started(folder, "record r --seconds 86400");
        wait_for("unfinished recording", || is_under_way(&folder.join("r")));
        let id = interrupted.id().to_string();
        let sent = Command::new("kill").args(["-s", signal, &id]).status();
        assert!(sent.unwrap().success());
        assert_eq!(interrupted.wait().unwrap().code(), Some(130));
        assert_eq!(names(folder), Vec::<String>::new());
    }
}
