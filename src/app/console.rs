//! The debug link's end on the board: commands to the background and its answers back. The stream of samples is the intake's.
//!
//! Never blocks: a reply waits in its own buffer until the channel has room, and no further command is read until then.

use super::background::Background;
use super::intake::OrderSender;
use super::keeper::Keeper;
use super::ordered::{calibrate, calibrate_joint, progress};
use super::restarts::StartReport;
use crate::calibration::record::{Calibration, Method};
use crate::calibration::rest_watch::RestKind;
use crate::calibration::slots::Place;
use crate::event_log::page::Page;
use crate::link::framing;
use crate::link::message::{
    Action, Activity, BoardStatus, FRAME_BYTES, Hello, Refusal, Reply, Source,
};
use crate::link::server::{Event, Server};
use crate::link::telemetry::{Channels, StreamOrder};
use embedded_io::{Read, ReadReady, Write, WriteReady};
use embedded_storage::nor_flash::NorFlash;

/// Command bytes taken at one poll.
const BYTES_A_POLL: usize = 256;

/// The link's byte channels. Nothing here may wait.
pub trait Ports {
    /// Takes command bytes that have come; how many.
    fn read_commands(&mut self, bytes: &mut [u8]) -> usize;
    /// Gives reply bytes; how many the channel took.
    fn write_replies(&mut self, bytes: &[u8]) -> usize;
}

/// The board's end of the link. Owned by the background's loop.
pub struct Console<'q, P> {
    ports: P,
    server: Server,
    streams: OrderSender<'q>,
    reply: [u8; FRAME_BYTES],
    unsent: core::ops::Range<usize>,
    started: StartReport,
    restart: bool,
}

impl<'q, P: Ports> Console<'q, P> {
    /// For a board that introduces itself as `hello` says. `streams`: the way to the intake.
    pub fn new(ports: P, streams: OrderSender<'q>, hello: Hello, started: StartReport) -> Self {
        Self {
            ports,
            server: Server::new(hello),
            streams,
            reply: [0; FRAME_BYTES],
            unsent: 0..0,
            started,
            restart: false,
        }
    }

    /// Whether the host asked for a restart and has been answered.
    pub fn wants_restart(&self) -> bool {
        self.restart && self.unsent.is_empty()
    }

    /// Notes how many conversions BUSY has not answered since start.
    pub fn note_unanswered(&mut self, conversions: i32) {
        self.started.health.unanswered = Some(conversions);
    }

    /// Why the board started.
    pub fn started(&self) -> &StartReport {
        &self.started
    }

    /// Whether the board leaves alone what is stored.
    pub fn is_safe_mode(&self) -> bool {
        self.started.health.safe_mode
    }

    /// Sends what waits, then carries out at most one command; none while the interrupt has yet to take what was put in
    /// force last, as it does at its next sample: a command that changes that would be refused for no good reason.
    #[inline(never)]
    pub fn serve<S, F>(&mut self, background: &mut Background<'_, '_, S, F>)
    where
        S: Read + ReadReady + Write + WriteReady,
        F: NorFlash,
    {
        self.flush();
        if !background.is_settled() {
            return;
        }
        for _ in 0..BYTES_A_POLL {
            let mut byte = [0];
            if !self.unsent.is_empty() || self.restart || self.ports.read_commands(&mut byte) == 0 {
                return;
            }
            match &self.server.feed(byte[0]) {
                Some(Event::Answer(response)) => self.send(response.number, &response.reply),
                Some(Event::Act { number, action }) => {
                    return self.answer(*number, action, background);
                }
                None => {}
            }
        }
    }

    #[inline(never)]
    fn send(&mut self, number: u16, reply: &Reply<&Calibration>) {
        // As a `Response`, of which postcard leaves no more than the two. It always fits: the buffer is the protocol's longest frame.
        let length = framing::encode(&(number, reply), &mut self.reply).map_or(0, <[u8]>::len);
        self.unsent = 0..length;
        self.flush();
    }

    fn flush(&mut self) {
        if let Some(bytes) = self
            .reply
            .get(self.unsent.clone())
            .filter(|bytes| !bytes.is_empty())
        {
            let taken = self.ports.write_replies(bytes);
            self.unsent.start = (self.unsent.start + taken).min(self.unsent.end);
        }
    }

