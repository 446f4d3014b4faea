//! What a monitor sees, written while it runs: each second is whole on the disk before the next begins.

use crate::cdr::Packer;
use crate::seen::{CHANNELS, ENCODINGS, State, time_ns};
use mcap::records::MessageHeader;
use mcap::{McapResult, WriteOptions, Writer};
use std::collections::BTreeMap;
use std::fs::File;
use std::io::BufWriter;

/// After so long a time what is written is made whole: a cut loses less than that.
const FLUSH_S: f64 = 1.0;

/// A file that grows.
pub struct Live {
    writer: Writer<BufWriter<File>>,
    packer: Packer,
    channels: Vec<u16>,
    /// Time zero of the board, ns since 1970.
    zero_ns: u64,
    flushed_s: f64,
    sequence: u32,
}

impl Live {
    /// Begins a file. `zero_ns` is when the board's time was zero, ns since 1970.
    ///
    /// # Errors
    /// A failure to write.
    pub fn begin(file: File, zero_ns: u64) -> McapResult<Self> {
        let options = WriteOptions::new()
            .profile("ros2")
            .library(concat!("courier ", env!("CARGO_PKG_VERSION")));
        let mut writer = options.create(BufWriter::new(file))?;
        let [of_schema, of_values] = ENCODINGS;
        let channels = CHANNELS.iter().map(|channel| {
            let text = channel.definition.as_bytes();
            let schema = writer.add_schema(channel.name, of_schema, text)?;
            writer.add_channel(schema, channel.topic, of_values, &BTreeMap::new())
        });
        let channels = channels.collect::<McapResult<_>>()?;
        // Not made whole yet: a chunk without messages has the time 0, and what draws the file would begin in 1970.
        Ok(Self {
            writer,
            packer: Packer::default(),
            channels,
            zero_ns,
            flushed_s: f64::NEG_INFINITY,
            sequence: 0,
        })
    }

    /// Adds a state.
    ///
    /// # Errors
    /// A failure to write.
    pub fn push(&mut self, state: &State) -> McapResult<()> {
        let log_time = time_ns(state, self.zero_ns);
        for (channel, id) in CHANNELS.iter().zip(&self.channels) {
            self.packer.clear();
            (channel.pack)(state, log_time, &mut self.packer);
            let header = MessageHeader {
                channel_id: *id,
                sequence: self.sequence,
                log_time,
                publish_time: log_time,
            };
            let bytes = self.packer.bytes();
            self.writer.write_to_known_channel(&header, bytes)?;
        }
        self.sequence = self.sequence.wrapping_add(1);
        if state.t_s >= self.flushed_s + FLUSH_S {
            self.writer.flush()?;
            self.flushed_s = state.t_s;
        }
        Ok(())
    }

    /// Ends the file with its index.
    ///
    /// # Errors
    /// A failure to write.
    pub fn end(mut self) -> McapResult<()> {
        self.writer.finish().map(drop)
    }
}
