//! Writing a recording: the attachment that makes it one, then a message a sample.

use crate::cdr::Packer;
use crate::read::is_recording;
use crate::{META_NAME, SAMPLES};
use mcap::records::{MessageHeader, Metadata};
use mcap::{Attachment, McapResult, WriteOptions};
use recording::{COLUMNS, Column, Error, Existing, Meta, Samples, check_existing_file, write_file};
use std::borrow::Cow;
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;
use std::path::Path;

/// Name of the definition of a sample.
pub(crate) const SAMPLE: &str = "courier/msg/Sample";
/// Bytes of samples that are compressed together: the library's own is 786,432; Foxglove reads a chunk at a time.
const CHUNK_BYTES: u64 = 1 << 20;

/// Writes a recording that [`recording::Writer`] or [`recording::Recording::check`] has checked.
///
/// # Errors
/// `existing` forbids it, or a failure to write; nothing is left behind.
pub fn write(meta: &Meta, samples: &Samples, path: &Path, existing: Existing) -> Result<(), Error> {
    check_existing(path, existing)?;
    let replace = existing == Existing::ReplaceRecording;
    write_file(path, replace, |file| {
        fill(file, meta, samples).map_err(|error| error.to_string())
    })
}

/// Refuses a file that `existing` forbids to replace, and a place where no file can be.
///
/// # Errors
/// Something else than a recording is there, or there is anything and nothing may be replaced.
pub fn check_existing(path: &Path, existing: Existing) -> Result<(), Error> {
    check_existing_file(path, existing, is_recording)
}

/// One value of each message.
enum Part<'a> {
    Run,
    Number(Cow<'a, str>, &'a [f64]),
    /// The unmodified output of a segment, which follows from its counts: for looking at, and not read back.
    Output(usize),
}

impl Part<'_> {
    fn definition(&self) -> String {
        match self {
            Self::Run => "string run\n".into(),
            Self::Number(name, _) => format!("float64 {name}\n"),
            Self::Output(segment) => format!("float32 output{}_m\n", segment + 1),
        }
    }
}

fn parts(samples: &Samples) -> Vec<Part<'_>> {
    let needed = |column: Column| column.companions().iter().any(|one| samples.has(*one));
    let mut parts: Vec<Part> = COLUMNS
        .into_iter()
        .filter(|(column, _)| needed(*column))
        .map(|(column, name)| Part::Number(name.into(), samples.column(column)))
        .collect();
    parts.extend(
        samples
            .logged()
            .iter()
            .map(|logged| Part::Number(logged.name.as_str().into(), &logged.values)),
    );
    parts.extend(
        (0..4)
            .filter(|segment| samples.has(Column::Sine(*segment)))
            .map(Part::Output),
    );
    // Behind the numbers, which then all stand at multiples of their size.
    if samples.run_names().iter().any(|name| !name.is_empty()) {
        parts.push(Part::Run);
    }
    parts
}

fn fill(file: File, meta: &Meta, samples: &Samples) -> McapResult<()> {
    let options = WriteOptions::new()
        .profile("ros2")
        .library(concat!("courier ", env!("CARGO_PKG_VERSION")))
        .chunk_size(Some(CHUNK_BYTES));
    let mut writer = options.create(BufWriter::new(file))?;
    writer.attach(&Attachment {
        log_time: 0,
        create_time: 0,
        name: META_NAME.into(),
        media_type: "application/toml".into(),
        data: Cow::Owned(meta.to_toml().into_bytes()),
    })?;
    let said = [
        ("courier_id", &meta.names.courier_id),
        ("platen_id", &meta.names.platen_id),
        ("beacon_id", &meta.names.beacon_id),
        ("firmware", &meta.names.firmware),
    ];
    let said: BTreeMap<String, String> = said
        .into_iter()
        .filter(|(_, text)| !text.is_empty())
        .map(|(key, text)| (key.to_owned(), text.clone()))
        .collect();
    if !said.is_empty() {
        writer.write_metadata(&Metadata {
            name: "courier".into(),
            metadata: said,
        })?;
    }
    let parts = parts(samples);
    let definition: String = parts.iter().map(Part::definition).collect();
    let schema = writer.add_schema(SAMPLE, "ros2msg", definition.as_bytes())?;
    let channel_id = writer.add_channel(schema, SAMPLES, "cdr", &BTreeMap::new())?;
    let t_s = samples.t_s();
    let first_s = t_s.first().copied().unwrap_or(0.0).min(0.0);
    let mut packer = Packer::default();
    for row in 0..samples.len() {
        packer.clear();
        for part in &parts {
            match part {
                Part::Run => packer.string(samples.run(row)),
                Part::Number(_, values) => {
                    packer.float64(values.get(row).copied().unwrap_or(f64::NAN))
                }
                Part::Output(segment) => {
                    packer.float32(output_m(meta, samples, *segment, row) as f32)
                }
            }
        }
        // MCAP's times are whole and not negative; the sample's own time is in its message.
        let log_time = ((t_s[row] - first_s) * 1e9).round() as u64;
        writer.write_to_known_channel(
            &MessageHeader {
                channel_id,
                sequence: row as u32,
                log_time,
                publish_time: log_time,
            },
            packer.bytes(),
        )?;
    }
    writer.finish().map(drop)
}

/// `n·ρ + ρ/2π·atan2(qs, qc)`, as docs/recording.md has it.
fn output_m(meta: &Meta, samples: &Samples, segment: usize, row: usize) -> f64 {
    let of = |column: Column| samples.column(column).get(row).copied().unwrap_or(f64::NAN);
    let pitch_m = meta.geometry.pitch_m;
    let phase = of(Column::Sine(segment)).atan2(of(Column::Cosine(segment)));
    of(Column::Teeth(segment)) * pitch_m + pitch_m * phase / std::f64::consts::TAU
}
