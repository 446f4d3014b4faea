//! Four slots for tooth maps in NOR flash, one map a slot, each by the name of its place.
//!
//! ```text
//!  slot 0: | map (see `record`) ... 0xFF ... | places of its reference mark | mark, 8 bytes |   slots 1 to 3: the same, right behind
//! ```
//! A map is written to a slot that holds none that counts, its first bytes last, and read back. So a place's map before stays until
//! the new one is whole, and one slot must be free for that: there is room for three places. Forgetting a map programs its slot's
//! mark. A power cut at any byte leaves every map that counted before, or the new one in its place.
//!
//! Wear: a page lasts 10,000 erases (data sheet DS12288); a map is stored by order of a person.

use super::record::{
    Digest, HEADER_BYTES, Header, INFO_BYTES, MAX_HEAD_BYTES, MapInfo, MapRecordError, VERSION,
};
use crate::device::Device;
use crate::frame::Coordinate;
use crate::teeth::MAX_NODES;
use core::ops::Range;
use embedded_storage::nor_flash::NorFlash;
use serde::{Deserialize, Serialize};

/// How many slots there are.
pub const SLOTS: usize = 4;
/// Bytes of one: two pages of the STM32G4's flash.
pub const SLOT_BYTES: u32 = 4096;
/// Places that have a map at most: one slot stays free for the next map of a place.
pub const MOST_PLACES: usize = SLOTS - 1;

const MARK_BYTES: usize = 8;
const WORD: usize = 8;
const ERASED: u8 = 0xFF;
/// Bytes read at a time while a map is checked.
const PIECE_BYTES: usize = 64;
const _: () = assert!(
    HEADER_BYTES + MAX_HEAD_BYTES + 2 * MAX_NODES + MARK_BYTES <= SLOT_BYTES as usize,
    "the largest map fits"
);

/// Where the places of a map's reference mark begin in its slot: behind the largest map.
const PLACES_OFFSET: u32 = (HEADER_BYTES + MAX_HEAD_BYTES + 2 * MAX_NODES) as u32;
const _: () = assert!(
    PLACES_OFFSET.is_multiple_of(WORD as u32),
    "places of a mark are whole double words"
);

/// What a slot is.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
pub enum MapSlotState {
    /// Holds its place's map.
    #[error("stored")]
    Current,
    /// Holds an older map of a place that has a newer one.
    #[error("older")]
    Older,
    /// Holds a map that was forgotten.
    #[error("forgotten")]
    Forgotten,
    /// Holds none that can be used.
    #[error("refused: {0}")]
    Refused(MapRecordError),
}

/// A slot.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct MapSlot {
    /// 0 to 3.
    pub slot: u8,
    /// What it is.
    pub state: MapSlotState,
    /// What the map is of, if there is a whole one of this board.
    pub info: Option<MapInfo>,
    /// Where the board's own reference mark is crossed, in the map's count along x and y, if that is kept beside it.
    pub mark: Option<[Coordinate; 2]>,
}

/// Why a map was not stored, forgotten or read. Whatever counted before still does.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[non_exhaustive]
pub enum MapStoreError {
    /// Every place that there is room for has a map.
    #[error(
        "{MOST_PLACES} places have a map already, and there is room for no more: forget one first"
    )]
    Full,
    /// There is no such slot.
    #[error("map slot {0}: there are 0 to 3")]
    NoSuchSlot(u8),
    /// The slot holds no map that can be used.
    #[error("map slot {slot}: {error}")]
    Record {
        /// The slot.
        slot: u8,
        /// What is wrong with it.
        error: MapRecordError,
    },
    /// The map has more terms than a slot has room for.
    #[error("the map's error model does not fit its slot")]
    TooLong,
    /// Nodes without a map that was begun, or an end without all of them.
    #[error("{found} nodes came to be stored, wanted {wanted}")]
    Nodes {
        /// What came.
        found: u16,
        /// What the map's header says; 0 if none was begun.
        wanted: u16,
    },
    /// The flash does not erase.
    #[error("map slot {0} does not erase")]
    Erase(u8),
    /// The flash does not take data.
    #[error("map slot {0} does not take data")]
    Write(u8),
    /// The flash does not keep data.
    #[error("map slot {0}: what was read back is not what was written")]
    ReadBack(u8),
}

/// A whole map of this board.
#[derive(Clone, Debug, PartialEq)]
pub struct Found {
    /// What it is of.
    pub info: MapInfo,
    /// Counts maps that were stored.
    pub sequence: u32,
    /// Nodes of both fields.
    pub nodes: u16,
    is_forgotten: bool,
    head_bytes: u16,
}

