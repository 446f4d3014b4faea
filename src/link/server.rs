//! The board's end of the command channel: bytes in, checked actions for the background out. Pure, never panics, never blocks.

use super::framing::{Decoder, FrameCounters, FrameError};
use super::message::{Action, Command, FRAME_BYTES, Hello, PROTOCOL, Reply, Request, Response};
use super::refusal::{RecordRefusal, Refusal};
use crate::calibration::record::{self, Calibration};

/// What a byte has brought.
#[derive(Clone, Debug, PartialEq)]
pub enum Event {
    /// To be carried out, and answered under this number.
    Act {
        /// The request's.
        number: u16,
        /// Checked by [`Action::validate`]. What is to be loaded is got by [`Server::loaded`].
        action: Action<()>,
    },
    /// To be sent as it is.
    Answer(Response<&'static Calibration>),
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
        let loads =
            |request: &Request<()>| matches!(request.command, Command::Do(Action::Load { .. }));
        match self.decoder.feed_head::<Request<()>>(byte, loads)? {
            Ok(request) => Some(self.serve(request)),
            // Noise is counted and not answered: there may be nobody who asked.
            Err(FrameError::Unknown) => Some(refuse(0, Refusal::Unknown)),
            Err(_) => None,
        }
    }

    /// Decodes the calibration of the [`Action::Load`] that was just fed.
    ///
    /// # Errors
    /// [`Refusal::Calibration`]; `place` is then of no use.
    pub fn loaded(&self, place: &mut Calibration) -> Result<(), Refusal> {
        let whole = record::read_body(self.decoder.rest(), place).map(|rest| rest.is_empty());
        if whole != Some(true) {
            return Err(Refusal::Calibration(RecordRefusal::Invalid));
        }
        place
            .validate()
            .map_err(|error| Refusal::Calibration(error.into()))
    }

    /// Frames seen so far.
    pub const fn counters(&self) -> FrameCounters {
        self.decoder.counters()
    }

    fn serve(&mut self, request: Request<()>) -> Event {
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
