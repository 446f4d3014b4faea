//! Files that are cut short or spoilt: one line, never a panic.

use crate::made::{motion, next};
use recording::Existing;
use std::path::Path;

fn whole(folder: &Path) -> Vec<u8> {
    let recording = motion(300);
    let file = folder.join("whole.parquet");
    columnar::write(&recording.meta, &recording.samples, &file, Existing::Refuse).unwrap();
    std::fs::read(file).unwrap()
}

/// What reading says of these bytes, as a recording and as a log.
fn told(folder: &Path, bytes: &[u8]) -> [Option<String>; 2] {
    let file = folder.join("a.parquet");
    std::fs::write(&file, bytes).unwrap();
    let told = [
        columnar::read(&file).err().map(|error| error.to_string()),
        columnar::log(&file).err().map(|error| error.to_string()),
    ];
    for line in told.iter().flatten() {
        assert!(line.contains("a.parquet") && !line.contains('\n'), "{line}");
    }
    told
}

#[test]
fn every_cut_is_told_in_a_line() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = whole(folder.path());
    for length in (0..bytes.len())
        .step_by(7)
        .chain(bytes.len() - 20..bytes.len())
    {
        let told = told(folder.path(), &bytes[..length]);
        assert!(told.iter().all(Option::is_some), "cut at {length}");
        // A piece out of the middle as well.
        let middle = [&bytes[..length / 2], &bytes[bytes.len() - length / 2..]].concat();
        self::told(folder.path(), &middle);
    }
}

/// A spoilt byte may go unseen among the counts, as it would in a text; it never ends the program.
#[test]
fn spoilt_bytes_never_end_the_program() {
    let folder = tempfile::tempdir().unwrap();
    let bytes = whole(folder.path());
    let (mut state, mut seen) = (7, 0);
    for _ in 0..TRIES {
        let mut spoilt = bytes.clone();
        for _ in 0..1 + (4.0 * next(&mut state)) as usize {
            let place = (next(&mut state) * spoilt.len() as f64) as usize;
            spoilt[place] = (256.0 * next(&mut state)) as u8;
        }
        seen += usize::from(told(folder.path(), &spoilt)[0].is_some());
    }
    assert!(seen > 0);
}

/// Enough that a panic which one spoilt file in a hundred causes is met: 1 - 0.99^500 > 0.99.
const TRIES: usize = 500;