    #[inline(never)] // frames are there only while they are needed
    fn answer<S, F>(
        &mut self,
        number: u16,
        action: &Action<()>,
        background: &mut Background<'_, '_, S, F>,
    ) where
        S: Read + ReadReady + Write + WriteReady,
        F: NorFlash,
    {
        match action {
            Action::Read(Source::InForce) => self.send_in_force(number, background),
            Action::Read(Source::Slot(slot)) => self.send_slot(number, *slot, background),
            Action::RollBack => {
                let place = background.keeper_to_store().and_then(Keeper::roll_back);
                self.send_result(number, place.map(Some));
            }
            Action::MapAtMark { slot, mark } => {
                let placed = background.map_at_mark(*slot, mark);
                self.send_result(number, placed.map(|()| None));
            }
            Action::MapKeepMark => {
                let kept = background.map_keep_mark();
                self.send_result(number, kept.map(|()| None));
            }
            Action::Recalibrate(order) => {
                let result = background.recalibrate(*order);
                self.send_result(number, result);
            }
            Action::Calibrate(order) => {
                background.keep_start(&self.started);
                let started = match order.method {
                    Method::Platen => calibrate(order, background),
                    Method::Joint => calibrate_joint(order, background),
                };
                self.send_result(number, started.map(|()| None));
            }
            Action::Load { other_device, .. } => {
                let loaded = self.load(*other_device, background);
                self.send_result(number, loaded.map(|()| None));
            }
            other => self.send_act(number, other, background),
        }
    }

    #[inline(never)]
    fn send_result(&mut self, number: u16, result: Result<Option<Place>, Refusal>) {
        self.send(
            number,
            &match result {
                Ok(Some(place)) => Reply::Place(place),
                Ok(None) => Reply::Done,
                Err(refusal) => Reply::Refused(refusal),
            },
        );
    }

    #[inline(never)]
    fn send_in_force<S, F>(&mut self, number: u16, background: &Background<'_, '_, S, F>)
    where
        S: Read + ReadReady + Write + WriteReady,
        F: NorFlash,
    {
        let reply = match background.keeper().in_force() {
            Some(calibration) => Reply::Calibration(calibration),
            None => Reply::Refused(Refusal::NotCalibrated),
        };
        self.send(number, &reply);
    }

    #[inline(never)]
    fn send_act<S, F>(
        &mut self,
        number: u16,
        action: &Action<()>,
        background: &mut Background<'_, '_, S, F>,
    ) where
        S: Read + ReadReady + Write + WriteReady,
        F: NorFlash,
    {
        let reply = self.act(action, background).unwrap_or_else(Reply::Refused);
        self.send(number, &reply);
    }

    #[inline(never)]
    fn send_slot<S, F>(&mut self, number: u16, slot: u8, background: &mut Background<'_, '_, S, F>)
    where
        S: Read + ReadReady + Write + WriteReady,
        F: NorFlash,
    {
        let mut calibration = Calibration::identity(background.keeper().settings().geometry);
        let read = background
            .keeper_mut()
            .and_then(|keeper| keeper.read(slot, &mut calibration));
        let reply = match read {
            Ok(_) => Reply::Calibration(&calibration),
            Err(refusal) => Reply::Refused(refusal),
        };
        self.send(number, &reply);
    }

    #[inline(never)]
    fn load<S, F>(
        &self,
        other_device: bool,
        background: &mut Background<'_, '_, S, F>,
    ) -> Result<(), Refusal>
    where
        S: Read + ReadReady + Write + WriteReady,
        F: NorFlash,
    {
        let keeper = background.keeper_mut()?;
        let mut calibration = Calibration::identity(keeper.settings().geometry);
        self.server.loaded(&mut calibration)?;
        if other_device {
            calibration.device = keeper.device();
        }
        keeper.load(&calibration)
    }

