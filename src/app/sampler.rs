//! The interrupt's half: one conversion in, one frame computed and queued. Nothing here waits, logs or allocates.
//!
//! The board reads the converter (its pins and its bus are the board's) and hands the result to [`Sampler::isr_sample`], or fills the
//! raw frame itself and calls [`Sampler::isr_compute`]; everything that follows is the same code on every board. Owned by the interrupt alone; what the background may ask of
//! it passes through [`Mailbox`], one atomic word each.

use crate::app::frames::FrameSender;
use crate::drivers::converter::{ConverterError, Counts, store};
use crate::frame::{Frame, RawFrame, Status};
use crate::step::{isr_step, isr_step_mapped};
use crate::swap::SwapReceiver;
use core::sync::atomic::{AtomicBool, AtomicU32, Ordering::Relaxed};

/// Largest temperature difference that is passed on, kelvin: the industrial range from end to end.
pub const TEMPERATURE_LIMIT_K: f32 = 125.0;

/// Single words that pass between the two halves without a lock.
#[derive(Debug, Default)]
pub struct Mailbox {
    /// Board temperature minus the calibration's reference, kelvin, as bits; written by the background.
    temperature_delta_bits: AtomicU32,
    /// Samples taken since start; written by the interrupt.
    samples: AtomicU32,
    /// Frames that found the queue full; written by the interrupt.
    dropped: AtomicU32,
    /// Frames that the background wanted and had no place for; written by the intake.
    not_handed: AtomicU32,
    /// Whether the background wants every frame; written by it.
    wants_all: AtomicBool,
    /// Status bits of all frames since the background took them; written by the intake.
    status_seen: AtomicU32,
    /// Samples that the running stream should have sent and did not; written by the intake.
    unsent: AtomicU32,
    /// Sampling instants missed; written by the interrupt.
    missed: AtomicU32,
    /// The longest that the sampling interrupt took; written by it.
    isr_cycles_worst: AtomicU32,
}

impl Mailbox {
    /// Nothing asked, nothing counted.
    pub const fn new() -> Self {
        Self {
            temperature_delta_bits: AtomicU32::new(0),
            samples: AtomicU32::new(0),
            dropped: AtomicU32::new(0),
            not_handed: AtomicU32::new(0),
            wants_all: AtomicBool::new(false),
            status_seen: AtomicU32::new(0),
            unsent: AtomicU32::new(0),
            missed: AtomicU32::new(0),
            isr_cycles_worst: AtomicU32::new(0),
        }
    }

    /// Tells the interrupt the board's temperature, as the difference to the calibration's, kelvin: at most
    /// [`TEMPERATURE_LIMIT_K`] either way, so that no thermometer can push a pose far; not a number counts as no difference.
    pub fn set_temperature_delta_k(&self, delta_k: f32) {
        let known = if delta_k.is_nan() { 0.0 } else { delta_k };
        #[allow(clippy::manual_clamp)]
        // whose panic brings 14 KB of float formatting into the image
        let bounded = known.max(-TEMPERATURE_LIMIT_K).min(TEMPERATURE_LIMIT_K);
        self.temperature_delta_bits
            .store(bounded.to_bits(), Relaxed);
    }

    /// Samples taken since start, modulo 2^32.
    pub fn samples(&self) -> u32 {
        self.samples.load(Relaxed)
    }

    /// Frames that were not taken up, modulo 2^32: those that found the queue full, and those that a calibration wanted and had no
    /// place for.
    pub fn dropped(&self) -> u32 {
        let not_handed = self.not_handed.load(Relaxed);
        self.dropped.load(Relaxed).wrapping_add(not_handed)
    }

    /// Counts a frame that the background wanted and had no place for. To be called by the intake alone.
    pub fn note_not_handed(&self) {
        count(&self.not_handed, 1);
    }

    /// Whether the background wants every frame.
    pub fn wants_all(&self) -> bool {
        self.wants_all.load(Relaxed)
    }

    /// Tells the intake whether the background wants every frame, or is content with the newest.
    pub fn set_wants_all(&self, wants_all: bool) {
        self.wants_all.store(wants_all, Relaxed);
    }

    /// Keeps a frame's status bits.
    pub fn note_status(&self, status: Status) {
        if !self.status_seen().contains(status) {
            self.status_seen.fetch_or(status.bits(), Relaxed);
        }
    }

    /// Status bits of all frames since they were last taken.
    pub fn take_status(&self) -> Status {
        Status::from_bits_retain(self.status_seen.swap(0, Relaxed))
    }

    fn status_seen(&self) -> Status {
        Status::from_bits_retain(self.status_seen.load(Relaxed))
    }

    /// Samples that the running stream, or the last one, should have sent and did not: the channel had no room for them.
    pub fn unsent(&self) -> u32 {
        self.unsent.load(Relaxed)
    }

    /// Tells them. To be called by the intake alone.
    pub fn set_unsent(&self, samples: u32) {
        self.unsent.store(samples, Relaxed);
    }

