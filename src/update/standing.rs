//! What a bank holds: its image, under which number that was installed, and what its journal says of the other bank's.

use super::header::{self, CRC32, Header};
use super::journal::{self, Journal};
use super::layout::{BODY_START, IMAGE_START};
use embedded_storage::nor_flash::ReadNorFlash;

/// Bytes read at once while a body is checked.
const PIECE_BYTES: usize = 256;

/// One bank. That the header can be read does not say that the body is whole: [`is_whole`].
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Bank {
    /// Header of its image, if it has one.
    pub header: Option<Header>,
    /// Number of that image; none if it was not installed by an update.
    pub number: Option<u32>,
    /// What it knows of the other bank's image.
    pub journal: Journal,
}

impl Bank {
    /// The highest number of an image that it knows of, its own or the other bank's; 0 if none.
    pub fn highest_number(&self) -> u32 {
        self.number.unwrap_or(0).max(self.journal.number)
    }
}

/// Reads header and journal.
pub fn read<F: ReadNorFlash>(flash: &mut F) -> Bank {
    let mut bytes = [0; header::BYTES];
    let found = flash.read(IMAGE_START, &mut bytes);
    Bank {
        header: found.ok().and_then(|()| Header::parse(&bytes).ok()),
        number: journal::installed(flash),
        journal: journal::read(flash),
    }
}

/// Whether the body is there, byte by byte.
pub fn is_whole<F: ReadNorFlash>(flash: &mut F, header: &Header) -> bool {
    let mut digest = CRC32.digest();
    let read = pieces(flash, header.body_bytes, |piece| digest.update(piece));
    read.is_ok() && digest.finalize() == header.body_crc
}

/// Gives the first bytes of the body to `take`, piece by piece.
fn pieces<F: ReadNorFlash>(
    flash: &mut F,
    body_bytes: u32,
    mut take: impl FnMut(&[u8]),
) -> Result<(), F::Error> {
    let mut buffer = [0; PIECE_BYTES];
    for at in (0..body_bytes).step_by(PIECE_BYTES) {
        let bytes = (body_bytes - at).min(PIECE_BYTES as u32) as usize;
        let piece = &mut buffer[..bytes];
        flash.read(BODY_START + at, piece)?;
        take(piece);
    }
    Ok(())
}