    /// What each command does; what needs much of the stack is [`Console::answer`]'s.
    #[inline(never)]
    fn act<S, F>(
        &mut self,
        action: &Action<()>,
        background: &mut Background<'_, '_, S, F>,
    ) -> Result<Reply<&'static Calibration>, Refusal>
    where
        S: Read + ReadReady + Write + WriteReady,
        F: NorFlash,
    {
        match action {
            Action::Status => Ok(Reply::Status(self.status(background))),
            Action::Abort => background.abort().map(done),
            Action::Progress => Ok(Reply::Progress(progress(background))),
            Action::GoTo {
                target,
                speed_m_per_s,
            } => background.go_to(*target, *speed_m_per_s).map(done),
            Action::Read(_)
            | Action::Load { .. }
            | Action::Calibrate(_)
            | Action::Recalibrate(_)
            | Action::RollBack
            | Action::MapAtMark { .. }
            | Action::MapKeepMark => Err(Refusal::Unknown),
            Action::MapBegin(header) => background.keeper_mut()?.map_begin(header).map(done),
            Action::MapNodes(nodes) => background.keeper_mut()?.map_nodes(nodes).map(done),
            Action::MapApply => background.keeper_mut()?.map_apply().map(done),
            Action::MapDrop => {
                let keeper = background.keeper_mut()?;
                keeper.map_drop();
                keeper.map_ordered();
                Ok(Reply::Done)
            }
            Action::MapStore { place, header } => {
                let keeper = background.keeper_to_store()?;
                keeper.map_store(place, header).map(done)
            }
            Action::MapStoreNodes(nodes) => {
                let keeper = background.keeper_to_store()?;
                keeper.map_store_nodes(nodes).map(done)
            }
            Action::MapStoreEnd => {
                let keeper = background.keeper_to_store()?;
                keeper.map_store_end().map(Reply::MapSlot)
            }
            Action::MapSlot(slot) => {
                let keeper = background.keeper_mut()?;
                keeper.map_slot(*slot).map(Reply::MapSlot)
            }
            Action::MapForget(slot) => {
                let keeper = background.keeper_to_store()?;
                keeper.map_forget(*slot).map(done)
            }
            Action::Commit { lose_unknown } => background
                .keeper_to_store()?
                .commit(*lose_unknown)
                .map(Reply::Place),
            Action::Slots => Ok(Reply::Slots(
                background.keeper_mut()?.list().map(Into::into),
            )),
            Action::Stream(order) => self.stream(*order).map(done),
            Action::Record { samples } => self
                .stream(StreamOrder {
                    channels: Channels::RECORDING.bits(),
                    decimation: 1,
                    samples: *samples,
                })
                .map(done),
            Action::SetTime { unix_s } => {
                background.set_time(*unix_s);
                Ok(Reply::Done)
            }
            Action::Update(order) => background.update(order).map(Reply::Update),
            Action::LastFault => Ok(Reply::LastFault(self.started.fault.clone())),
            Action::KeptLog { skip } => {
                let mut page = Page::default();
                background.kept_log(*skip, &mut page)?;
                Ok(Reply::KeptLog(page))
            }
            Action::Restart => {
                self.restart = true;
                Ok(Reply::Done)
            }
        }
    }

    /// Gives an order to the intake, which starts with its next frame.
    fn stream(&mut self, order: StreamOrder) -> Result<(), Refusal> {
        self.streams.enqueue(order).map_err(|_| Refusal::Busy)
    }

    #[inline(never)]
    fn status<S, F>(&self, background: &mut Background<'_, '_, S, F>) -> BoardStatus
    where
        S: Read + ReadReady + Write + WriteReady,
        F: NorFlash,
    {
        let (frame, mailbox) = (background.last_frame(), background.mailbox());
        let seen = mailbox.take_status();
        BoardStatus {
            time: background.time(),
            samples: mailbox.samples(),
            missed: mailbox.missed(),
            dropped_frames: mailbox.dropped(),
            lost_telemetry: mailbox.unsent(),
            status: frame.status.bits(),
            status_seen: seen.bits(),
            activity: if background.is_calibrating() {
                Activity::Calibrating
            } else {
                Activity::Idle
            },
            moving: background.is_moving(),
            in_force: background.keeper().source(),
            map: background.keeper().map(),
            stored_map: background.stored_map(),
            pose: frame.pose,
            parity_m: frame.parity_m,
            amplitude_counts: frame.segments.map(|segment| segment.amplitude_counts),
            temperature_c: background.temperature_c(),
            link: self.server.counters(),
            motion: background.motion_counters().frames,
            reset: self.started.cause,
            boot: background.keeper().boot().err(),
            isr_cycles_worst: Some(mailbox.isr_cycles_worst()).filter(|cycles| *cycles > 0),
            health: self.started.health,
            watch: background.verdict(),
            beacon_watch: background.rest_verdict(RestKind::Beacon),
            parity_watch: background.rest_verdict(RestKind::Parity),
            recalibration: background.recalibration(),
        }
    }
}

fn done((): ()) -> Reply<&'static Calibration> {
    Reply::Done
}
