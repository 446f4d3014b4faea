//! Taking an image in: erased, programmed, checked and only then given its header, by which the first stage knows it.
//!
//! ```text
//! begin: header checked, its page and the journal erased -> data: body programmed in its order, pages erased as they are reached
//!        -> finish -> work: body read back, CRC and signature -> number programmed -> header programmed: installed
//! ```
//! A cut at any place before the header's end leaves a bank without an image. The number comes before the header, so that only what a
//! debug probe has put there is an image without a number.

use super::header::{self, CRC32, Header, HeaderError};
use super::journal::{self, MarkError};
use super::key::PublicKey;
use super::layout::{BANK_BYTES, BODY_START, IMAGE_START, JOURNAL_START, PAGE_BYTES, WORD_BYTES};
use super::standing::Bank;
use super::version::Version;
use crc::Digest;
use ed25519_compact::{PublicKey as Verifier, Signature, VerifyingState};
use embedded_storage::nor_flash::NorFlash;
use serde::{Deserialize, Serialize};

/// Bytes read back in one slice of [`Install::work`]: some 250 cycles each (docs/update.md), so 0.4 ms of the sensor board's time.
const SLICE_BYTES: u32 = 256;
const PIECE_BYTES: usize = 128;

/// What an image must be like.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Rules {
    /// Name of this board, as a header has it.
    pub board: [u8; 16],
    /// The version that runs.
    pub version: Version,
    /// The key that is trusted.
    pub key: PublicKey,
    /// An older version may be installed.
    pub allow_older: bool,
}

/// Why an image is not taken. Whatever was started before still is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[non_exhaustive]
pub enum UpdateRefusal {
    /// The board has no first stage, or no second bank of flash.
    #[error("this board takes no firmware over its link: write it with a debug probe")]
    NotOffered,
    /// Its header is none, or damaged.
    #[error("the image has no header that can be used")]
    Header,
    /// It is another board's.
    #[error("the image is for another board")]
    OtherBoard,
    /// Its signature is by a key that is not trusted here.
    #[error("the image is signed with a key that the board's firmware does not trust")]
    OtherKey,
    /// It is older than what runs.
    #[error("the image is version {found}, older than {running}, which runs")]
    Older {
        /// Its version.
        found: Version,
        /// The version that runs.
        running: Version,
    },
    /// Nothing was begun.
    #[error("no update is under way")]
    NotBegun,
    /// Bytes at another place than the next.
    #[error("bytes from {found} on, wanted from {wanted} on")]
    Offset {
        /// Where they were to go.
        found: u32,
        /// Where they are to go.
        wanted: u32,
    },
    /// Bytes beyond the end of the body, or not whole double words.
    #[error("a piece of {found} bytes, wanted whole double words up to the end of the image")]
    Length {
        /// How many there were.
        found: u32,
    },
    /// It is not there as a whole.
    #[error("{found} bytes of the image, wanted {wanted}")]
    Incomplete {
        /// Bytes that were taken.
        found: u32,
        /// Bytes of the body.
        wanted: u32,
    },
    /// What is read back has another check value.
    #[error("the image is damaged: its check value is wrong")]
    Damaged,
    /// The signature is wrong.
    #[error("the image's signature is wrong")]
    Signature,
    /// The flash does not erase, or does not take it.
    #[error("the flash does not take the image")]
    Flash,
    /// The image that runs was not accepted yet: the other bank holds the one to go back to.
    #[error("the image that runs is on trial: accept it first, or restart the board to go back")]
    OnTrial,
    /// The image that runs is not on trial.
    #[error("no image is on trial")]
    NotOnTrial,
    /// The calibration could not be moved.
    #[error("the calibration could not be moved into the other bank of the flash")]
    NotMoved,
    /// A calibration cannot begin: the flash pages that an update erases would take the time in which a pose's frames are averaged.
    #[error(
        "an update is under way: let `courier update` finish, or restart the board with `courier reset` to give it up"
    )]
    UnderWay,
    /// The courier is moving by an order.
    #[error("the courier is moving: wait until it stands")]
    Moving,
}

impl From<HeaderError> for UpdateRefusal {
    fn from(_: HeaderError) -> Self {
        Self::Header
    }
}

impl From<MarkError> for UpdateRefusal {
    fn from(_: MarkError) -> Self {
        Self::Flash
    }
}

