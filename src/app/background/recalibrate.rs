//! A candidate of the recalibration while working comes in force: by itself where that is allowed, or by order.

use super::Background;
use crate::calibration::recalibration::{Idle, Mode, Order, Recalibration, amend};
use crate::calibration::record::Calibration;
use crate::calibration::slots::Place;
use crate::link::message::{InForce, RecordRefusal, Refusal, StoredMap};
use crate::math::sqrt;
use embedded_io::{Read, ReadReady, Write, WriteReady};
use embedded_storage::nor_flash::NorFlash;

impl<S, F> Background<'_, '_, S, F>
where
    S: Read + ReadReady + Write + WriteReady,
    F: NorFlash,
{
    /// How the recalibration stands.
    pub fn recalibration(&self) -> Recalibration {
        self.watcher.recalibration(self.task, self.hinders())
    }

    /// What stands in the way of any candidate.
    pub(super) fn hinders(&self) -> Option<Idle> {
        if !self.keeper.is_stored() {
            Some(Idle::NotStored)
        } else if self.keeper.map().is_some() {
            Some(Idle::ToothMap)
        } else {
            None
        }
    }

    /// Carries out what a host orders of it. Where a candidate has come in force, its place.
    ///
    /// # Errors
    /// [`Refusal::NoCandidate`], [`Refusal::ModeNotKept`], [`Refusal::Busy`], [`Refusal::Update`] while the image is on trial, and what
    /// storing a calibration is refused with; nothing is changed.
    #[inline(never)]
    pub fn recalibrate(&mut self, order: Order) -> Result<Option<Place>, Refusal> {
        self.idle()?;
        self.may_store()?;
        match order {
            Order::Set(mode) => {
                if self.keeper.is_stored() && !self.keeper.keep_mode(mode) {
                    return Err(Refusal::ModeNotKept);
                }
                self.watcher.set_mode(mode);
                Ok(None)
            }
            Order::Accept => self.adopt().map(Some),
            Order::Reject => {
                if !self.watcher.proposes(self.task) {
                    return Err(Refusal::NoCandidate);
                }
                self.watcher.rest(Idle::Rejected);
                Ok(None)
            }
        }
    }

    /// Puts a candidate in force that is proposed, where that is allowed. While the courier is moved or the interrupt has yet to take what
    /// came last, later.
    pub(super) fn recalibrate_by_itself(&mut self) {
        if self.watcher.mode() != Mode::Automatic
            || !self.watcher.proposes(self.task)
            || self.is_moving()
            || !self.keeper.is_taken()
            || self.may_calibrate().is_err()
            || self.has_stored_map()
        {
            return;
        }
        if self.adopt().is_err() {
            self.watcher.rest(Idle::NotKept);
        }
    }

    /// Stores what is in force with the candidate's changes, and puts it in force; the one before is one rollback away. The watch
    /// goes on with the reference that it has: changes are always counted from that, so that no errors add up.
    #[inline(never)] // a calibration on the stack
    fn adopt(&mut self) -> Result<Place, Refusal> {
        // Read where it is to stay: a copy of what is in force would pass through the stack.
        let mut calibration = Calibration::identity(self.keeper.settings().geometry);
        let InForce::Stored(before) = self.keeper.source() else {
            return Err(Refusal::NoCandidate);
        };
        self.keeper.read(before.slot, &mut calibration)?;
        self.amend(&mut calibration)?;
        let place = self.keeper.store(&calibration)?;
        self.go_on_with(calibration.made.uptime_s);
        Ok(place)
    }

    /// Takes the candidate's changes off a record's corrections.
    #[inline(never)]
    fn amend(&self, calibration: &mut Calibration) -> Result<(), Refusal> {
        let changes_m = self.watcher.changes_m(self.task);
        let changes_m = changes_m.ok_or(Refusal::NoCandidate)?;
        if !amend(&mut calibration.model, changes_m) {
            return Err(Refusal::Calibration(RecordRefusal::Invalid));
        }
        calibration.made = self.time();
        // They are not what was fitted at these poses any more.
        calibration.poses = None;
        let quality = &mut calibration.quality;
        let left_m = quality.residual_after_m;
        let square: f32 = changes_m.iter().map(|amount| 0.5 * amount * amount).sum();
        quality.residual_before_m = sqrt(left_m * left_m + square);
        Ok(())
    }

    #[inline(never)]
    fn go_on_with(&mut self, uptime_s: u32) {
        let outputs = self.keeper.outputs();
        if let Some(kept) = self.watcher.adopted(outputs, uptime_s, self.task) {
            // Without room the next restart learns another reference.
            self.keeper.keep(&kept);
        }
    }

    /// Whether stored tooth maps belong to the calibration in force: they would be lost with it.
    fn has_stored_map(&self) -> bool {
        !matches!(
            self.stored_map(),
            StoredMap::None | StoredMap::OtherCalibration { .. }
        )
    }
}