    /// Sampling instants missed, modulo 2^32.
    pub fn missed(&self) -> u32 {
        self.missed.load(Relaxed)
    }

    /// The longest that the sampling interrupt took since start, cycles of the processor, from its first instruction to its last; zero
    /// on a board that does not count them.
    pub fn isr_cycles_worst(&self) -> u32 {
        self.isr_cycles_worst.load(Relaxed)
    }

    /// Notes how long the sampling interrupt took, cycles. To be called by that interrupt alone.
    #[inline(always)]
    pub fn note_isr_cycles(&self, cycles: u32) {
        if cycles > self.isr_cycles_worst.load(Relaxed) {
            self.isr_cycles_worst.store(cycles, Relaxed);
        }
    }
}

/// All that the interrupt owns besides the converter.
pub struct Sampler<'q, 'c> {
    config: SwapReceiver<'q, 'c>,
    frames: FrameSender<'q, 'c>,
    mailbox: &'q Mailbox,
}

impl<'q, 'c> Sampler<'q, 'c> {
    /// Before the first sample.
    pub fn new(
        config: SwapReceiver<'q, 'c>,
        frames: FrameSender<'q, 'c>,
        mailbox: &'q Mailbox,
    ) -> Self {
        Self {
            config,
            frames,
            mailbox,
        }
    }

    /// The words that pass between the two halves.
    #[inline(always)]
    pub fn mailbox(&self) -> &'q Mailbox {
        self.mailbox
    }

    /// One instant: `reading` as the driver gave it, `missed` sampling instants since the last call ([`missed_between`]): an overrun,
    /// flagged in this frame, counted in its number and in the time that the tooth counters predict over. A full queue drops the
    /// frame and counts it. Never panics.
    #[inline]
    pub fn isr_sample(&mut self, reading: Result<Counts, ConverterError>, missed: u32) -> Frame {
        store(reading, self.isr_raw());
        let mut seen = Frame::ZERO;
        self.isr_compute(missed, |frame| seen = *frame);
        seen
    }

    /// Where the next sample's counts go, and its fault bits, all of them, before [`Sampler::isr_compute`].
    #[inline(always)]
    pub fn isr_raw(&mut self) -> &mut RawFrame {
        self.frames.state.raw_mut()
    }

    /// [`Sampler::isr_sample`] with the reading in [`Sampler::isr_raw`] already; `watch` sees the frame.
    #[inline(always)]
    pub fn isr_compute(&mut self, missed: u32, watch: impl FnOnce(&Frame)) {
        let state = &mut *self.frames.state;
        if missed > 0 {
            state.skip(missed);
            state.raw_mut().fault.insert(Status::OVERRUN);
        }
        let raw = state.raw_mut();
        raw.temperature_delta_k = f32::from_bits(self.mailbox.temperature_delta_bits.load(Relaxed));
        watch(match self.config.current_with_map() {
            (config, None) => isr_step(config, state),
            (config, Some(map)) => isr_step_mapped(config, state, map),
        });
        count(&self.mailbox.samples, 1);
        if missed > 0 {
            count(&self.mailbox.missed, missed);
        }
        if !self.frames.send() {
            count(&self.mailbox.dropped, 1);
        }
    }
}

/// Sampling instants missed between the last one served and the newest, by the numbers of both modulo 2^32; none if the
/// newest has been served: an edge that came while the interrupt was late.
#[inline(always)]
pub const fn missed_between(served: u32, newest: u32) -> Option<u32> {
    newest.wrapping_sub(served).checked_sub(1)
}

/// Adds to a counter that one interrupt alone writes: load and store, no exclusive access needed.
#[inline(always)]
fn count(counter: &AtomicU32, by: u32) {
    counter.store(counter.load(Relaxed).wrapping_add(by), Relaxed);
}

#[cfg(test)]
mod tests {
    use super::{Mailbox, missed_between};
    use crate::frame::Status;

    #[test]
    fn the_longest_interrupt_is_kept() {
        let mailbox = Mailbox::new();
        assert_eq!(mailbox.isr_cycles_worst(), 0);
        for cycles in [900, 1200, 1000] {
            mailbox.note_isr_cycles(cycles);
        }
        assert_eq!(mailbox.isr_cycles_worst(), 1200);
    }

    #[test]
    fn status_bits_are_kept_until_they_are_taken() {
        let mailbox = Mailbox::new();
        mailbox.note_status(Status::PARITY);
        mailbox.note_status(Status::FROZEN);
        mailbox.note_status(Status::PARITY);
        assert_eq!(mailbox.take_status(), Status::PARITY | Status::FROZEN);
        assert_eq!(mailbox.take_status(), Status::empty());
    }

    #[test]
    fn instants_between_are_counted_over_the_counters_end() {
        assert_eq!(missed_between(7, 8), Some(0));
        assert_eq!(missed_between(7, 11), Some(3));
        assert_eq!(missed_between(u32::MAX, 0), Some(0));
        assert_eq!(missed_between(u32::MAX - 1, 1), Some(2));
        assert_eq!(missed_between(7, 7), None, "served already");
    }
}
