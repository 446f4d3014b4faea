//! What one sample leaves to the next.

use crate::frame::{Frame, RawFrame, SEGMENTS, Status};

/// What one sample leaves to the next: the last frame, and what no frame shows.
#[derive(Clone, Debug, PartialEq)]
pub struct StepState {
    pub(super) frame: Frame,
    /// Instants since the last good sample, or [`NEVER`].
    pub(super) missed: u32,
    /// Status bits that a frame hands on to the next.
    pub(super) latched: u32,
    pub(super) watch: Watch,
}

/// The watch for frozen channels.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Watch {
    /// Which segment it is at, modulo 4.
    pub(super) segment: u32,
    /// Its counts at the last sample.
    pub(super) counts: u32,
    /// Which of their bits have changed since the window began.
    pub(super) changed: u32,
    /// In which of the last four windows a channel stood still, the newest in bit 0; and in which of them at a rail, from bit 4 on.
    pub(super) still: u32,
}

impl Watch {
    /// Before the first sample: its window is not judged.
    const NEW: Self = Self {
        segment: 0,
        counts: 0,
        changed: u32::MAX,
        still: 0,
    };
}

/// All slip bits.
pub(super) const SLIPS: Status = Status::SLIP_1
    .union(Status::SLIP_2)
    .union(Status::SLIP_3)
    .union(Status::SLIP_4);

/// What the watch for frozen channels sets and takes back.
pub(super) const WATCHED: Status = Status::FROZEN
    .union(Status::RAIL_1)
    .union(Status::RAIL_2)
    .union(Status::RAIL_3)
    .union(Status::RAIL_4);

/// Before the first sample, and when the count is to begin anew.
pub(super) const NEVER: u32 = u32::MAX;

/// Status bits that stay from frame to frame; [`Status::OVERRUN`] does too once a tooth may have gone by unseen.
const LATCHED: u32 = SLIPS.union(WATCHED).bits();

impl Default for StepState {
    fn default() -> Self {
        let mut state = Self::ZERO;
        state.begin();
        state
    }
}

impl StepState {
    /// All zeros: a place for a state, not one to begin with.
    pub const ZERO: Self = Self {
        frame: Frame::ZERO,
        missed: 0,
        latched: 0,
        watch: Watch {
            segment: 0,
            counts: 0,
            changed: 0,
            still: 0,
        },
    };

    /// Makes this the state before the first sample, as [`StepState::new`].
    pub fn begin(&mut self) {
        self.frame = Frame {
            sequence: u32::MAX,
            ..Frame::ZERO
        };
        self.missed = NEVER;
        self.latched = LATCHED;
        self.watch = Watch::NEW;
    }

    /// Before the first sample. That sets the tooth counts: 0 for segments 1 and 2, their neighbours' within half a tooth.
    pub fn new() -> Self {
        Self::default()
    }

    /// Hands on what the next sample needs of this one to the state that it will work in, wherever that lies. What of `next` is not
    /// written here every sample writes itself.
    #[inline(never)]
    pub fn hand_on(&self, next: &mut Self) {
        let (from, to) = (&self.frame, &mut next.frame);
        to.sequence = from.sequence;
        to.status = from.status;
        to.raw = from.raw;
        to.segments[0].unmodified = from.segments[0].unmodified;
        to.segments[1].unmodified = from.segments[1].unmodified;
        to.segments[2].unmodified = from.segments[2].unmodified;
        to.segments[3].unmodified = from.segments[3].unmodified;
        to.speed_m_s = from.speed_m_s;
        to.direction = from.direction;
        next.missed = self.missed;
        next.latched = self.latched;
        next.watch = self.watch;
    }

    /// The last frame.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Where the next sample's counts go before [`isr_step`](super::isr_step): the driver's place to write to.
    pub fn raw_mut(&mut self) -> &mut RawFrame {
        &mut self.frame.raw
    }

    /// Tells that so many sampling instants have gone by without a sample, before the sample that comes next. The next frame's number
    /// counts them, and they are time that passed, as failed conversions are: for the predicted phase, and for
    /// [`Limits::gap_samples`](crate::settings::Limits::gap_samples).
    #[inline(always)]
    pub fn skip(&mut self, instants: u32) {
        if instants != 0 {
            self.frame.sequence = self.frame.sequence.wrapping_add(instants);
            // Before the first sample `NEVER` stays; after it the sum comes to that in 59 hours at 20 kHz.
            self.missed = self.missed.saturating_add(instants);
        }
    }

    /// Takes back the latched slip bits, and the overrun that may have hidden one, once the pose is known again.
    pub fn clear_slips(&mut self) {
        self.frame.status.remove(SLIPS | Status::OVERRUN);
        self.latched = LATCHED;
    }

    /// Sets the tooth counts, e.g. to those of a known place, and clears the slip bits. Before the first sample, which sets
    /// them itself, nothing.
    pub fn set_teeth(&mut self, teeth: [i32; SEGMENTS]) {
        if self.missed == NEVER {
            return;
        }
        for (segment, teeth) in self.frame.segments.iter_mut().zip(teeth) {
            segment.unmodified.teeth = teeth;
        }
        self.clear_slips();
    }
}
