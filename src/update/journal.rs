//! Marks by which the two banks tell which image is to be started. A mark is one double word, programmed once.
//!
//! ```text
//! | number of the image, 4 B | kind, 1 B | low 3 B of the CRC-32/ISCSI of these 5 bytes |
//! ```
//! An image's own number stands behind its header. Everything that happens to it afterwards stands in the journal of the *other* bank,
//! since that is the one which it may write: its trials, and whether it was accepted or refused. The journal is appended to and is
//! erased with the image that lies beside it.
//!
//! A mark that lost power while it was programmed may read as itself now and as damaged later. So what must not be taken back is
//! written twice, one mark after the other ([`ACCEPTED_MARKS`]), and counts by the first that is read.

use super::header::SHORT_CRC32;
use super::layout::{JOURNAL_END, JOURNAL_START, NUMBER_START, WORD_BYTES};
use embedded_storage::nor_flash::{NorFlash, ReadNorFlash};

/// What a mark says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// The image beside it was installed under this number.
    Installed = 0x11,
    /// The other bank's image of this number is being tried once more.
    Trial = 0x22,
    /// It works.
    Accepted = 0x44,
    /// It does not.
    Refused = 0x88,
}

const KINDS: [Kind; 4] = [Kind::Installed, Kind::Trial, Kind::Accepted, Kind::Refused];

/// Marks of acceptance that are written. Until both are there nothing may rely on it.
pub const ACCEPTED_MARKS: u8 = 2;

const MARK_BYTES: usize = WORD_BYTES as usize;
const ERASED: [u8; MARK_BYTES] = [0xFF; MARK_BYTES];

/// What a journal says of the other bank's image.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Journal {
    /// The highest number in it.
    pub number: u32,
    /// How often the image of that number was tried.
    pub trials: u8,
    /// Marks of its acceptance.
    pub accepted: u8,
    /// It was refused.
    pub refused: bool,
    /// Where the next mark goes; none if the page is full.
    pub free: Option<u32>,
}

/// Why a mark could not be made.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[non_exhaustive]
pub enum MarkError {
    /// The page is full.
    #[error("the journal is full")]
    Full,
    /// The flash does not take it, or gives something else back.
    #[error("the flash does not take a mark")]
    Flash,
}

/// A mark's bytes.
pub fn encode(number: u32, kind: Kind) -> [u8; MARK_BYTES] {
    let mut bytes = [0; MARK_BYTES];
    bytes[..4].copy_from_slice(&number.to_le_bytes());
    bytes[4] = kind as u8;
    let crc = SHORT_CRC32.checksum(&bytes[..5]).to_le_bytes();
    bytes[5..].copy_from_slice(&crc[..3]);
    bytes
}

/// What a double word says, if it is a mark.
pub fn decode(bytes: &[u8; MARK_BYTES]) -> Option<(u32, Kind)> {
    let [a, b, c, d, kind, ..] = *bytes;
    let number = u32::from_le_bytes([a, b, c, d]);
    let kind = KINDS.into_iter().find(|known| *known as u8 == kind)?;
    (encode(number, kind) == *bytes).then_some((number, kind))
}

/// The number under which the image in this bank was installed.
pub fn installed<F: ReadNorFlash>(flash: &mut F) -> Option<u32> {
    match decode(&word(flash, NUMBER_START)?) {
        Some((number, Kind::Installed)) => Some(number),
        _ => None,
    }
}

/// Reads the journal in this bank.
pub fn read<F: ReadNorFlash>(flash: &mut F) -> Journal {
    let mut journal = Journal::default();
    let mut behind_last = JOURNAL_START;
    for place in (JOURNAL_START..JOURNAL_END).step_by(MARK_BYTES) {
        let word = word(flash, place);
        if word != Some(ERASED) {
            behind_last = place + WORD_BYTES;
        }
        if let Some((number, kind)) = word.as_ref().and_then(decode) {
            journal = journal.with(number, kind);
        }
    }
    journal.free = (behind_last < JOURNAL_END).then_some(behind_last);
    journal
}

/// Appends a mark to the journal in this bank.
///
/// # Errors
/// [`MarkError`].
pub fn append<F: NorFlash>(flash: &mut F, number: u32, kind: Kind) -> Result<(), MarkError> {
    let place = read(flash).free.ok_or(MarkError::Full)?;
    put(flash, place, &encode(number, kind))
}

/// Writes down under which number the image in this bank is installed; its header follows.
///
/// # Errors
/// [`MarkError::Flash`].
pub fn install<F: NorFlash>(flash: &mut F, number: u32) -> Result<(), MarkError> {
    put(flash, NUMBER_START, &encode(number, Kind::Installed))
}

fn put<F: NorFlash>(flash: &mut F, place: u32, mark: &[u8; MARK_BYTES]) -> Result<(), MarkError> {
    flash.write(place, mark).map_err(|_| MarkError::Flash)?;
    match word(flash, place) {
        Some(read) if read == *mark => Ok(()),
        _ => Err(MarkError::Flash),
    }
}

/// A double word; none if it cannot be read.
fn word<F: ReadNorFlash>(flash: &mut F, place: u32) -> Option<[u8; MARK_BYTES]> {
    let mut bytes = ERASED;
    flash.read(place, &mut bytes).ok().map(|()| bytes)
}

impl Journal {
    /// Takes in a further mark; one of an earlier number no longer matters.
    fn with(self, number: u32, kind: Kind) -> Self {
        let mut next = match number {
            later if later > self.number => Self {
                number,
                ..Self::default()
            },
            earlier if earlier < self.number => return self,
            _ => self,
        };
        match kind {
            Kind::Installed => {}
            Kind::Trial => next.trials = next.trials.saturating_add(1),
            Kind::Accepted => next.accepted = next.accepted.saturating_add(1),
            Kind::Refused => next.refused = true,
        }
        next
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_flipped_bit_of_a_mark_is_found() {
        for kind in KINDS {
            let mark = encode(0xDEAD_BEEF, kind);
            assert_eq!(decode(&mark), Some((0xDEAD_BEEF, kind)));
            for bit in 0..64 {
                let mut bytes = mark;
                bytes[bit / 8] ^= 1 << (bit % 8);
                assert_eq!(decode(&bytes), None, "{kind:?}, bit {bit}");
            }
        }
        assert_eq!(decode(&ERASED), None);
        assert_eq!(decode(&[0; MARK_BYTES]), None);
    }

    #[test]
    fn marks_of_an_earlier_number_no_longer_matter() {
        let journal = [(3, Kind::Trial), (3, Kind::Refused), (4, Kind::Trial)];
        let journal = journal
            .into_iter()
            .fold(Journal::default(), |journal, (number, kind)| {
                journal.with(number, kind)
            });
        let wanted = Journal {
            number: 4,
            trials: 1,
            ..Journal::default()
        };
        assert_eq!(journal, wanted);
        assert_eq!(journal.with(3, Kind::Accepted), wanted);
    }
}
