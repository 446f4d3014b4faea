//! An update of the firmware beside the background's other work, and what it forbids meanwhile.

use super::Background;
use crate::app::keeper::Keeper;
use crate::event_log::entry::Event;
use crate::link::message::Refusal;
use crate::update::install::UpdateRefusal;
use crate::update::order::{UpdateOrder, UpdateStatus};
use embedded_io::{Read, ReadReady, Write, WriteReady};
use embedded_storage::nor_flash::NorFlash;

impl<'q, 'c, S, F> Background<'q, 'c, S, F>
where
    S: Read + ReadReady + Write + WriteReady,
    F: NorFlash,
{
    /// Carries out what a host orders of an update. One is begun only while nothing else is under way: each page that it erases keeps the
    /// background from taking frames for some 22 ms, which a calibration that averages a pose would lose.
    ///
    /// # Errors
    /// [`Refusal::Busy`], [`Refusal::Update`].
    #[inline(never)]
    pub fn update(&mut self, order: &UpdateOrder) -> Result<UpdateStatus, Refusal> {
        if matches!(order, UpdateOrder::Begin { .. }) {
            self.idle()?;
            if self.is_moving() {
                return Err(Refusal::Update(UpdateRefusal::Moving));
            }
        }
        let uptime_s = self.time().uptime_s;
        let updates = self.updates.as_mut();
        let updates = updates.ok_or(Refusal::Update(UpdateRefusal::NotOffered))?;
        let done = updates.act(self.keeper.flash_mut(), order, uptime_s);
        if let (UpdateOrder::Accept, Ok(status)) = (order, &done) {
            self.log_event(&Event::ImageAccepted(status.running));
        }
        done.map_err(Refusal::Update)
    }

    /// Whether the image that runs was on trial and nobody accepted it: the board is to restart, and the one before comes back.
    pub fn is_trial_over(&mut self) -> bool {
        let uptime_s = self.time().uptime_s;
        let flash = self.keeper.flash_mut();
        let updates = self.updates.as_mut();
        updates.is_some_and(|updates| updates.is_over(flash, uptime_s))
    }

    /// An image on trial stores nothing: if it went back, what it stored would be lost.
    pub(super) fn may_store(&self) -> Result<(), Refusal> {
        match &self.updates {
            Some(updates) if updates.is_on_trial() => Err(Refusal::Update(UpdateRefusal::OnTrial)),
            _ => Ok(()),
        }
    }

    /// A calibration begins only while no update is taken in, for the same reason as the other way round ([`Background::update`]).
    pub(super) fn may_calibrate(&self) -> Result<(), Refusal> {
        self.idle()?;
        self.may_store()?;
        match &self.updates {
            Some(updates) if updates.is_under_way() => {
                Err(Refusal::Update(UpdateRefusal::UnderWay))
            }
            _ => Ok(()),
        }
    }

    /// Slots and what is in force, to change what is stored.
    ///
    /// # Errors
    /// [`Refusal::Busy`], [`Refusal::Update`] while the image that runs is on trial.
    pub fn keeper_to_store(&mut self) -> Result<&mut Keeper<'q, 'c, F>, Refusal> {
        self.may_store()?;
        self.keeper_mut()
    }
}
