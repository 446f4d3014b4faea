//! What a host says of an update, and what the board answers.

use super::header;
use super::install::Progress;
use super::version::Version;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Bytes of the body that one order carries: whole double words, and no longer than the nodes of a tooth map.
pub const PIECE_BYTES: usize = 384;

/// An order.
#[derive(Clone, Debug, PartialEq, Eq, Serialize, Deserialize)]
#[allow(clippy::large_enum_variant)] // one exists at a time, as for `Action`
pub enum UpdateOrder {
    /// How does it stand?
    Status,
    /// Begin: the other bank's image is given up for this one.
    Begin {
        /// The new image's header.
        header: Vec<u8, { header::BYTES }>,
        /// It may be older than what runs.
        allow_older: bool,
    },
    /// The next bytes of its body.
    Piece {
        /// Where they go.
        offset: u32,
        /// Whole double words.
        bytes: Vec<u8, PIECE_BYTES>,
    },
    /// The body is complete: check it, and install it if it is right. [`UpdateOrder::Status`] tells how that went.
    Finish,
    /// The image that runs works: keep it.
    Accept,
    /// It does not: go back at the next restart.
    Refuse,
}

/// How an update stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct UpdateStatus {
    /// The version that runs.
    pub running: Version,
    /// Seconds that it has left to be accepted, if it is on trial.
    pub trial_left_s: Option<u32>,
    /// It trusts the development key, with which anybody can sign.
    pub development_key: bool,
    /// The image that is being taken in.
    pub progress: Progress,
}
