//! Text into rows of fields, in buffers of fixed size.

use crate::error::Error;
use csv_core::ReadRecordResult;
use std::path::Path;

/// Longest row, bytes; and most columns in it.
const ROW_LIMIT_BYTES: usize = 1 << 16;
const COLUMN_LIMIT: usize = 1024;

/// The fields of one row, in the parser's buffers.
#[derive(Clone, Copy)]
pub(crate) struct Fields<'a> {
    text: &'a [u8],
    ends: &'a [usize],
}

impl<'a> Fields<'a> {
    pub(crate) fn len(&self) -> usize {
        self.ends.len()
    }

    pub(crate) fn iter(&self) -> impl Iterator<Item = &'a [u8]> + use<'a> {
        let (text, ends) = (self.text, self.ends);
        (0..ends.len())
            .map(move |place| &text[if place == 0 { 0 } else { ends[place - 1] }..ends[place]])
    }
}

/// Splits chunks of text into rows of fields, in buffers of fixed size.
pub(crate) struct Rows {
    parser: csv_core::Reader,
    text: Vec<u8>,
    text_length: usize,
    ends: Vec<usize>,
    ends_length: usize,
    line: u64,
}

impl Rows {
    pub(crate) fn new() -> Self {
        Self {
            parser: csv_core::Reader::new(),
            text: vec![0; ROW_LIMIT_BYTES],
            text_length: 0,
            ends: vec![0; COLUMN_LIMIT],
            ends_length: 0,
            line: 1,
        }
    }

    /// Calls `on_row` with the fields and the line of every row that `chunk` ends. An empty chunk is the end.
    pub(crate) fn feed(
        &mut self,
        mut chunk: &[u8],
        mut on_row: impl FnMut(Fields, u64) -> Result<(), Error>,
        file: &Path,
    ) -> Result<(), Error> {
        loop {
            let (text, ends) = (
                &mut self.text[self.text_length..],
                &mut self.ends[self.ends_length..],
            );
            let (result, read, written, ended) = self.parser.read_record(chunk, text, ends);
            chunk = &chunk[read..];
            self.text_length += written;
            self.ends_length += ended;
            match result {
                ReadRecordResult::InputEmpty if chunk.is_empty() => return Ok(()),
                ReadRecordResult::InputEmpty => {}
                ReadRecordResult::End => return Ok(()),
                ReadRecordResult::OutputFull => {
                    let found = format!("more than {ROW_LIMIT_BYTES} bytes");
                    return Err(Error::new(
                        file,
                        found,
                        "a row of numbers (is a quotation mark left open?)",
                    )
                    .row(self.line));
                }
                ReadRecordResult::OutputEndsFull => {
                    let found = format!("more than {COLUMN_LIMIT} fields");
                    return Err(
                        Error::new(file, found, "a row of the layout's columns").row(self.line)
                    );
                }
                ReadRecordResult::Record => {
                    on_row(
                        Fields {
                            text: &self.text,
                            ends: &self.ends[..self.ends_length],
                        },
                        self.line,
                    )?;
                    (self.text_length, self.ends_length) = (0, 0);
                    self.line = self.parser.line();
                }
            }
        }
    }
}
