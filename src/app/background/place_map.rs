//! The stored tooth maps in the background: looked for under a beacon, put in force, and taken out of it where they do not fit.

use super::Background;
use crate::app::homing::Placed;
use crate::frame::{Coordinate, Status};
use crate::link::message::{Refusal, StoredMap};
use crate::maps::homing::whole_teeth;
use crate::maps::mark::{self, MarkRefusal};
use embedded_io::{Read, ReadReady, Write, WriteReady};
use embedded_storage::nor_flash::NorFlash;

impl<S, F> Background<'_, '_, S, F>
where
    S: Read + ReadReady + Write + WriteReady,
    F: NorFlash,
{
    /// Takes the last frame, if there is a new one; between calibrations only, which move the courier about.
    #[inline(never)]
    pub(super) fn follow_maps(&mut self, is_new: bool) {
        self.keeper.go_on();
        if !is_new {
            return;
        }
        if self.changes_seen != Some(self.keeper.changes()) {
            self.changes_seen = Some(self.keeper.changes());
            let is_safe_mode = self.keeper.boot() == Err(Refusal::SafeMode);
            let keeper = &mut self.keeper;
            self.homing.begin(is_safe_mode, |slot| {
                let (info, belongs) = keeper.map_info(slot)?;
                Some((info, belongs, keeper.map_mark(slot).is_some()))
            });
        }
        let rate_hz = self.keeper.settings().rate_hz;
        let crossed = self.crossing.look(&self.last, self.at_mark, rate_hz);
        if self.task.is_running() || !self.keeper.is_taken() {
            return;
        }
        let has_map = self.keeper.map().is_some();
        if self.keeper.is_map_ordered() {
            self.homing.leave();
        } else if let Some(placed) = self.homing.found() {
            self.place(&placed, has_map);
        } else if has_map && self.homing.watch(&self.last) {
            self.keeper.map_drop();
        } else if let Some(place) = crossed.filter(|_| !has_map) {
            let keeper = &mut self.keeper;
            self.homing.crossed(&place, |slot| keeper.map_mark(slot));
        } else if !has_map || self.last.status.contains(Status::OUTSIDE_MAP) {
            let geometry = &self.keeper.settings().geometry;
            self.homing.look(&self.last, geometry, rate_hz);
        }
    }

    /// Puts a map in force whose teeth were found, at the turn after another one's end.
    fn place(&mut self, placed: &Placed, has_map: bool) {
        if has_map {
            return self.keeper.map_drop();
        }
        let result = self.keeper.map_place(placed.slot, placed.ahead_teeth());
        let uptime_s = self.samples as f32 / self.keeper.settings().rate_hz;
        self.homing.placed(placed, result, uptime_s);
    }

    /// Puts a stored map in force where the courier stands at a mark, whose place in the map's count is given.
    ///
    /// # Errors
    /// [`Refusal::Busy`], [`Refusal::Mark`], or as [`crate::app::keeper::Keeper::map_place`]; what was in force still is.
    #[inline(never)]
    pub fn map_at_mark(&mut self, slot: u8, place: &[Coordinate; 2]) -> Result<(), Refusal> {
        let (info, belongs) = self
            .keeper_mut()?
            .map_info(slot)
            .ok_or(MarkRefusal::NoMap(slot))?;
        if !belongs {
            return Err(MarkRefusal::OtherCalibration(slot).into());
        }
        if self.keeper.map().is_some() {
            return Err(MarkRefusal::InForce.into());
        }
        let ahead = mark::ahead(&self.last, place)?;
        let ahead_teeth = whole_teeth(&ahead).ok_or(MarkRefusal::NotWhole { ahead })?;
        self.keeper.map_place(slot, ahead_teeth)?;
        let placed = Placed::by_mark(slot, ahead, info.parity_m);
        let uptime_s = self.samples as f32 / self.keeper.settings().rate_hz;
        self.homing.placed(&placed, Ok(()), uptime_s);
        Ok(())
    }

    /// Keeps the place where the board has crossed its reference mark last, beside the stored map in force: from the next start on the mark
    /// puts that map in force.
    ///
    /// # Errors
    /// [`Refusal::Mark`], or nothing may be stored; what was kept before still counts.
    #[inline(never)]
    pub fn map_keep_mark(&mut self) -> Result<(), Refusal> {
        let StoredMap::InForce { slot, ahead, .. } = self.homing.state() else {
            return Err(MarkRefusal::NotInForce.into());
        };
        let counted = self.crossing.last().ok_or(MarkRefusal::NotCrossed)?;
        let place = mark::place(counted, ahead);
        self.keeper_to_store()?.keep_mark(slot, &place)
    }

    /// What has become of the stored tooth maps.
    pub fn stored_map(&self) -> StoredMap {
        self.homing.state()
    }
}
