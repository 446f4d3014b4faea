//! What the host and the program that models the chip say to each other, over that program's standard input and output.
//!
//! The model is under another licence and a program of its own; these messages are all that both know. Each is a length in four bytes,
//! the least significant first, and so many bytes of postcard. The host gives an order; the model answers it, and may ask before, since
//! all that is outside the chip is the host's: one question at a time, and nothing goes on until its answer has come.
//!
//! ```text
//! host    Order ──▶             Answer ──▶
//! model            ◀── Question            ◀── Done
//! ```

use anyhow::{Context, Result, ensure};
use serde::de::DeserializeOwned;
use serde::{Deserialize, Serialize};
use std::io::{Read, Write};

/// Longest message: the contents of a flash bank of 256 KiB with its flags, and room to spare.
const LONGEST_BYTES: usize = 1 << 20;

/// Channels of a converter chip.
pub const CHANNELS: usize = 8;
/// Counts at both chips' inputs, `[chip][channel]`.
pub type Inputs = [[i16; CHANNELS]; 2];
/// Bytes of a serial line, each with an instant in nanoseconds.
pub type Timed = Vec<(u64, u8)>;

/// What the host wants.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Order {
    /// Switch the chip on; it has this number. Answer: [`Done::Nothing`].
    Start {
        /// The chip's own number.
        number: [u8; 12],
    },
    /// Let it run for so long. Answer: [`Done::Ran`].
    Run {
        /// Nanoseconds.
        ns: u64,
    },
    /// Look at bank 2 again: it was changed otherwise than by the chip. Answer: [`Done::Nothing`].
    LookAtBank,
    /// Take bytes that the board has sent. Answer: [`Done::Bytes`].
    Receive {
        /// The ring.
        channel: u8,
        /// How many at most.
        most: u32,
    },
    /// Give the board bytes. Answer: [`Done::Taken`].
    Send {
        /// The bytes.
        bytes: Vec<u8>,
    },
}

/// The end of an order.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Done {
    /// It is done.
    Nothing,
    /// The chip has run.
    Ran {
        /// Rules of the chip's manuals that the image has broken meanwhile, a line each.
        broken: Vec<String>,
    },
    /// What the board has sent.
    Bytes(Vec<u8>),
    /// So many bytes were taken.
    Taken(u32),
    /// It cannot be done.
    Failed(String),
}

/// What the model wants to know before it goes on.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Question {
    /// The chip meets what is around it. Answer: [`Answer::Met`].
    Meet {
        /// The instant, nanoseconds since the start.
        now_ns: u64,
        /// Bytes that have gone to the motion controller since the meeting before: the instants of their start bits.
        sent: Timed,
        /// A conversion begins.
        convst: Convst,
    },
    /// The flash controller erases the page at this offset of bank 2. Answer: [`Answer::Flash`].
    Erase(u32),
    /// It programs the double word at this offset. Answer: [`Answer::Flash`].
    Program(u32, [u8; 8]),
    /// The supply has come. Answer: [`Answer::Bank`].
    PowerUp,
    /// What bank 2 holds now. Answer: [`Answer::Bank`].
    Bank,
}

/// Whether a conversion begins, and by whom.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Convst {
    /// None.
    No,
    /// By software: the self-test at the start.
    ByHand,
    /// By the timer: a sampling instant.
    ByTimer,
}

/// What the host answers.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub enum Answer {
    /// What is around the chip.
    Met {
        /// What stands at the converters' inputs, if a conversion begins; none if the converters have no supply.
        inputs: Option<Inputs>,
        /// Bytes from the motion controller, also such as are still to come: the instants at which they have arrived.
        coming: Timed,
        /// Temperature of the board, degrees Celsius.
        temperature_c: f64,
        /// Whether a reference mark grounds its input.
        at_mark: bool,
    },
    /// How the flash's operation ended.
    Flash(FlashEnd),
    /// What bank 2 holds: bytes, and of each double word whether it is programmed and whether it is torn.
    Bank {
        /// The bytes.
        bytes: Vec<u8>,
        /// Whether each double word is programmed.
        programmed: Vec<bool>,
        /// Whether each double word is torn.
        torn: Vec<bool>,
    },
}

/// How an operation of the flash ends.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum FlashEnd {
    /// As it should.
    Well,
    /// The double word has been programmed before.
    WrittenTwice,
    /// The supply has gone in the middle.
    Off,
    /// Not well.
    Failed,
}

/// What the model says: a question, or the end of an order.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Said {
    /// A question.
    Question(Question),
    /// The end of the order.
    Done(Done),
}

/// Sends a message.
///
/// # Errors
/// The other side has gone.
pub fn send(to: &mut impl Write, message: &impl Serialize) -> Result<()> {
    let mut bytes = vec![0; 4];
    bytes = postcard::to_extend(message, bytes).context("a message to the chip's model")?;
    let length = (bytes.len() - 4) as u32;
    bytes[..4].copy_from_slice(&length.to_le_bytes());
    to.write_all(&bytes)?;
    to.flush()?;
    Ok(())
}

/// Waits for a message.
///
/// # Errors
/// The other side has gone, or what it says is no message.
pub fn receive<T: DeserializeOwned>(from: &mut impl Read) -> Result<T> {
    let mut length = [0; 4];
    from.read_exact(&mut length)?;
    let length = u32::from_le_bytes(length) as usize;
    ensure!(
        length <= LONGEST_BYTES,
        "found a message of {length} bytes, wanted at most {LONGEST_BYTES}"
    );
    let mut bytes = vec![0; length];
    from.read_exact(&mut bytes)?;
    postcard::from_bytes(&bytes).context("a message of the chip's model")
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn messages_arrive_as_they_were_sent_one_after_the_other() {
        let first = Said::Question(Question::Meet {
            now_ns: 1 << 40,
            sent: vec![(7, 0xAA)],
            convst: Convst::ByTimer,
        });
        let second = Said::Done(Done::Bytes(vec![1, 2, 3]));
        let mut line = vec![];
        for message in [&first, &second] {
            send(&mut line, message).expect("room");
        }
        let mut line = &*line;
        for message in [first, second] {
            assert_eq!(receive::<Said>(&mut line).expect("whole"), message);
        }
        assert!(receive::<Said>(&mut line).is_err(), "nothing is left");
    }

    #[test]
    fn a_length_beyond_all_messages_is_refused() {
        let line = [0xFF; 8];
        let error = receive::<Said>(&mut &line[..]).unwrap_err().to_string();
        assert!(error.contains("4294967295"), "{error}");
    }
}
