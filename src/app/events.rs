//! What is new in the board's state since the log was written last: one entry at a time. Pure: state in, an event out.
//!
//! States are compared, so nothing waits in a queue: what changes to and fro before it can be written is one entry, or none.

use super::restarts::StartReport;
use crate::calibration::recalibration::Proposal;
use crate::calibration::record::Instant;
use crate::calibration::rest_watch::{RestKind, RestVerdict};
use crate::calibration::watch::{Standing, Verdict};
use crate::event_log::entry::{Ending, Event, Fault, Head, MESSAGE_BYTES, MapEvent};
use crate::event_log::pace::{MOST_SHORT_STARTS, Pace, SETTLED_S, START_S};
use crate::event_log::store::End;
use crate::frame::Status;
use crate::link::message::{InForce, Refusal, StoredMap};
use crate::update::version::Version;
use heapless::String;

/// Status bits that other entries tell of, or that are no fault.
const NO_FAULT: Status = Status::UNCALIBRATED
    .union(Status::BEACON_MISSING)
    .union(Status::OUTSIDE_MAP)
    .union(Status::CALIBRATION_DRIFT);

/// The board's state, as far as the log follows it.
#[derive(Clone, Debug)]
pub struct Seen<'s> {
    /// Time.
    pub time: Instant,
    /// Where the calibration in force is from.
    pub in_force: InForce,
    /// Why none came in force at the start.
    pub boot: Result<(), Refusal>,
    /// The firmware that runs.
    pub firmware: Version,
    /// Why the board started; none where the start is not to be written.
    pub started: Option<&'s StartReport>,
    /// The start is to be written however short it is.
    pub at_once: bool,
    /// How the calibration in force stands.
    pub verdict: Verdict,
    /// How it stands by the courier's rests, by [`RestKind`].
    pub rests: [RestVerdict; 2],
    /// What has become of the stored tooth maps.
    pub map: StoredMap,
    /// How the last session ended, and the held-out residuals.
    pub ended: Option<(Ending, [f32; 2])>,
    /// A new firmware that was taken in.
    pub taken: Option<Version>,
    /// A candidate that the recalibration proposes.
    pub proposed: Option<Proposal>,
    /// Candidates that came in force since the start.
    pub adopted: u16,
}

/// Owned by the background.
#[derive(Clone, Debug, Default)]
pub struct Events {
    /// Head of the last entry, once the log was looked into.
    last: Option<Head>,
    /// The last starts were short ones: nothing is written before this one is settled.
    is_quiet: bool,
    /// The start was written.
    is_started: bool,
    is_ended_told: bool,
    is_taken_told: bool,
    is_proposal_told: bool,
    adopted: u16,
    pace: Pace,
    /// Status bits that were seen, and that were told.
    status_seen: u32,
    status_told: u32,
    in_force: InForce,
    /// Kind and slot.
    map: (u8, u8),
    standing: Standing,
    rests: [Standing; 2],
}

impl Events {
    /// Takes a frame's status bits.
    pub fn see(&mut self, status: Status) {
        self.status_seen |= status.difference(NO_FAULT).bits();
    }

    /// Whether the log is to be looked into: [`Events::open`].
    pub fn is_closed(&self) -> bool {
        self.last.is_none()
    }

    /// Goes on behind the end of the log.
    pub fn open(&mut self, end: &End) {
        self.is_quiet = end.short_starts >= MOST_SHORT_STARTS;
        self.last = Some(Head {
            start: end.last.start.saturating_add(1),
            ..end.last
        });
    }

    /// Head of the next entry.
    pub fn head(&mut self, time: Instant) -> Head {
        let last = self.last.unwrap_or_default();
        Head {
            number: last.number.saturating_add(1),
            start: last.start,
            time,
        }
    }

    /// An entry was written.
    pub fn has_written(&mut self, head: Head) {
        self.last = Some(head);
    }

    /// Whether something may be written at a time since start that is not the start itself.
    pub fn may_write(&mut self, uptime_s: u32) -> bool {
        !self.is_too_early(uptime_s) && self.pace.take(uptime_s)
    }

    /// Another session is under way.
    pub fn session_begun(&mut self) {
        self.is_ended_told = false;
    }

    fn is_too_early(&self, uptime_s: u32) -> bool {
        self.is_quiet && uptime_s < SETTLED_S
    }

    /// What is to be written next; it counts as told from then on.
    #[inline(never)]
    pub fn next(&mut self, seen: &Seen<'_>) -> Option<Event> {
        let uptime_s = seen.time.uptime_s;
        if !self.is_started {
            return self.start(seen);
        }
        let mut told = self.clone();
        let event = told.change(seen);
        if event.is_some() && !self.may_write(uptime_s) {
            return None;
        }
        let pace = self.pace;
        *self = Self { pace, ..told };
        event
    }

    fn start(&mut self, seen: &Seen<'_>) -> Option<Event> {
        let started = seen.started?;
        let uptime_s = seen.time.uptime_s;
        let is_due = seen.at_once || uptime_s >= START_S || started.fault.is_some();
        if !is_due || self.is_too_early(uptime_s) {
            return None;
        }
        self.is_started = true;
        self.in_force = seen.in_force;
        Some(Event::Started {
            cause: started.cause,
            faults_in_a_row: started.health.faults_in_a_row,
            firmware: seen.firmware,
            in_force: seen.in_force,
            boot: seen
                .boot
                .err()
                .filter(|why| !matches!(why, Refusal::NotCalibrated)),
            fault: started.fault.as_ref().map(|fault| Fault {
                uptime_s: fault.uptime_s,
                program_counter: fault.program_counter,
                link_register: fault.link_register,
                message: beginning(&fault.message),
            }),
        })
    }

