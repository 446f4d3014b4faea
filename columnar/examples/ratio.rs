//! What a recording costs as a Parquet file against its folder: bytes, and seconds to write and to read.
//! `cargo run --release -p columnar --example ratio -- FOLDER`

use recording::{Existing, Recording};
use std::path::{Path, PathBuf};
use std::time::Instant;

type Failure = Box<dyn std::error::Error>;

fn timed<T, E>(what: impl FnOnce() -> Result<T, E>) -> Result<(T, f64), E> {
    let begin = Instant::now();
    let done = what()?;
    Ok((done, begin.elapsed().as_secs_f64()))
}

fn main() -> Result<(), Failure> {
    let folder = PathBuf::from(
        std::env::args()
            .nth(1)
            .ok_or("wanted a recording's folder")?,
    );
    let new = tempfile::tempdir()?;
    let (file, again) = (new.path().join("a.parquet"), new.path().join("again"));
    let (recording, csv_read_s) = timed(|| Recording::read(&folder))?;
    let ((), csv_write_s) = timed(|| recording.write(&again, Existing::Refuse))?;
    let ((), write_s) = timed(|| {
        recording.check(Path::new("samples"))?;
        columnar::write(&recording.meta, &recording.samples, &file, Existing::Refuse)
    })?;
    let (read, read_s) = timed(|| columnar::read(&file))?;
    let compact = new.path().join("b.parquet");
    let ((), compact_s) = timed(|| {
        columnar::write_compact(
            &recording.meta,
            &recording.samples,
            &compact,
            Existing::Refuse,
        )
    })?;
    let (again_read, compact_read_s) = timed(|| columnar::read(&compact))?;
    assert!(
        again_read.samples == recording.samples,
        "the samples are the same"
    );
    assert!(
        read.samples == recording.samples,
        "the samples are the same"
    );
    let csv_bytes = std::fs::metadata(again.join("samples.csv"))?.len();
    let bytes = std::fs::metadata(&file)?.len();
    println!(
        "{} samples; {bytes} bytes against {csv_bytes}: 1/{:.1}; written in {write_s:.2} s against {csv_write_s:.2}; read in {read_s:.2} s against {csv_read_s:.2}",
        recording.samples.len(),
        csv_bytes as f64 / bytes as f64
    );
    let bytes = std::fs::metadata(&compact)?.len();
    println!(
        "compact: {bytes} bytes: 1/{:.1}; written in {compact_s:.2} s, read in {compact_read_s:.2} s",
        csv_bytes as f64 / bytes as f64
    );
    let samples = &recording.samples;
    for (whose, before) in [
        ("Parquet's encodings", columnar::BY_PARQUET),
        ("the noise", columnar::BY_ANY_FORM),
    ] {
        let columns = recording::COLUMNS
            .iter()
            .map(|(column, _)| samples.column(*column));
        let logged = samples
            .logged()
            .iter()
            .map(|logged| logged.values.as_slice());
        let bits = |values: &[f64]| columnar::least_bits(values, before);
        let least = columns.chain(logged).map(bits).sum::<f64>() / 8.0;
        println!(
            "least by {whose}: {least:.0} bytes: 1/{:.1}",
            csv_bytes as f64 / least
        );
    }
    Ok(())
}
