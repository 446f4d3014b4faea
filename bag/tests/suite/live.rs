//! A file that grows can be read at any time, up to the last second.

use bag::{Live, State};
use convert::Beside;
use std::fs::File;

/// Time zero of the board.
pub const ZERO_NS: u64 = 1_764_248_400_000_000_000;

pub fn state(row: u32) -> State<'static> {
    let t_s = f64::from(row) / 50.0;
    State {
        t_s,
        x_m: 1e-3 * t_s,
        y_m: -1.0 / 3.0,
        theta_rad: [1e-3, 3e-3],
        parity_m: 1e-6 * f64::from(row),
        status: (5, "SETTLED"),
    }
}

#[test]
fn what_was_written_a_second_ago_is_there_before_the_end_and_all_of_it_after() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let mut live = Live::begin(File::create(&path).unwrap(), ZERO_NS).unwrap();
    assert!(bag::log(&path, &Beside::default()).is_err());
    for row in 0..176 {
        live.push(&state(row)).unwrap();
    }
    // 3.5 s: the last flush was with the sample at 3 s.
    let log = bag::log(&path, &Beside::default()).unwrap();
    assert_eq!(log.rows(), 151);
    assert!(
        log.notes
            .iter()
            .any(|note| note.starts_with("the end of the file is missing")),
        "{:?}",
        log.notes
    );
    live.end().unwrap();
    let log = bag::log(&path, &Beside::default()).unwrap();
    assert_eq!(log.rows(), 176);
    assert!(
        log.notes.iter().all(|note| !note.contains("missing")),
        "{:?}",
        log.notes
    );
    let last = |name: &str| {
        *log.columns
            .iter()
            .find(|column| column.name == name || column.name.ends_with(&format!(".{name}")))
            .unwrap()
            .numbers
            .last()
            .unwrap()
    };
    let wanted = state(175);
    assert_eq!(
        (
            last("x_m"),
            last("y_m"),
            last("parity_m"),
            last("status_bits")
        ),
        (wanted.x_m, wanted.y_m, wanted.parity_m, 5.0)
    );
    assert_eq!(
        (
            last("time"),
            last("pose.position.x"),
            last("pose.orientation.z")
        ),
        (3.5, wanted.x_m, 1e-3_f64.sin())
    );
}

/// Programs that draw begin where the first chunk does.
#[test]
fn no_part_of_the_file_lies_before_its_first_state() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("a.mcap");
    let mut live = Live::begin(File::create(&path).unwrap(), ZERO_NS).unwrap();
    (0..120).for_each(|row| live.push(&state(row)).unwrap());
    live.end().unwrap();
    let bytes = std::fs::read(&path).unwrap();
    let summary = mcap::Summary::read(&bytes).unwrap().unwrap();
    let times: Vec<u64> = summary
        .chunk_indexes
        .iter()
        .map(|chunk| chunk.message_start_time)
        .collect();
    assert!(
        times.len() > 2 && times.iter().all(|time| *time >= ZERO_NS),
        "{times:?}"
    );
}