/// The slots of a flash region.
#[derive(Debug)]
pub struct Maps<'f, F> {
    flash: &'f mut F,
    start: u32,
    owner: Device,
}

/// A map that is being written. Dropped before its end, it leaves a slot without a map.
#[derive(Clone)]
pub struct Writing {
    slot: u8,
    header: Header,
    digest: Digest,
    /// Bytes behind the header that are programmed.
    done: u32,
    word: [u8; WORD],
    in_word: usize,
    nodes: u16,
}

impl<'f, F: NorFlash> Maps<'f, F> {
    const LAYOUT_FITS: () = assert!(
        SLOT_BYTES as usize % F::ERASE_SIZE == 0
            && WORD % F::WRITE_SIZE == 0
            && WORD % F::READ_SIZE == 0,
        "a slot is whole pages, its parts whole words"
    );

    /// The slots from `start` on, a page's first byte, for maps of the board `owner`. Nothing is read yet.
    pub const fn new(flash: &'f mut F, start: u32, owner: Device) -> Self {
        const { Self::LAYOUT_FITS };
        Self {
            flash,
            start,
            owner,
        }
    }

    /// What one slot holds, every byte checked: 0.5 ms for a map.
    ///
    /// # Errors
    /// [`MapRecordError`].
    #[inline(never)]
    pub fn examine(&mut self, slot: u8) -> Result<Found, MapRecordError> {
        let header = self.checked_header(slot)?;
        let mut bytes = [0; INFO_BYTES];
        self.read(slot, HEADER_BYTES as u32, &mut bytes)?;
        let (info, _) =
            postcard::take_from_bytes::<MapInfo>(&bytes).map_err(|_| MapRecordError::Invalid)?;
        info.validate()?;
        if info.device != self.owner {
            return Err(MapRecordError::OtherDevice(info.device));
        }
        Ok(Found {
            info,
            sequence: header.sequence,
            nodes: header.nodes,
            is_forgotten: self.is_marked(slot),
            head_bytes: header.head_bytes,
        })
    }

    /// What one slot holds, and whether that is its place's newest.
    ///
    /// # Errors
    /// [`MapStoreError::NoSuchSlot`].
    pub fn slot(&mut self, slot: u8) -> Result<MapSlot, MapStoreError> {
        if usize::from(slot) >= SLOTS {
            return Err(MapStoreError::NoSuchSlot(slot));
        }
        let (state, info) = match self.examine(slot) {
            Err(error) => (MapSlotState::Refused(error), None),
            Ok(found) if found.is_forgotten => (MapSlotState::Forgotten, Some(found.info)),
            Ok(found) if self.is_newest(slot, &found) => (MapSlotState::Current, Some(found.info)),
            Ok(found) => (MapSlotState::Older, Some(found.info)),
        };
        Ok(MapSlot {
            slot,
            state,
            info,
            mark: None,
        })
    }

    /// The map in a slot, if it counts.
    pub fn current(&mut self, slot: u8) -> Option<Found> {
        let found = self.examine(slot).ok()?;
        (!found.is_forgotten && self.is_newest(slot, &found)).then_some(found)
    }

