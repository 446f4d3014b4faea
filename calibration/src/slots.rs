//! Two slots in NOR flash, used in turn: the newest valid record is in force, a torn write leaves the other.
//!
//! ```text
//!  slot 0: | record (see `record`) | kept by the watch ... 0xFF ... | mark, 8 bytes |   slot 1: the same, right behind
//! ```
//! A commit erases and writes the slot that is not in force and reads it back. Rolling back programs the mark of the slot in force: it
//! stays readable but no longer counts, and the other is in force. No operation touches the slot that stays or comes in force, so a
//! power cut at any byte leaves either the state before or the state after.

use super::record::{self, Calibration, HEADER_BYTES, Header, MAX_BYTES, RecordError};
use crate::device::Device;
use crate::geometry::Geometry;
use core::ops::Range;
use embedded_storage::nor_flash::{NorFlash, NorFlashError, NorFlashErrorKind};
use serde::{Deserialize, Serialize};

/// Bytes of one slot. By definition one page of the STM32G4's flash.
pub const SLOT_BYTES: usize = 2048;
/// How many there are. By definition two that alternate: a torn write leaves the other one.
pub const SLOTS: usize = 2;

const MARK_BYTES: usize = SLOT_BYTES - MAX_BYTES;
/// A byte of flash that was erased, by definition of the chip.
const ERASED: u8 = 0xFF;

/// What a slot is.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum SlotState {
    /// Holds the newest valid record.
    InForce,
    /// Holds a valid record, older than the one in force.
    Older,
    /// Holds a whole record that was rolled back.
    RolledBack,
    /// Holds none: empty, torn, of an unknown version, or not usable.
    Refused(RecordError),
}

/// A slot and its record's number.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SlotInfo {
    /// 0 or 1.
    pub slot: u8,
    /// What it is.
    pub state: SlotState,
    /// Number of its record, if it has a whole one of any version.
    pub sequence: Option<u32>,
}

/// A record that has come in force.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub struct Place {
    /// 0 or 1.
    pub slot: u8,
    /// The record's number.
    pub sequence: u32,
}

/// Why a slot operation was refused or failed. Whatever was in force still is.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
pub enum SlotError {
    /// There is no record in force.
    #[error("no slot holds a valid calibration")]
    NoneInForce,
    /// There is no such slot.
    #[error("slot {slot}: there are 0 and 1")]
    NoSuchSlot {
        /// The number asked for.
        slot: u8,
    },
    /// The record cannot be stored or read.
    #[error("record: {0}")]
    Record(#[from] RecordError),
    /// The free slot holds a later firmware's record, and it was not said that it may go.
    #[error(
        "slot {slot} holds layout version {version}, not known here: it is overwritten only when told to"
    )]
    WouldLoseUnknown {
        /// The slot.
        slot: u8,
        /// The version in it.
        version: u16,
    },
    /// There is no older valid record to go back to.
    #[error("no older valid calibration to roll back to")]
    NothingOlder,
    /// The flash did not erase.
    #[error("slot {slot} does not erase ({kind:?})")]
    Erase {
        /// The slot.
        slot: u8,
        /// What the flash said.
        kind: NorFlashErrorKind,
    },
    /// The flash did not take the data.
    #[error("slot {slot} does not take data ({kind:?})")]
    Write {
        /// The slot.
        slot: u8,
        /// What the flash said.
        kind: NorFlashErrorKind,
    },
    /// What is read back is not what was written.
    #[error("slot {slot}: what was read back is not what was written")]
    ReadBack {
        /// The slot.
        slot: u8,
    },
}

/// The two slots of a flash region.
#[derive(Debug)]
pub struct Slots<F> {
    flash: F,
    start: u32,
    owner: Option<Device>,
    buffer: [u8; MAX_BYTES],
}

/// What a slot holds, before it is known which one is in force.
#[derive(Clone, Copy, Debug)]
struct Found {
    result: Result<u32, RecordError>,
    sequence: Option<u32>,
    rolled_back: bool,
}

