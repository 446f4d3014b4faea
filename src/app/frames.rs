//! The queue of frames from the interrupt to the background, in which the interrupt copies none.
//!
//! The states that a sample works in lie in places that both halves lend to each other. The interrupt computes a sample in its place, hands
//! on what the next one needs to a free place, and sends the first down; the background reads the frame there and sends the place back up.
//! So each place has one owner at any time.

use crate::frame::Frame;
use crate::queue;
use crate::step::StepState;
use heapless::spsc::{Consumer, Producer, Queue};

/// Frames between the interrupt and the background: 3.1 ms at 20 kHz.
pub const QUEUE_FRAMES: usize = 63;

/// Where they lie: these, and the one that the interrupt works in.
pub type FramePlaces = [StepState; QUEUE_FRAMES + 1];

/// References to the places: filled ones go down, free ones up. Lives as long as both ends: in a static on the target.
#[derive(Default)]
pub struct FrameQueue<'f> {
    filled: Queue<&'f mut StepState, { QUEUE_FRAMES + 1 }>,
    free: Queue<&'f mut StepState, { QUEUE_FRAMES + 1 }>,
}

impl<'f> FrameQueue<'f> {
    /// Empty.
    pub const fn new() -> Self {
        Self {
            filled: Queue::new(),
            free: Queue::new(),
        }
    }

    /// The interrupt's end, before the first sample, and the background's.
    pub fn split<'q>(
        &'q mut self,
        [state, places @ ..]: &'f mut FramePlaces,
    ) -> (FrameSender<'q, 'f>, FrameReceiver<'q, 'f>) {
        state.begin();
        let (mut give_back, free) = self.free.split();
        for place in places {
            // As many as there is room for.
            let _ = give_back.enqueue(place);
        }
        let (send, filled) = self.filled.split();
        (
            FrameSender { state, send, free },
            FrameReceiver { filled, give_back },
        )
    }
}

/// The interrupt's end, and the state that it works in.
pub struct FrameSender<'q, 'f> {
    /// The state that the next sample works in.
    pub state: &'f mut StepState,
    send: Producer<'q, &'f mut StepState>,
    free: Consumer<'q, &'f mut StepState>,
}

impl FrameSender<'_, '_> {
    /// Sends the state's frame; false: there was no room, and the next sample will overwrite it.
    #[inline(always)]
    pub fn send(&mut self) -> bool {
        let Some(next) = queue::dequeue(&mut self.free) else {
            return false;
        };
        self.state.hand_on(next);
        let done = core::mem::replace(&mut self.state, next);
        // There are no more places than it holds.
        queue::enqueue(&mut self.send, done).is_ok()
    }
}

/// The background's end.
pub struct FrameReceiver<'q, 'f> {
    filled: Consumer<'q, &'f mut StepState>,
    give_back: Producer<'q, &'f mut StepState>,
}

impl FrameReceiver<'_, '_> {
    /// Copies the oldest frame out; false: there is none.
    pub fn receive(&mut self, to: &mut Frame) -> bool {
        let Some(place) = self.filled.dequeue() else {
            return false;
        };
        *to = *place.frame();
        // There are no more places than it holds.
        let _ = self.give_back.enqueue(place);
        true
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn frames_come_in_order_and_a_full_queue_loses_the_new_one() {
        let mut places = [const { StepState::ZERO }; QUEUE_FRAMES + 1];
        let mut queue = FrameQueue::new();
        let (mut sender, mut receiver) = queue.split(&mut places);
        assert_eq!(*sender.state, StepState::new());
        let (mut got, mut sequence) = (Frame::default(), 0u32);
        for _ in 0..3 {
            let first = sequence;
            for _ in 0..QUEUE_FRAMES {
                sender.state.skip(1);
                assert!(sender.send());
                sequence += 1;
            }
            assert!(!sender.send(), "no place is free");
            for number in first..sequence {
                assert!(receiver.receive(&mut got));
                // The state before the first sample has the number before zero.
                assert_eq!(got.sequence, number);
            }
            assert!(!receiver.receive(&mut got));
        }
    }
}
