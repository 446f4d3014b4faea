//! What one sample leaves to the next.

use super::SLIPS;
use crate::frame::{Frame, RawFrame, SEGMENTS};

/// What one sample leaves to the next: the last frame, and what no frame shows.
#[derive(Clone, Debug, PartialEq)]
pub struct StepState {
    pub(super) frame: Frame,
    /// Samples since the last good one, or [`NEVER`].
    pub(super) missed: u16,
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
    /// In which of the last four windows a channel stood still, as bits.
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

/// Before the first sample, and when the count is to begin anew.
pub(super) const NEVER: u16 = u16::MAX;

impl Default for StepState {
    fn default() -> Self {
        let frame = Frame {
            sequence: u32::MAX,
            ..Frame::default()
        };
        Self {
            frame,
            missed: NEVER,
            watch: Watch::NEW,
        }
    }
}

impl StepState {
    /// Before the first sample. That sets the tooth counts: 0 for segments 1 and 2, their neighbours' within half a tooth.
    pub fn new() -> Self {
        Self::default()
    }

    /// The last frame.
    pub fn frame(&self) -> &Frame {
        &self.frame
    }

    /// Where the next sample's counts go before [`isr_step`](super::isr_step): the driver's place to write to.
    pub fn raw_mut(&mut self) -> &mut RawFrame {
        &mut self.frame.raw
    }

    /// Takes back the latched slip bits, once the pose is known again.
    pub fn clear_slips(&mut self) {
        self.frame.status.remove(SLIPS);
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
