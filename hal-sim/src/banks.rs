//! Two banks of flash and the first stage of a simulated board.
//!
//! Whichever image is started, it is the same program that runs: this one. It has the version that
//! its header says.

use crate::shared_flash::SharedFlash;
use courier_sensor::update::choice::choose;
use courier_sensor::update::header::{self, CRC32, Header};
use courier_sensor::update::install::Rules;
use courier_sensor::update::key;
use courier_sensor::update::layout::{BODY_START, IMAGE_START};
use courier_sensor::update::standing::{self, Bank};
use courier_sensor::update::trial::{self, Standing};
use courier_sensor::update::version::Version;

/// What a simulated board calls itself.
pub const BOARD: &str = "simulated";
/// Body of the image that the board comes with.
const BODY: [u8; 8] = *b"courier!";

/// Both banks. That of bank 1 is where code is read from after a reset.
#[derive(Debug)]
pub struct Banks {
    near: SharedFlash,
    far: SharedFlash,
    /// They have changed places.
    swapped: bool,
}

/// What the first stage has started.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Started {
    /// The bank that code runs from.
    pub near: Bank,
    /// How its image stands.
    pub standing: Standing,
}

impl Started {
    /// Version of the image.
    #[must_use]
    pub fn version(&self) -> Version {
        self.near
            .header
            .map_or(Version::OWN, |header| header.version)
    }

    /// What it asks of the next image.
    #[must_use]
    pub fn rules(&self) -> Rules {
        Rules {
            board: header::board(BOARD),
            version: self.version(),
            key: key::TRUSTED,
            allow_older: false,
        }
    }
}

impl Banks {
    /// This program's own version in bank 1, as a debug probe writes it; `far` is bank 2.
    #[must_use]
    pub fn factory(far: SharedFlash) -> Self {
        let near = SharedFlash::erased(0);
        let header = Header {
            board: header::board(BOARD),
            version: Version::OWN,
            body_bytes: BODY.len() as u32,
            body_crc: CRC32.checksum(&BODY),
            key: key::TRUSTED,
            signature: [0; header::SIGNATURE_BYTES],
        };
        let mut bank = near.0.borrow_mut();
        bank.force(IMAGE_START as usize, &header.encode());
        bank.force(BODY_START as usize, &BODY);
        drop(bank);
        Self {
            near,
            far,
            swapped: false,
        }
    }

    /// The bank that the running image may write: always the same handle, whichever bank it is.
    #[must_use]
    pub fn far(&self) -> SharedFlash {
        self.far.clone()
    }

    /// Reset: what is started; none if there is no whole image.
    pub fn start(&mut self) -> Option<Started> {
        if self.swapped {
            self.swap();
        }
        let mut both = [self.near.clone(), self.far.clone()];
        if choose(&mut both, standing::is_whole)?.bank == 1 {
            self.swap();
        }
        let (near, far) = (&mut self.near.clone(), &mut self.far.clone());
        Some(Started {
            near: standing::read(near),
            standing: trial::start(near, far),
        })
    }

    fn swap(&mut self) {
        self.near.0.swap(&self.far.0);
        self.swapped = !self.swapped;
    }
}