/// How far it is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub enum Progress {
    /// Nothing is under way.
    #[default]
    Idle,
    /// So many bytes of the body are there.
    Receiving {
        /// Where the next are to go.
        next: u32,
        /// Bytes of the body.
        of: u32,
    },
    /// So many bytes of the body were read back.
    Checking {
        /// How many.
        done: u32,
        /// Bytes of the body.
        of: u32,
    },
    /// It is installed, and is on trial after the next restart.
    Installed {
        /// Its version.
        version: Version,
    },
    /// It was not taken.
    Failed(UpdateRefusal),
}

/// An image that is being taken in.
#[derive(Default)]
#[allow(clippy::large_enum_variant)] // it lives in one place
pub enum Install {
    /// None.
    #[default]
    Idle,
    /// Its body comes in.
    Receiving(Receiving),
    /// It is being read back.
    Checking(Checking),
    /// It is installed.
    Installed(Version),
    /// It was not taken.
    Failed(UpdateRefusal),
}

/// A body that comes in.
#[derive(Clone, Copy, Debug)]
pub struct Receiving {
    header: Header,
    number: u32,
    next: u32,
}

/// A body that is read back.
pub struct Checking {
    header: Header,
    number: u32,
    done: u32,
    digest: Digest<'static, u32>,
    signature: VerifyingState,
}

/// The number for the next image: above all that either bank knows. `near`: the highest that the bank does which code runs from.
pub fn next_number(near: u32, far: &Bank) -> u32 {
    near.max(far.highest_number()).saturating_add(1)
}

impl Rules {
    /// Checks a header by itself.
    ///
    /// # Errors
    /// [`UpdateRefusal`]: the first rule that it breaks.
    pub fn check(&self, bytes: &[u8; header::BYTES]) -> Result<Header, UpdateRefusal> {
        let header = Header::parse(bytes)?;
        let (found, running) = (header.version, self.version);
        match () {
            () if header.board != self.board => Err(UpdateRefusal::OtherBoard),
            () if header.key != self.key => Err(UpdateRefusal::OtherKey),
            () if found < running && !self.allow_older => {
                Err(UpdateRefusal::Older { found, running })
            }
            () => Ok(header),
        }
    }
}

impl Install {
    /// Begins anew with a header that the rules allow. What was in the bank is gone then.
    ///
    /// # Errors
    /// [`UpdateRefusal`]. Up to a failed erase nothing has changed.
    pub fn begin<F: NorFlash>(
        flash: &mut F,
        bytes: &[u8; header::BYTES],
        rules: &Rules,
        number: u32,
    ) -> Result<Self, UpdateRefusal> {
        if flash.capacity() < BANK_BYTES as usize {
            return Err(UpdateRefusal::NotOffered);
        }
        let header = rules.check(bytes)?;
        // The header first: without it what is left of the old image is none.
        erase(flash, IMAGE_START)?;
        erase(flash, JOURNAL_START)?;
        Ok(Self::Receiving(Receiving {
            header,
            number,
            next: 0,
        }))
    }

    /// Takes the next bytes of the body, whole double words.
    ///
    /// # Errors
    /// [`UpdateRefusal`]; only the flash's ends the update.
    pub fn data<F: NorFlash>(
        &mut self,
        flash: &mut F,
        offset: u32,
        bytes: &[u8],
    ) -> Result<(), UpdateRefusal> {
        let Self::Receiving(receiving) = self else {
            return Err(UpdateRefusal::NotBegun);
        };
        let written = receiving.take(flash, offset, bytes);
        if written == Err(UpdateRefusal::Flash) {
            *self = Self::Failed(UpdateRefusal::Flash);
        }
        written
    }

    /// The body is there: begins to check it. [`Install::work`] goes on.
    ///
    /// # Errors
    /// [`UpdateRefusal::NotBegun`], [`UpdateRefusal::Incomplete`]; a signature of the wrong form ends the update.
    pub fn finish(&mut self) -> Result<(), UpdateRefusal> {
        let Self::Receiving(receiving) = self else {
            return Err(UpdateRefusal::NotBegun);
        };
        let checking = receiving.finish();
        match checking {
            Ok(checking) => *self = Self::Checking(checking),
            Err(UpdateRefusal::Signature) => *self = Self::Failed(UpdateRefusal::Signature),
            Err(other) => return Err(other),
        }
        Ok(())
    }