impl Found {
    fn candidate(&self) -> Option<u32> {
        self.result.ok().filter(|_| !self.rolled_back)
    }
}

impl<F: NorFlash> Slots<F> {
    const LAYOUT_FITS: () = assert!(
        SLOT_BYTES % F::ERASE_SIZE == 0
            && MARK_BYTES % F::WRITE_SIZE == 0
            && MAX_BYTES % F::WRITE_SIZE == 0
            && HEADER_BYTES % F::READ_SIZE == 0,
        "a slot is whole pages, its parts whole words"
    );

    /// Two slots from `start` on, which must be a page's first byte. Nothing is read yet.
    pub const fn new(flash: F, start: u32) -> Self {
        const { Self::LAYOUT_FITS };
        Self {
            flash,
            start,
            owner: None,
            buffer: [ERASED; MAX_BYTES],
        }
    }

    /// From now on a record counts only if it is of this board; until then it may be of any.
    pub const fn set_owner(&mut self, device: Device) {
        self.owner = Some(device);
    }

    /// The flash, for what lies beside the slots.
    pub fn flash_mut(&mut self) -> &mut F {
        &mut self.flash
    }

    /// The flash and the slots' buffer, for what lies beside them: nothing in the buffer is kept.
    pub fn parts_mut(&mut self) -> (&mut F, &mut [u8; MAX_BYTES]) {
        (&mut self.flash, &mut self.buffer)
    }

    /// Check value of the record in a slot, by which records are told apart; none without a whole header.
    pub fn check_value(&mut self, slot: u8) -> Option<u32> {
        let (place, mut head, mut crc) = (self.offset(slot), [0; HEADER_BYTES], [0; 4]);
        self.flash.read(place, &mut head).ok()?;
        let record_bytes = Header::parse(&head).ok()?.record_bytes();
        let behind = place + (record_bytes - crc.len()) as u32;
        self.flash.read(behind, &mut crc).ok()?;
        Some(u32::from_le_bytes(crc))
    }

    /// What is free behind the record in a slot, addresses in flash, up to the mark; none without a whole header.
    pub fn room_behind(&mut self, slot: u8) -> Option<Range<u32>> {
        let (place, mut head) = (self.offset(slot), [0; HEADER_BYTES]);
        self.flash.read(place, &mut head).ok()?;
        let record_bytes = Header::parse(&head).ok()?.record_bytes();
        let written = record_bytes.next_multiple_of(F::WRITE_SIZE).min(MAX_BYTES);
        Some(place + written as u32..place + MAX_BYTES as u32)
    }

    /// Gives the flash back.
    pub fn release(self) -> F {
        self.flash
    }

    /// What both slots hold.
    pub fn list(&mut self) -> [SlotInfo; SLOTS] {
        let found = [self.examine(0), self.examine(1)];
        let in_force = newest(&found);
        core::array::from_fn(|slot| {
            let Found {
                result,
                sequence,
                rolled_back,
            } = found[slot];
            let state = match result {
                Err(error) => SlotState::Refused(error),
                Ok(_) if rolled_back => SlotState::RolledBack,
                Ok(_) if in_force == Some(slot) => SlotState::InForce,
                Ok(_) => SlotState::Older,
            };
            SlotInfo {
                slot: slot as u8,
                state,
                sequence,
            }
        })
    }

    /// The calibration in force.
    ///
    /// # Errors
    /// [`SlotError::NoneInForce`], or [`RecordError::UnknownVersion`] or [`RecordError::OtherDevice`] if that is why; [`Slots::list`]
    /// tells what there is.
    pub fn load(&mut self) -> Result<(Place, Calibration), SlotError> {
        let mut calibration = Calibration::identity(Geometry::PAPER);
        let place = self.load_into(&mut calibration)?;
        Ok((place, calibration))
    }