    /// Reads the head behind [`MapInfo`] of a map that [`Maps::current`] has found into `buffer`: its bytes.
    ///
    /// # Errors
    /// [`MapStoreError::Record`].
    pub fn head<'b>(
        &mut self,
        slot: u8,
        found: &Found,
        buffer: &'b mut [u8],
    ) -> Result<&'b [u8], MapStoreError> {
        let named = |error| MapStoreError::Record { slot, error };
        let head = buffer
            .get_mut(..usize::from(found.head_bytes))
            .ok_or(MapStoreError::TooLong)?;
        self.read(slot, HEADER_BYTES as u32, head).map_err(named)?;
        let info =
            postcard::take_from_bytes::<MapInfo>(head).map_err(|_| named(MapRecordError::Invalid));
        info.map(|(_, rest)| rest)
    }

    /// Gives the nodes of a map that [`Maps::current`] has found to `take`, piece by piece; false from it ends that.
    ///
    /// # Errors
    /// [`MapStoreError::Record`].
    pub fn nodes(
        &mut self,
        slot: u8,
        found: &Found,
        mut take: impl FnMut(&[i16]) -> bool,
    ) -> Result<(), MapStoreError> {
        let mut place =
            HEADER_BYTES as u32 + u32::from(found.head_bytes).next_multiple_of(WORD as u32);
        let mut left = usize::from(found.nodes);
        while left > 0 {
            let mut bytes = [0; PIECE_BYTES];
            self.read(slot, place, &mut bytes)
                .map_err(|error| MapStoreError::Record { slot, error })?;
            let count = left.min(PIECE_BYTES / 2);
            let mut nodes_nm = [0; PIECE_BYTES / 2];
            for (node_nm, pair) in nodes_nm.iter_mut().zip(bytes.as_chunks().0) {
                *node_nm = i16::from_le_bytes(*pair);
            }
            if !take(&nodes_nm[..count]) {
                break;
            }
            left -= count;
            place += PIECE_BYTES as u32;
        }
        Ok(())
    }

    /// Begins to store a map: erases a slot and writes the head, encoded by [`super::MapHead::encode`]; 45 to 70 ms.
    ///
    /// # Errors
    /// [`MapStoreError`]; every map that counts still does.
    #[inline(never)]
    pub fn begin(&mut self, name: &str, head: &[u8], nodes: u16) -> Result<Writing, MapStoreError> {
        if head.len() > MAX_HEAD_BYTES || usize::from(nodes) > MAX_NODES {
            return Err(MapStoreError::TooLong);
        }
        let (slot, sequence) = self.free_slot(name)?;
        let start = self.address(slot, 0);
        self.flash
            .erase(start, start + SLOT_BYTES)
            .map_err(|_| MapStoreError::Erase(slot))?;
        let header = Header::new(head.len() as u16, nodes, sequence);
        let mut writing = Writing {
            slot,
            header,
            digest: header.digest(),
            done: 0,
            word: [ERASED; WORD],
            in_word: 0,
            nodes: 0,
        };
        self.append(&mut writing, head)?;
        self.fill_up(&mut writing)?;
        Ok(writing)
    }

    /// Stores its next nodes, 10 ms for 500.
    ///
    /// # Errors
    /// [`MapStoreError::Nodes`] if there are more than the header says, [`MapStoreError::Write`].
    pub fn append_nodes(
        &mut self,
        writing: &mut Writing,
        nodes_nm: &[i16],
    ) -> Result<(), MapStoreError> {
        let (found, wanted) = (
            usize::from(writing.nodes) + nodes_nm.len(),
            writing.header.nodes,
        );
        if found > usize::from(wanted) {
            return Err(MapStoreError::Nodes {
                found: found as u16,
                wanted,
            });
        }
        for node_nm in nodes_nm {
            self.append(writing, &node_nm.to_le_bytes())?;
        }
        writing.nodes = found as u16;
        Ok(())
    }

    /// Ends it and reads it back: from now on it counts. Its slot.
    ///
    /// # Errors
    /// [`MapStoreError`]; the place's map before still counts.
    #[inline(never)]
    pub fn finish(&mut self, mut writing: Writing) -> Result<u8, MapStoreError> {
        let (slot, wanted) = (writing.slot, writing.header.nodes);
        if writing.nodes != wanted {
            return Err(MapStoreError::Nodes {
                found: writing.nodes,
                wanted,
            });
        }
        self.fill_up(&mut writing)?;
        let header = Header {
            crc: writing.digest.finalize(),
            ..writing.header
        };
        let written = self.flash.write(self.address(slot, 0), &header.encode());
        written.map_err(|_| MapStoreError::Write(slot))?;
        match self.examine(slot) {
            Ok(found) if found.sequence == header.sequence && !found.is_forgotten => Ok(slot),
            _ => Err(MapStoreError::ReadBack(slot)),
        }
    }

    /// Takes a map out of use; its slot is free.
    ///
    /// # Errors
    /// [`MapStoreError::NoSuchSlot`], [`MapStoreError::Record`] where there is none, or the flash's.
    pub fn forget(&mut self, slot: u8) -> Result<(), MapStoreError> {
        if usize::from(slot) >= SLOTS {
            return Err(MapStoreError::NoSuchSlot(slot));
        }
        let found = self.examine(slot);
        let found = found.map_err(|error| MapStoreError::Record { slot, error })?;
        if found.is_forgotten {
            return Ok(());
        }
        let mark = self.address(slot, SLOT_BYTES - MARK_BYTES as u32);
        let written = self.flash.write(mark, &[0; MARK_BYTES]);
        written.map_err(|_| MapStoreError::Write(slot))?;
        match self.is_marked(slot) {
            true => Ok(()),
            false => Err(MapStoreError::ReadBack(slot)),
        }
    }

    /// The highest number of a map, of whatever board and version, and its slot.
    pub fn newest(&mut self) -> Option<(u32, u8)> {
        let numbered = |slot| Some((self.sequence(slot)?, slot));
        (0..SLOTS as u8).filter_map(numbered).max()
    }

    /// Where the places of a map's reference mark lie, addresses in flash (`super::crossing`).
    pub fn places(&self, slot: u8) -> Range<u32> {
        self.address(slot, PLACES_OFFSET)..self.address(slot, SLOT_BYTES - MARK_BYTES as u32)
    }

    /// A slot that holds nothing that counts, and the next map's number. An older map of the same place is the last that goes.
    fn free_slot(&mut self, name: &str) -> Result<(u8, u32), MapStoreError> {
        let mut free = None;
        let mut others = 0;
        for slot in 0..SLOTS as u8 {
            let is_free = match self.examine(slot) {
                Ok(found) if found.is_forgotten || !self.is_newest(slot, &found) => true,
                Ok(found) => {
                    others += usize::from(found.info.name != name);
                    false
                }
                Err(MapRecordError::UnknownVersion(_)) => {
                    others += 1;
                    false
                }
                Err(_) => true,
            };
            if is_free && free.is_none() {
                free = Some(slot);
            }
        }
        let slot = free
            .filter(|_| others < MOST_PLACES)
            .ok_or(MapStoreError::Full)?;
        let sequence = self.newest().map_or(1, |(last, _)| last.saturating_add(1));
        Ok((slot, sequence))
    }

    /// Whether no other slot holds a newer map of the place.
    fn is_newest(&mut self, slot: u8, found: &Found) -> bool {
        (0..SLOTS as u8)
            .filter(|other| *other != slot)
            .all(|other| match self.examine(other) {
                Ok(other) if !other.is_forgotten && other.info.name == found.info.name => {
                    other.sequence < found.sequence
                }
                _ => true,
            })
    }

    fn sequence(&mut self, slot: u8) -> Option<u32> {
        let mut bytes = [0; HEADER_BYTES];
        self.read(slot, 0, &mut bytes).ok()?;
        Some(Header::parse(&bytes).ok()?.sequence)
    }

    /// The header of a map whose check holds.
    fn checked_header(&mut self, slot: u8) -> Result<Header, MapRecordError> {
        let mut bytes = [0; HEADER_BYTES];
        self.read(slot, 0, &mut bytes)?;
        let header = Header::parse(&bytes)?;
        let mut digest = header.digest();
        let (mut place, end) = (0, header.body_bytes());
        while place < end {
            let mut piece = [0; PIECE_BYTES];
            let count = (end - place).min(PIECE_BYTES as u32);
            let piece = &mut piece[..count as usize];
            self.read(slot, HEADER_BYTES as u32 + place, piece)?;
            digest.update(piece);
            place += count;
        }
        if digest.finalize() != header.crc {
            return Err(MapRecordError::Torn);
        }
        match header.version {
            VERSION => Ok(header),
            other => Err(MapRecordError::UnknownVersion(other)),
        }
    }

    /// A mark that cannot be read was torn while it was programmed: forgotten.
    fn is_marked(&mut self, slot: u8) -> bool {
        let mut mark = [ERASED; MARK_BYTES];
        let read = self.read(slot, SLOT_BYTES - MARK_BYTES as u32, &mut mark);
        read.is_err() || mark != [ERASED; MARK_BYTES]
    }

    /// Programs bytes behind what is there, whole double words at a time.
    fn append(&mut self, writing: &mut Writing, bytes: &[u8]) -> Result<(), MapStoreError> {
        for byte in bytes {
            writing.word[writing.in_word] = *byte;
            writing.in_word += 1;
            if writing.in_word == WORD {
                let place = self.address(writing.slot, HEADER_BYTES as u32 + writing.done);
                let written = self.flash.write(place, &writing.word);
                written.map_err(|_| MapStoreError::Write(writing.slot))?;
                writing.digest.update(&writing.word);
                writing.done += WORD as u32;
                writing.in_word = 0;
            }
        }
        Ok(())
    }

    /// Fills the last double word.
    fn fill_up(&mut self, writing: &mut Writing) -> Result<(), MapStoreError> {
        let rest = (WORD - writing.in_word) % WORD;
        self.append(writing, &[0; WORD][..rest])
    }

    fn address(&self, slot: u8, offset: u32) -> u32 {
        self.start + u32::from(slot) * SLOT_BYTES + offset
    }

    fn read(&mut self, slot: u8, offset: u32, bytes: &mut [u8]) -> Result<(), MapRecordError> {
        let place = self.address(slot, offset);
        self.flash
            .read(place, bytes)
            .map_err(|_| MapRecordError::Unreadable)
    }
}