    /// A slice of the check; false if there is nothing to do.
    pub fn work<F: NorFlash>(&mut self, flash: &mut F) -> bool {
        let Self::Checking(checking) = self else {
            return false;
        };
        match checking.slice(flash) {
            Ok(None) => {}
            Ok(Some(version)) => *self = Self::Installed(version),
            Err(refusal) => *self = Self::Failed(refusal),
        }
        true
    }

    /// How far it is.
    pub fn progress(&self) -> Progress {
        match self {
            Self::Idle => Progress::Idle,
            Self::Receiving(receiving) => Progress::Receiving {
                next: receiving.next,
                of: receiving.header.body_bytes,
            },
            Self::Checking(checking) => Progress::Checking {
                done: checking.done,
                of: checking.header.body_bytes,
            },
            Self::Installed(version) => Progress::Installed { version: *version },
            Self::Failed(refusal) => Progress::Failed(*refusal),
        }
    }
}

impl Receiving {
    fn take<F: NorFlash>(
        &mut self,
        flash: &mut F,
        offset: u32,
        bytes: &[u8],
    ) -> Result<(), UpdateRefusal> {
        let (found, wanted) = (offset, self.next);
        if found != wanted {
            return Err(UpdateRefusal::Offset { found, wanted });
        }
        let length = bytes.len() as u32;
        let room = self.header.body_bytes - wanted;
        if length == 0 || length > room || !length.is_multiple_of(WORD_BYTES) {
            return Err(UpdateRefusal::Length { found: length });
        }
        let start = BODY_START + offset;
        let end = start + length;
        // The header's page is erased already.
        let reached = start.next_multiple_of(PAGE_BYTES)..end;
        for page in reached.step_by(PAGE_BYTES as usize) {
            erase(flash, page)?;
        }
        flash
            .write(start, bytes)
            .map_err(|_| UpdateRefusal::Flash)?;
        self.next = offset + length;
        Ok(())
    }

    fn finish(&self) -> Result<Checking, UpdateRefusal> {
        let (found, wanted) = (self.next, self.header.body_bytes);
        if found != wanted {
            return Err(UpdateRefusal::Incomplete { found, wanted });
        }
        let signature = Signature::new(self.header.signature);
        let mut signature = Verifier::new(self.header.key)
            .verify_incremental(&signature)
            .map_err(|_| UpdateRefusal::Signature)?;
        signature.absorb(self.header.signed());
        Ok(Checking {
            header: self.header,
            number: self.number,
            done: 0,
            digest: CRC32.digest(),
            signature,
        })
    }
}

impl Checking {
    /// The next slice; the version once it is installed.
    fn slice<F: NorFlash>(&mut self, flash: &mut F) -> Result<Option<Version>, UpdateRefusal> {
        let end = (self.done + SLICE_BYTES).min(self.header.body_bytes);
        let mut buffer = [0; PIECE_BYTES];
        while self.done < end {
            let length = (end - self.done).min(PIECE_BYTES as u32);
            let piece = &mut buffer[..length as usize];
            flash
                .read(BODY_START + self.done, piece)
                .map_err(|_| UpdateRefusal::Damaged)?;
            self.digest.update(piece);
            self.signature.absorb(piece);
            self.done += length;
        }
        if self.done < self.header.body_bytes {
            return Ok(None);
        }
        self.conclude(flash).map(Some)
    }

    fn conclude<F: NorFlash>(&self, flash: &mut F) -> Result<Version, UpdateRefusal> {
        if self.digest.clone().finalize() != self.header.body_crc {
            return Err(UpdateRefusal::Damaged);
        }
        self.signature
            .verify()
            .map_err(|_| UpdateRefusal::Signature)?;
        journal::install(flash, self.number)?;
        let (bytes, mut read) = (self.header.encode(), [0; header::BYTES]);
        flash
            .write(IMAGE_START, &bytes)
            .and_then(|()| flash.read(IMAGE_START, &mut read))
            .map_err(|_| UpdateRefusal::Flash)?;
        match read == bytes {
            true => Ok(self.header.version),
            false => Err(UpdateRefusal::Flash),
        }
    }
}

fn erase<F: NorFlash>(flash: &mut F, page: u32) -> Result<(), UpdateRefusal> {
    flash
        .erase(page, page + PAGE_BYTES)
        .map_err(|_| UpdateRefusal::Flash)
}