    /// [`Slots::load`] without a copy on the stack; on an error `to` is of no use.
    ///
    /// # Errors
    /// As [`Slots::load`].
    pub fn load_into(&mut self, to: &mut Calibration) -> Result<Place, SlotError> {
        let found = [self.examine(0), self.examine(1)];
        let Some(slot) = newest(&found) else {
            let whole = found.iter().find_map(|found| match found.result {
                Err(
                    error @ (RecordError::UnknownVersion { .. } | RecordError::OtherDevice { .. }),
                ) => Some(SlotError::Record(error)),
                _ => None,
            });
            return Err(whole.unwrap_or(SlotError::NoneInForce));
        };
        self.read_into(slot as u8, to)
    }

    /// One slot's calibration, in force or not.
    ///
    /// # Errors
    /// [`SlotError::NoSuchSlot`] or what is wrong with the record.
    pub fn read(&mut self, slot: u8) -> Result<(Place, Calibration), SlotError> {
        let mut calibration = Calibration::identity(Geometry::PAPER);
        let place = self.read_into(slot, &mut calibration)?;
        Ok((place, calibration))
    }

    /// [`Slots::read`] without a copy on the stack; on an error `to` is of no use.
    ///
    /// # Errors
    /// As [`Slots::read`].
    pub fn read_into(&mut self, slot: u8, to: &mut Calibration) -> Result<Place, SlotError> {
        if usize::from(slot) >= SLOTS {
            return Err(SlotError::NoSuchSlot { slot });
        }
        let sequence = self.fetch(slot, to)?;
        Ok(Place { slot, sequence })
    }

    /// Stores a calibration in the slot that is not in force; from then on it is in force.
    /// `lose_unknown`: whether a later firmware's record may be overwritten.
    ///
    /// # Errors
    /// Any of [`SlotError`]; what was in force before still is.
    pub fn commit(
        &mut self,
        calibration: &Calibration,
        lose_unknown: bool,
    ) -> Result<Place, SlotError> {
        self.check_owner(calibration)?;
        let found = [self.examine(0), self.examine(1)];
        let target = match newest(&found) {
            Some(in_force) => 1 - in_force,
            None => usize::from(loss(&found[1]) < loss(&found[0])),
        };
        let slot = target as u8;
        if let (Err(RecordError::UnknownVersion { version }), false) =
            (found[target].result, lose_unknown)
        {
            return Err(SlotError::WouldLoseUnknown { slot, version });
        }
        let last = found.iter().filter_map(|found| found.sequence).max();
        let sequence = last.map_or(1, |last| last.saturating_add(1));
        let record_bytes = record::encode(calibration, sequence, &mut self.buffer)?;
        let bytes = record_bytes.next_multiple_of(F::WRITE_SIZE).min(MAX_BYTES);
        self.buffer[record_bytes..].fill(ERASED);
        self.write_slot(slot, bytes)?;
        self.check_slot(slot, calibration, sequence)?;
        Ok(Place { slot, sequence })
    }

    /// Takes the record in force out of force; the other one comes in force.
    ///
    /// # Errors
    /// [`SlotError::NoneInForce`], [`SlotError::NothingOlder`], or the flash's; what was in force then still is.
    pub fn roll_back(&mut self) -> Result<Place, SlotError> {
        let found = [self.examine(0), self.examine(1)];
        let in_force = newest(&found).ok_or(SlotError::NoneInForce)?;
        let older = 1 - in_force;
        let sequence = found[older].candidate().ok_or(SlotError::NothingOlder)?;
        let slot = in_force as u8;
        let mark = self.offset(slot) + MAX_BYTES as u32;
        self.flash
            .write(mark, &[0; MARK_BYTES])
            .map_err(|error| SlotError::Write {
                slot,
                kind: error.kind(),
            })?;
        if !self.is_marked(slot) {
            return Err(SlotError::ReadBack { slot });
        }
        Ok(Place {
            slot: older as u8,
            sequence,
        })
    }

    fn offset(&self, slot: u8) -> u32 {
        self.start + u32::from(slot) * SLOT_BYTES as u32
    }

