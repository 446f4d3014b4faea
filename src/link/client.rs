//! The host's end of the command channel: numbered requests out, their replies in. Pure: how bytes travel is the caller's matter.

use super::framing::{self, Decoder, FrameCounters, TooLong};
use super::message::{Action, Command, FRAME_BYTES, PROTOCOL, Request, Response};

/// Numbers requests and takes replies apart.
#[derive(Clone, Debug, Default)]
pub struct Client {
    decoder: Decoder<FRAME_BYTES>,
    number: u16,
}

impl Client {
    /// Before the first request.
    pub const fn new() -> Self {
        Self {
            decoder: Decoder::new(),
            number: 0,
        }
    }

    /// Bytes of a hello, and its number.
    ///
    /// # Errors
    /// [`TooLong`] for a buffer below 16 bytes.
    pub fn hello<'b>(&mut self, buffer: &'b mut [u8]) -> Result<(u16, &'b [u8]), TooLong> {
        self.request(Command::Hello { protocol: PROTOCOL }, buffer)
    }

    /// Bytes of a request, and its number.
    ///
    /// # Errors
    /// [`TooLong`]; [`FRAME_BYTES`] are always enough.
    pub fn ask<'b>(
        &mut self,
        action: Action,
        buffer: &'b mut [u8],
    ) -> Result<(u16, &'b [u8]), TooLong> {
        self.request(Command::Do(action), buffer)
    }

    /// Takes one byte of the reply channel. Broken frames are counted and give nothing.
    pub fn feed(&mut self, byte: u8) -> Option<Response> {
        self.decoder.feed::<Response>(byte)?.ok()
    }

    /// Frames seen so far.
    pub const fn counters(&self) -> FrameCounters {
        self.decoder.counters()
    }

    fn request<'b>(
        &mut self,
        command: Command,
        buffer: &'b mut [u8],
    ) -> Result<(u16, &'b [u8]), TooLong> {
        self.number = self.number.checked_add(1).unwrap_or(1);
        let number = self.number;
        Ok((
            number,
            framing::encode(&Request { number, command }, buffer)?,
        ))
    }
}
