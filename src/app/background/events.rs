//! The log of the board's story in the background: written between two turns, while no session needs every frame.

use super::Background;
use crate::app::events::Seen;
use crate::app::restarts::StartReport;
use crate::calibration::rest_watch::RestKind;
use crate::event_log::entry::{Ending, Event};
use crate::event_log::page::Page;
use crate::event_log::store::EventLog;
use crate::link::message::Refusal;
use crate::update::layout::{LOG_END, LOG_START};
use embedded_io::{Read, ReadReady, Write, WriteReady};
use embedded_storage::nor_flash::NorFlash;

impl<S, F> Background<'_, '_, S, F>
where
    S: Read + ReadReady + Write + WriteReady,
    F: NorFlash,
{
    /// Writes down what has happened since, one entry at most. To be called ten times a second. In safe mode, which leaves alone what is stored, and
    /// while an image is on trial, nothing is written.
    pub fn keep_events(&mut self, started: &StartReport) {
        self.keep_event(Some(started), false);
    }

    /// Writes the start down before anything else that a host orders.
    pub fn keep_start(&mut self, started: &StartReport) {
        self.keep_event(Some(started), true);
    }

    #[inline(never)]
    pub(super) fn keep_event(&mut self, started: Option<&StartReport>, at_once: bool) {
        if self.task.is_running() || !self.may_log() {
            return;
        }
        let updates = self.updates.as_ref();
        let recalibration = self.recalibration();
        let seen = Seen {
            time: self.time(),
            in_force: self.keeper.source(),
            boot: self.keeper.boot(),
            firmware: updates.map_or(crate::update::version::Version::OWN, |updates| {
                updates.running()
            }),
            started,
            at_once,
            verdict: self.verdict(),
            rests: RestKind::ALL.map(|kind| self.rest_verdict(kind)),
            map: self.stored_map(),
            ended: self.ended.as_ref().map(ending),
            taken: updates.and_then(|updates| updates.taken()),
            proposed: recalibration.state.proposed(),
            adopted: recalibration.adopted,
        };
        self.open_log();
        if let Some(event) = self.events.next(&seen) {
            self.write_event(&event);
        }
    }

    /// Writes an event at once: before a session's first motion, and after an order.
    #[inline(never)]
    pub(super) fn log_event(&mut self, event: &Event) {
        let uptime_s = self.time().uptime_s;
        if self.may_log() {
            self.open_log();
            if self.events.may_write(uptime_s) {
                self.write_event(event);
            }
        }
    }

    fn may_log(&self) -> bool {
        self.may_store().is_ok() && !matches!(self.keeper.boot(), Err(Refusal::SafeMode))
    }

    fn log(&mut self) -> EventLog<'_, F> {
        EventLog::new(self.keeper.flash_mut(), LOG_START..LOG_END)
    }

    fn open_log(&mut self) {
        if self.events.is_closed() {
            let end = self.log().end();
            self.events.open(&end);
        }
    }

    #[inline(never)]
    fn write_event(&mut self, event: &Event) {
        let time = self.time();
        let head = self.events.head(time);
        // What the flash does not take is lost: nothing else depends on it.
        if self.log().append(&head, event).is_ok() {
            self.events.has_written(head);
        }
    }

    /// Entries behind the first `skip`, as many as a reply carries.
    ///
    /// # Errors
    /// [`Refusal::Busy`]: it takes milliseconds, which a session does not have.
    #[inline(never)]
    pub fn kept_log(&mut self, skip: u16, page: &mut Page) -> Result<(), Refusal> {
        self.idle()?;
        self.log().page(skip, page);
        Ok(())
    }
}

fn ending(ended: &super::Ended) -> (Ending, [f32; 2]) {
    let ending = match (ended.result, ended.not_kept) {
        (Err(refusal), _) => Ending::Refused(refusal),
        (Ok(_), Some(_)) => Ending::NotKept,
        (Ok(place), None) => Ending::Accepted(place),
    };
    let evidence = &ended.evidence;
    (ending, [evidence.held_out_in_force_m, evidence.held_out_m])
}
