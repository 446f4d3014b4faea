//! Tooth maps in flash: storing them, and putting one in force where the beacon says that it lies.
//!
//! A stored map in force is a layer above the calibration in force: its own coefficients of equations (3) and (9) and the beacon's place
//! stand in for the calibration's, which stays what it is and comes back when the map goes.

use super::Keeper;
use super::entries;
use crate::calibration::record::read_model;
use crate::calibration::slots::SlotState;
use crate::frame::Coordinate;
use crate::link::message::{MapPlace, Refusal};
use crate::maps::crossing::{from_bytes, to_bytes};
use crate::maps::mark::MarkRefusal;
use crate::maps::{MapHead, MapInfo, MapRecordError, MapSlot, MapSlotState, MapStoreError, Maps};
use crate::model::ErrorModel;
use crate::teeth::MapHeader;
use crate::update::layout::MAPS_START;
use embedded_storage::nor_flash::NorFlash;

impl<F: NorFlash> Keeper<'_, '_, F> {
    fn maps(&mut self) -> Maps<'_, F> {
        let owner = self.device;
        Maps::new(self.slots.flash_mut(), MAPS_START, owner)
    }

    /// What a map slot holds.
    ///
    /// # Errors
    /// [`Refusal::MapStore`].
    pub fn map_slot(&mut self, slot: u8) -> Result<MapSlot, Refusal> {
        let mut told = self.maps().slot(slot)?;
        if told.state == MapSlotState::Current {
            told.mark = self.map_mark(slot);
        }
        Ok(told)
    }

    /// Takes a stored map out of use; one that is in force stays so until the board restarts.
    ///
    /// # Errors
    /// [`Refusal::MapStore`].
    pub fn map_forget(&mut self, slot: u8) -> Result<(), Refusal> {
        self.maps().forget(slot)?;
        self.note_change();
        Ok(())
    }

    /// Begins to store a tooth map with the model in force, for the stored calibration; 70 ms.
    ///
    /// # Errors
    /// [`Refusal::NotCalibrated`], [`Refusal::Slots`] without a stored calibration, [`Refusal::MapTooDear`], [`Refusal::Map`],
    /// [`Refusal::MapStore`]; the stored calibration comes back then.
    #[inline(never)]
    pub fn map_store(&mut self, place: &MapPlace, header: &MapHeader) -> Result<(), Refusal> {
        let begun = self.begin_storing(place, header);
        begun.inspect_err(|_| self.end_storing())
    }

    fn begin_storing(&mut self, place: &MapPlace, header: &MapHeader) -> Result<(), Refusal> {
        self.storing = None;
        self.afford_map()?;
        let info = MapInfo {
            device: self.device,
            name: place.name.clone(),
            calibration: self.stored_calibration()?,
            anchor: place.anchor,
            parity_m: place.parity_m,
        };
        let invalid = |error| MapStoreError::Record { slot: 0, error };
        info.validate().map_err(invalid)?;
        let model = &self.in_force.as_ref().ok_or(Refusal::NotCalibrated)?.model;
        let head = MapHead {
            info: &info,
            model,
            header,
        };
        let owner = self.device;
        let (flash, buffer) = self.slots.parts_mut();
        let head = head.encode(buffer).ok_or(MapStoreError::TooLong)?;
        let mut maps = Maps::new(flash, MAPS_START, owner);
        self.storing = Some(maps.begin(&info.name, head, header.nodes() as u16)?);
        Ok(())
    }

    /// Stores its next nodes.
    ///
    /// # Errors
    /// [`Refusal::MapStore`].
    pub fn map_store_nodes(&mut self, nodes_nm: &[i16]) -> Result<(), Refusal> {
        let mut writing = self.storing.take().ok_or(NOT_BEGUN)?;
        let appended = self.maps().append_nodes(&mut writing, nodes_nm);
        match appended {
            Ok(()) => self.storing = Some(writing),
            Err(_) => self.end_storing(),
        }
        Ok(appended?)
    }

    /// Ends it: the map counts. The stored calibration is in force then.
    ///
    /// # Errors
    /// [`Refusal::MapStore`]; the place's map before still counts.
    pub fn map_store_end(&mut self) -> Result<MapSlot, Refusal> {
        let writing = self.storing.take().ok_or(NOT_BEGUN)?;
        let stored = self.maps().finish(writing);
        self.end_storing();
        self.map_slot(stored?)
    }

    /// From the next turn on the stored calibration is in force: [`Keeper::go_on`].
    fn end_storing(&mut self) {
        self.storing = None;
        self.is_to_return = self.stored.is_none();
        self.note_change();
    }

    /// Brings the stored calibration back after a map was stored, or the settings of the one in force after a map has gone. To be called at
    /// each turn of the background: a command's answer has no stack left for it.
    pub fn go_on(&mut self) {
        if !(self.is_to_return || self.is_to_restore) || !self.swap.taken() {
            return;
        }
        self.is_to_restore = false;
        if core::mem::take(&mut self.is_to_return) {
            // Where it fails nothing is in force, and the status says so.
            let _ = self.load_stored();
        } else {
            self.restore_settings();
            // They were in force before.
            if self.build().is_ok() {
                let _ = self.swap.send();
            }
        }
    }

    /// Check value of the calibration that is in force after a restart.
    fn stored_calibration(&mut self) -> Result<u32, Refusal> {
        let slots = self.slots.list();
        let newest = slots.iter().find(|slot| slot.state == SlotState::InForce);
        let value = newest.and_then(|slot| self.slots.check_value(slot.slot));
        value.ok_or(Refusal::Slots(
            crate::link::message::SlotRefusal::NoneInForce,
        ))
    }

    /// What the map in a slot is of, if it is its place's newest; and whether it belongs to the calibration in force.
    pub fn map_info(&mut self, slot: u8) -> Option<(MapInfo, bool)> {
        let found = self.maps().current(slot)?;
        let in_force = self
            .stored
            .and_then(|place| self.slots.check_value(place.slot));
        let belongs = in_force == Some(found.info.calibration);
        Some((found.info, belongs))
    }

    /// The place of a map's reference mark in its count, if one is kept.
    #[inline(never)]
    pub fn map_mark(&mut self, slot: u8) -> Option<[Coordinate; 2]> {
        let room = self.maps().places(slot);
        entries::last(self.slots.flash_mut(), &room, from_bytes)
    }

    /// Keeps the place of a map's reference mark, beside the map: 0.3 ms of flash. The last one counts.
    ///
    /// # Errors
    /// [`MarkRefusal::NotKept`]; the one before still counts.
    #[inline(never)]
    pub fn keep_mark(&mut self, slot: u8, place: &[Coordinate; 2]) -> Result<(), Refusal> {
        let room = self.maps().places(slot);
        let is_kept = entries::add(self.slots.flash_mut(), &room, &to_bytes(place))
            && self.map_mark(slot) == Some(*place);
        match is_kept {
            true => Ok(()),
            false => Err(MarkRefusal::NotKept.into()),
        }
    }

    /// Puts a stored map in force in the count of this start, which is so many teeth ahead of the map's.
    ///
    /// # Errors
    /// [`Refusal::SwapBusy`], [`Refusal::MapBusy`]: try again; [`Refusal::MapStore`], [`Refusal::Map`], [`Refusal::MapTooDear`],
    /// [`Refusal::Calibration`]. What was in force still is.
    #[inline(never)]
    pub fn map_place(&mut self, slot: u8, ahead_teeth: [i32; 2]) -> Result<(), Refusal> {
        if !self.swap.taken() {
            return Err(Refusal::SwapBusy);
        }
        self.prepare_map(slot, ahead_teeth)
            .and_then(|()| self.build())
            .inspect_err(|_| self.restore_settings())?;
        self.swap.send().map_err(|_| Refusal::SwapBusy)?;
        self.is_layered = true;
        self.map_in_force()
    }

    /// Reads a map into its memory, and its model and beacon into the settings.
    fn prepare_map(&mut self, slot: u8, ahead_teeth: [i32; 2]) -> Result<(), Refusal> {
        let torn = MapStoreError::Record {
            slot,
            error: MapRecordError::Torn,
        };
        let invalid = MapStoreError::Record {
            slot,
            error: MapRecordError::Invalid,
        };
        let owner = self.device;
        let (flash, buffer) = self.slots.parts_mut();
        let mut maps = Maps::new(flash, MAPS_START, owner);
        let found = maps.current(slot).ok_or(torn)?;
        let head = maps.head(slot, &found, buffer)?;
        let model = self.settings.model.get_or_insert_with(ErrorModel::default);
        let rest = read_model(head, model).ok_or(invalid)?;
        model.validate().map_err(|_| invalid)?;
        let (mut header, _) = postcard::take_from_bytes::<MapHeader>(rest).map_err(|_| invalid)?;
        header.move_by(ahead_teeth);
        if let Some(beacon) = &mut self.settings.beacon {
            let anchor = &found.info.anchor;
            (beacon.origin_teeth, beacon.origin_m) =
                anchor.origin(ahead_teeth, &self.settings.geometry);
        }
        let map = self.swap.map_mut().ok_or(Refusal::MapBusy)?;
        map.begin(&header, &self.settings.geometry)
            .map_err(Refusal::Map)?;
        maps.nodes(slot, &found, |nodes_nm| map.extend(nodes_nm).is_ok())?;
        map.complete().map_err(Refusal::Map)?;
        self.afford_map()
    }
}

const NOT_BEGUN: Refusal = Refusal::MapStore(MapStoreError::Nodes {
    found: 0,
    wanted: 0,
});