    #[inline(never)] // one calibration on the stack at a time
    fn examine(&mut self, slot: u8) -> Found {
        let mut calibration = Calibration::identity(Geometry::PAPER);
        let fetched = self.fetch(slot, &mut calibration);
        let result = fetched.and_then(|sequence| self.check_owner(&calibration).map(|()| sequence));
        // A whole record that is not used has a number that counts; a torn one's means nothing.
        let sequence = match result {
            Ok(sequence) => Some(sequence),
            Err(RecordError::UnknownVersion { .. } | RecordError::OtherDevice { .. }) => self
                .buffer
                .first_chunk()
                .and_then(|head| Header::parse(head).ok())
                .map(|head| head.sequence),
            Err(_) => None,
        };
        Found {
            result,
            sequence,
            rolled_back: self.is_marked(slot),
        }
    }

    fn check_owner(&self, calibration: &Calibration) -> Result<(), RecordError> {
        let device = calibration.device;
        match self.owner {
            Some(owner) if owner != device => Err(RecordError::OtherDevice { device }),
            _ => Ok(()),
        }
    }

    /// Reads a slot's record into the buffer and decodes it.
    fn fetch(&mut self, slot: u8, to: &mut Calibration) -> Result<u32, RecordError> {
        let offset = self.offset(slot);
        let (head, rest) = self
            .buffer
            .split_first_chunk_mut::<HEADER_BYTES>()
            .ok_or(RecordError::TooLong)?;
        self.flash
            .read(offset, head)
            .map_err(|_| RecordError::Unreadable)?;
        let bytes = Header::parse(head)?
            .record_bytes()
            .next_multiple_of(F::WRITE_SIZE.max(F::READ_SIZE));
        let rest = rest
            .get_mut(..bytes.saturating_sub(HEADER_BYTES))
            .ok_or(RecordError::Torn)?;
        self.flash
            .read(offset + HEADER_BYTES as u32, rest)
            .map_err(|_| RecordError::Unreadable)?;
        record::decode_into(&self.buffer, to)
    }

    /// A mark that cannot be read was torn while it was programmed: rolled back.
    fn is_marked(&mut self, slot: u8) -> bool {
        let mut mark = [ERASED; MARK_BYTES];
        let place = self.offset(slot) + MAX_BYTES as u32;
        self.flash.read(place, &mut mark).is_err() || mark != [ERASED; MARK_BYTES]
    }

    fn write_slot(&mut self, slot: u8, bytes: usize) -> Result<(), SlotError> {
        let offset = self.offset(slot);
        let end = offset + SLOT_BYTES as u32;
        self.flash
            .erase(offset, end)
            .map_err(|error| SlotError::Erase {
                slot,
                kind: error.kind(),
            })?;
        let record = self.buffer.get(..bytes).ok_or(RecordError::TooLong)?;
        self.flash
            .write(offset, record)
            .map_err(|error| SlotError::Write {
                slot,
                kind: error.kind(),
            })
    }

    #[inline(never)]
    fn check_slot(
        &mut self,
        slot: u8,
        calibration: &Calibration,
        sequence: u32,
    ) -> Result<(), SlotError> {
        let mut read = Calibration::identity(Geometry::PAPER);
        let found = self.fetch(slot, &mut read);
        if found == Ok(sequence) && read == *calibration && !self.is_marked(slot) {
            Ok(())
        } else {
            Err(SlotError::ReadBack { slot })
        }
    }
}

/// Which slot is in force.
fn newest(found: &[Found; SLOTS]) -> Option<usize> {
    match (found[0].candidate(), found[1].candidate()) {
        (Some(first), Some(second)) => Some(usize::from(second > first)),
        (Some(_), None) => Some(0),
        (None, Some(_)) => Some(1),
        (None, None) => None,
    }
}

/// With nothing in force, the slot with less to lose is written first.
fn loss(found: &Found) -> u8 {
    match found.result {
        Err(RecordError::Empty) => 0,
        Err(RecordError::UnknownVersion { .. }) => 3,
        Err(_) => 1,
        Ok(_) => 2,
    }
}