    fn change(&mut self, seen: &Seen<'_>) -> Option<Event> {
        let is_adopted = core::mem::replace(&mut self.adopted, seen.adopted) != seen.adopted;
        if let Some((ending, held_out_m)) = seen.ended.filter(|_| !self.is_ended_told) {
            self.is_ended_told = true;
            // What came in force by it is told by it.
            if matches!(ending, Ending::Accepted(_)) {
                self.put_in_force(seen.in_force);
            }
            return Some(Event::CalibrationEnded { ending, held_out_m });
        }
        if seen.in_force != self.in_force {
            let now = seen.in_force;
            let rolled_back = is_older(now, self.in_force);
            self.put_in_force(now);
            return Some(match is_adopted {
                true if !rolled_back => Event::Recalibrated(now),
                _ => Event::InForce { now, rolled_back },
            });
        }
        let is_taken = seen.taken.is_some();
        if core::mem::replace(&mut self.is_taken_told, is_taken) != is_taken
            && let Some(version) = seen.taken
        {
            return Some(Event::ImageTaken(version));
        }
        self.map(&seen.map)
            .or_else(|| self.watch(&seen.verdict))
            .or_else(|| self.watch_rests(RestKind::Beacon, &seen.rests))
            .or_else(|| self.watch_rests(RestKind::Parity, &seen.rests))
            .or_else(|| self.proposal(seen.proposed))
            .or_else(|| self.status())
    }

    fn put_in_force(&mut self, in_force: InForce) {
        self.in_force = in_force;
        // Maps are looked for anew, and it stands otherwise.
        self.map = (0, 0);
        (self.standing, self.rests) = (Standing::Unwatched, [Standing::Unwatched; 2]);
        self.is_proposal_told = false;
    }

    fn map(&mut self, map: &StoredMap) -> Option<Event> {
        let (kind, event) = match *map {
            StoredMap::None | StoredMap::Ordered | StoredMap::Waits(_) | StoredMap::Looking => {
                return None;
            }
            StoredMap::InForce { slot, .. } => (1, MapEvent::InForce { slot }),
            StoredMap::NotWhole { slot, ahead } => (2, MapEvent::NotWhole { slot, ahead }),
            StoredMap::OtherPlaten { slot, parity } => {
                let parity_m = [parity.parity_m, parity.wanted_m];
                (3, MapEvent::OtherPlaten { slot, parity_m })
            }
            StoredMap::OtherCalibration { slot } => (4, MapEvent::OtherCalibration { slot }),
            StoredMap::Refused { slot, refusal } => (5, MapEvent::Refused { slot, refusal }),
        };
        let now = (kind, event.slot());
        (core::mem::replace(&mut self.map, now) != now).then_some(Event::Map(event))
    }

    fn watch(&mut self, verdict: &Verdict) -> Option<Event> {
        let Verdict {
            standing, change, ..
        } = *verdict;
        let told_s = change.map(|change| change.told_s);
        stands_otherwise(&mut self.standing, standing, told_s)
            .then_some(Event::Watch { standing, change })
    }

    #[inline(never)]
    fn watch_rests(&mut self, kind: RestKind, verdicts: &[RestVerdict; 2]) -> Option<Event> {
        let RestVerdict {
            standing, change, ..
        } = verdicts[kind as usize];
        let told_s = change.map(|change| change.told_s);
        let last = &mut self.rests[kind as usize];
        stands_otherwise(last, standing, told_s).then_some(match kind {
            RestKind::Beacon => Event::BeaconWatch { standing, change },
            RestKind::Parity => Event::ParityWatch { standing, change },
        })
    }

    /// The first candidate beside a calibration in force: what becomes of it shows by the next that is.
    fn proposal(&mut self, proposed: Option<Proposal>) -> Option<Event> {
        let proposal = proposed.filter(|_| !self.is_proposal_told)?;
        self.is_proposal_told = true;
        Some(Event::Proposed(proposal))
    }

    fn status(&mut self) -> Option<Event> {
        let new = self.status_seen & !self.status_told;
        self.status_told |= new;
        (new != 0).then_some(Event::Status(new))
    }
}

/// Whether what is watched stands so much otherwise than `last` that it is written: told, stale, or well again. What an earlier start has
/// told has no time in this one.
fn stands_otherwise(last: &mut Standing, standing: Standing, told_s: Option<u32>) -> bool {
    let is_told = matches!(standing, Standing::Drifting | Standing::Stale);
    let was_told = matches!(*last, Standing::Drifting | Standing::Stale);
    if !(is_told || was_told && standing == Standing::Healthy) {
        return false;
    }
    let before = core::mem::replace(last, standing);
    let is_earlier = !was_told && told_s == Some(0);
    before != standing && !is_earlier
}

/// Whether a stored calibration has come back for a newer one.
fn is_older(now: InForce, before: InForce) -> bool {
    match (now, before) {
        (InForce::Stored(now), InForce::Stored(before)) => now.sequence < before.sequence,
        _ => false,
    }
}

/// As much of a text as there is room for.
fn beginning(text: &str) -> String<MESSAGE_BYTES> {
    let mut beginning = String::new();
    for character in text.chars() {
        if beginning.push(character).is_err() {
            break;
        }
    }
    beginning
}
