//! A file from its first record to its last, as far as it goes.

use mcap::read::ChannelAccumulator;
use mcap::records::Record;
use mcap::sans_io::linear_reader::{LinearReadEvent, LinearReader, LinearReaderOptions};
use recording::Error;
use std::fs::File;
use std::io::{BufReader, Read};
use std::path::Path;
use std::sync::Arc;

/// What a file should be that cannot be read.
const WANTED: &str = "an MCAP file";
/// What those begin with.
const MARK: &[u8] = b"\x89MCAP0\r\n";
/// Longest text of the library's that is told, characters.
const LONGEST: usize = 120;
/// A longer record, or a chunk with more in it, is a spoilt length: programs write chunks of some megabytes. Bytes.
const LONGEST_RECORD: usize = 1 << 28;
/// Bytes that are read at once.
const READ_AT_ONCE: usize = 1 << 20;

/// A message and where it belongs.
pub(crate) struct Message<'a> {
    pub channel: Arc<mcap::Channel<'static>>,
    pub time_ns: u64,
    pub data: &'a [u8],
}

/// Shows every message and attachment of a file to `message` and `attachment`, in order. Tells whether the file has its end; what comes
/// after the last whole chunk of one that was cut is lost.
///
/// # Errors
/// It is no such file, or one of the two refuses.
pub(crate) fn walk(
    path: &Path,
    mut from: impl Read,
    mut attachment: impl FnMut(&str, &[u8]) -> Result<(), Error>,
    mut message: impl FnMut(Message) -> Result<(), Error>,
) -> Result<bool, Error> {
    let failed = |error: std::io::Error| Error::new(path, error.to_string(), WANTED);
    let mut mark = Vec::new();
    from.by_ref()
        .take(MARK.len() as u64)
        .read_to_end(&mut mark)
        .map_err(failed)?;
    if mark != MARK {
        return Err(Error::new(path, recording::excerpt(&mark), WANTED));
    }
    let options = LinearReaderOptions::default()
        .with_skip_start_magic(true)
        .with_skip_end_magic(true);
    let options = options
        .with_prevalidate_chunk_crcs(true)
        .with_record_length_limit(LONGEST_RECORD);
    let mut reader = LinearReader::new_with_options(options);
    let mut channels = ChannelAccumulator::default();
    while let Some(event) = reader.next_event() {
        let record = match event {
            Ok(LinearReadEvent::ReadRequest(wanted)) => {
                let read = from
                    .read(reader.insert(wanted.min(READ_AT_ONCE)))
                    .map_err(failed)?;
                reader.notify_read(read);
                continue;
            }
            Ok(LinearReadEvent::Record { data, opcode }) => mcap::parse_record(opcode, data),
            // Cut, or spoilt from here on.
            Err(_) => return Ok(false),
        };
        let told = |error: mcap::McapError| {
            let text: String = error
                .to_string()
                .chars()
                .filter(|letter| !letter.is_control())
                .take(LONGEST)
                .collect();
            Error::new(path, format!("\"{text}\""), WANTED)
        };
        match record.map_err(told)? {
            Record::Schema { header, data } => {
                let data = data.into_owned().into();
                channels.add_schema(header, data).map_err(told)?;
            }
            Record::Channel(channel) => channels.add_channel(channel).map_err(told)?,
            Record::Message { header, data } => {
                let Some(channel) = channels.get(header.channel_id) else {
                    continue;
                };
                message(Message {
                    channel,
                    time_ns: header.log_time,
                    data: &data,
                })?;
            }
            Record::Attachment { header, data, .. } => attachment(&header.name, &data)?,
            // What follows says again what is before it.
            Record::DataEnd(_) => return Ok(true),
            _ => {}
        }
    }
    Ok(false)
}

/// A file to read.
///
/// # Errors
/// It cannot be read.
pub(crate) fn open(path: &Path) -> Result<BufReader<File>, Error> {
    let file = File::open(path).map_err(|error| Error::new(path, error.to_string(), WANTED))?;
    Ok(BufReader::new(file))
}
