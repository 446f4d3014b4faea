//! A writer leaves nothing or everything, and writes what a reader takes.

use super::{META, read};
use recording::{Existing, Recording, Writer};

#[test]
fn writing_leaves_nothing_or_everything() {
    let source = read(META, b"t_s,run,p1_m\n0,a,1e-3\n1,a,2e-3\n").unwrap();
    let parent = tempfile::tempdir().unwrap();
    let target = parent.path().join("new");
    let mut writer = Writer::create(&target, &source.meta, Existing::Refuse).unwrap();
    writer.push(&source.samples.row(1)).unwrap();
    let line = writer.push(&source.samples.row(0)).unwrap_err().to_string();
    assert!(
        line.ends_with(
            "samples.csv: row 3, column t_s, found 0, wanted a time after the row before, 1 s"
        ),
        "{line}"
    );
    drop(writer);
    assert!(!target.exists());

    source.write(&target, Existing::Refuse).unwrap();
    assert_eq!(Recording::read(&target).unwrap(), source);
    assert!(source.write(&target, Existing::Refuse).is_err());
    source.write(&target, Existing::ReplaceRecording).unwrap();
    let mut names: Vec<_> = std::fs::read_dir(&target)
        .unwrap()
        .map(|entry| entry.unwrap().file_name())
        .collect();
    names.sort();
    assert_eq!(names, ["recording.toml", "samples.csv"]);

    let mut writer = Writer::create(&target, &source.meta, Existing::ReplaceRecording).unwrap();
    writer.push(&source.samples.row(1)).unwrap();
    drop(writer);
    assert_eq!(Recording::read(&target).unwrap(), source);

    std::fs::write(target.join("thesis.txt"), "precious").unwrap();
    assert!(
        source
            .write(&target, Existing::ReplaceRecording)
            .unwrap_err()
            .found
            .contains("thesis.txt")
    );
}

/// Of several writers that begin at once at most one may go on, none takes another's rows away, and the rest say why.
#[test]
fn of_writers_that_begin_at_once_one_at_most_goes_on() {
    let source = read(META, b"t_s,run,p1_m\n0,a,1e-3\n").unwrap();
    let folder = tempfile::tempdir().unwrap();
    let writers = 8;
    let begin = std::sync::Barrier::new(writers);
    for round in 0..100 {
        let target = folder.path().join(round.to_string());
        std::fs::create_dir(&target).unwrap();
        let one = || {
            begin.wait();
            let writer = Writer::create(&target, &source.meta, Existing::Refuse);
            // All are at it at the same time.
            begin.wait();
            let mut writer = writer.map_err(|error| error.to_string())?;
            writer.push(&source.samples.row(0)).unwrap();
            writer.finish().unwrap();
            Ok::<(), String>(())
        };
        let ended: Vec<Result<(), String>> = std::thread::scope(|scope| {
            let threads: Vec<_> = (0..writers).map(|_| scope.spawn(one)).collect();
            let ended = threads.into_iter().map(|thread| thread.join().unwrap());
            ended.collect()
        });
        let refused: Vec<&String> = ended.iter().filter_map(|one| one.as_ref().err()).collect();
        assert!(refused.len() >= writers - 1, "{round}: {ended:?}");
        for line in refused {
            assert!(line.contains("another command is writing"), "{line}");
        }
        assert_eq!(
            Recording::read(&target).is_ok(),
            ended.iter().any(Result::is_ok)
        );
    }
}

#[test]
fn a_writer_refuses_what_a_reader_would() {
    let source = read(META, b"t_s,run,p1_m\n0,a,1e-3\n").unwrap();
    let parent = tempfile::tempdir().unwrap();
    let target = parent.path().join("new");
    let mut meta = source.meta.clone();
    meta.electronics.position_noise_m = None;
    assert!(
        Recording {
            meta,
            ..source.clone()
        }
        .write(&target, Existing::Refuse)
        .is_err()
    );
    let mut writer = Writer::create(&target, &source.meta, Existing::Refuse).unwrap();
    let row = recording::Row {
        position_m: [Some(f64::NAN), None, None, None],
        ..source.samples.row(0)
    };
    assert_eq!(
        writer.push(&row).unwrap_err().column.as_deref(),
        Some("p1_m")
    );
    drop(writer);
    assert!(!target.exists());
}
