//! The board's end of the command channel: bytes in, checked actions for the background out. Pure, never panics, never blocks.

use super::framing::{Decoder, FrameCounters, FrameError};
use super::message::{Action, Command, FRAME_BYTES, Hello, PROTOCOL, Reply, Request, Response};
use super::refusal::Refusal;

/// What a byte has brought.
#[derive(Clone, Debug, PartialEq)]
// As for `Action`.
#[allow(clippy::large_enum_variant)]
pub enum Event {
    /// To be carried out, and answered under this number.
    Act {
        /// The request's.
        number: u16,
        /// Checked by [`Action::validate`].
        action: Action,
    },
    /// To be sent as it is.
    Answer(Response),
}

/// Takes requests apart. Until a host has said hello in this protocol version, nothing else is done for it.
#[derive(Clone, Debug)]
pub struct Server {
    decoder: Decoder<FRAME_BYTES>,
    hello: Hello,
    greeted: bool,
}

impl Server {
    /// For a board that introduces itself so; its protocol version is set here.
    pub fn new(hello: Hello) -> Self {
        Self {
            decoder: Decoder::new(),
            hello: Hello {
                protocol: PROTOCOL,
                ..hello
            },
            greeted: false,
        }
    }

    /// Takes one byte of the command channel.
    #[inline(never)]
    pub fn feed(&mut self, byte: u8) -> Option<Event> {
        match self.decoder.feed::<Request>(byte)? {
            Ok(request) => Some(self.serve(request)),
            // Noise is counted and not answered: there may be nobody who asked.
            Err(FrameError::Unknown) => Some(refuse(0, Refusal::Unknown)),
            Err(_) => None,
        }
    }

    /// Frames seen so far.
    pub const fn counters(&self) -> FrameCounters {
        self.decoder.counters()
    }

    fn serve(&mut self, request: Request) -> Event {
        let number = request.number;
        match request.command {
            Command::Hello { protocol } => {
                self.greeted = protocol == PROTOCOL;
                Event::Answer(Response {
                    number,
                    reply: Reply::Hello(self.hello.clone()),
                })
            }
            Command::Do(_) if !self.greeted => {
                refuse(number, Refusal::NotGreeted { protocol: PROTOCOL })
            }
            Command::Do(action) => match action.validate() {
                Ok(()) => Event::Act { number, action },
                Err(refusal) => refuse(number, refusal),
            },
        }
    }
}

fn refuse(number: u16, refusal: Refusal) -> Event {
    Event::Answer(Response {
        number,
        reply: Reply::Refused(refusal),
    })
}
