//! The queues of frames from the sampling interrupt up to the background, in which nobody copies any but the background.
//!
//! The states that a sample works in lie in places that the halves lend to each other. The sampling interrupt computes a sample in its
//! place, hands on what the next one needs to a free place, and sends the first down. The intake looks at the frame there, and gives the
//! place back or hands it on to the background, which gives it back through the intake. So each place has one owner at any time, and each
//! queue has one sender and one receiver.

use crate::calibration::AVERAGED_FRAMES;
use crate::frame::Frame;
use crate::queue;
use crate::step::StepState;
use heapless::spsc::{Consumer, Producer, Queue};

/// Frames between the sampling interrupt and the others, as many as the CCM RAM of the sensor board has room for.
pub const QUEUE_FRAMES: usize = 59;
/// As many of them may be the background's at a time: all that a pose's average takes, and a quarter more for frames that it cannot use.
/// So a pose loses none, whatever holds the background up. The others are the intake's: 0.9 ms at 20 kHz.
pub const HANDED_FRAMES: usize = AVERAGED_FRAMES + AVERAGED_FRAMES / 4;
const _: () = assert!(HANDED_FRAMES < QUEUE_FRAMES && QUEUE_FRAMES < RING);
/// Room of the queues that the sampling interrupt uses, one more than they hold: at a power of two it need not divide.
const RING: usize = 64;

/// Where they lie: these, and the one that the interrupt works in.
pub type FramePlaces = [StepState; QUEUE_FRAMES + 1];

/// References to the places on their way: down to the intake and the background, and back up. Lives as long as the ends: in a static on
/// the target.
#[derive(Default)]
pub struct FrameQueue<'f> {
    filled: Queue<&'f mut StepState, RING>,
    handed: Queue<&'f mut StepState, { HANDED_FRAMES + 1 }>,
    // The intake empties it before it hands a further one on.
    returned: Queue<&'f mut StepState, { HANDED_FRAMES + 1 }>,
    free: Queue<&'f mut StepState, RING>,
}

impl<'f> FrameQueue<'f> {
    /// Empty.
    pub const fn new() -> Self {
        Self {
            filled: Queue::new(),
            handed: Queue::new(),
            returned: Queue::new(),
            free: Queue::new(),
        }
    }

    /// The sampling interrupt's end, before the first sample, the intake's and the background's.
    pub fn split<'q>(
        &'q mut self,
        [state, places @ ..]: &'f mut FramePlaces,
    ) -> (
        FrameSender<'q, 'f>,
        FrameIntake<'q, 'f>,
        FrameReceiver<'q, 'f>,
    ) {
        state.begin();
        let (mut give_back, free) = self.free.split();
        for place in places {
            // As many as there is room for.
            let _ = give_back.enqueue(place);
        }
        let (send, filled) = self.filled.split();
        let (hand_on, handed) = self.handed.split();
        let (give_up, returned) = self.returned.split();
        (
            FrameSender { state, send, free },
            FrameIntake {
                filled,
                hand_on,
                returned,
                give_back,
            },
            FrameReceiver {
                handed,
                give_back: give_up,
            },
        )
    }
}

/// The sampling interrupt's end, and the state that it works in.
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
        queue::enqueue_in::<RING, _>(&mut self.send, done).is_ok()
    }
}

/// What became of a frame that the intake took.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Taken {
    /// The background has it, or does not want it.
    Served,
    /// The background wants every frame, and had no place for this one.
    Lost,
}

/// The intake's end.
pub struct FrameIntake<'q, 'f> {
    filled: Consumer<'q, &'f mut StepState>,
    hand_on: Producer<'q, &'f mut StepState>,
    returned: Consumer<'q, &'f mut StepState>,
    give_back: Producer<'q, &'f mut StepState>,
}

impl FrameIntake<'_, '_> {
    /// Frames that wait for the intake.
    pub fn waiting(&self) -> usize {
        self.filled.len()
    }

    /// Takes the oldest frame, if there is one: `look` sees it, then the background gets it if it wants every frame (`all_wanted`) or has
    /// none to look at.
    pub fn take(&mut self, all_wanted: bool, look: impl FnOnce(&Frame)) -> Option<Taken> {
        while let Some(place) = queue::dequeue(&mut self.returned) {
            // There are no more places than it holds.
            let _ = queue::enqueue(&mut self.give_back, place);
        }
        let place = queue::dequeue(&mut self.filled)?;
        look(place.frame());
        let is_for_background = all_wanted || self.hand_on.is_empty();
        let left = match is_for_background {
            true => queue::enqueue(&mut self.hand_on, place).err(),
            false => Some(place),
        };
        let Some(place) = left else {
            return Some(Taken::Served);
        };
        // As above.
        let _ = queue::enqueue(&mut self.give_back, place);
        Some(match all_wanted {
            true => Taken::Lost,
            false => Taken::Served,
        })
    }
}

/// The background's end.
pub struct FrameReceiver<'q, 'f> {
    handed: Consumer<'q, &'f mut StepState>,
    give_back: Producer<'q, &'f mut StepState>,
}

impl FrameReceiver<'_, '_> {
    /// Copies the oldest frame out; false: there is none.
    pub fn receive(&mut self, to: &mut Frame) -> bool {
        let Some(place) = self.handed.dequeue() else {
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
    extern crate std;
    use super::*;
    use std::{vec, vec::Vec};

    /// Sends so many frames; how many there was room for.
    fn send(sender: &mut FrameSender<'_, '_>, count: usize) -> usize {
        let sent = |_: &usize| {
            sender.state.skip(1);
            sender.send()
        };
        (0..count).take_while(sent).count()
    }

    fn received(receiver: &mut FrameReceiver<'_, '_>) -> Vec<u32> {
        let mut frame = Frame::default();
        let next = || receiver.receive(&mut frame).then_some(frame.sequence);
        core::iter::from_fn(next).collect()
    }

    /// Takes all frames; the numbers of those that were looked at, and how many the background had no place for.
    fn taken(intake: &mut FrameIntake<'_, '_>, all_wanted: bool) -> (Vec<u32>, usize) {
        let (mut seen, mut lost) = (vec![], 0);
        while let Some(taken) = intake.take(all_wanted, |frame| seen.push(frame.sequence)) {
            lost += usize::from(taken == Taken::Lost);
        }
        (seen, lost)
    }

    #[test]
    fn frames_come_in_order_and_a_full_queue_loses_the_new_one() {
        let mut places = [const { StepState::ZERO }; QUEUE_FRAMES + 1];
        let mut queue = FrameQueue::new();
        let (mut sender, mut intake, _) = queue.split(&mut places);
        assert_eq!(*sender.state, StepState::new());
        let mut first = 0;
        // One place of them stays with the background, which takes none.
        for room in [QUEUE_FRAMES, QUEUE_FRAMES - 1, QUEUE_FRAMES - 1] {
            assert_eq!(send(&mut sender, QUEUE_FRAMES + 1), room);
            // The state before the first sample has the number before zero.
            let numbers: Vec<u32> = (first..first + room as u32).collect();
            assert_eq!(taken(&mut intake, false), (numbers, 0));
            // The frame that found no room has its number too.
            first += room as u32 + 1;
        }
    }

    #[test]
    fn a_background_that_stands_still_gets_a_poses_frames_and_costs_the_intake_none() {
        let mut places = [const { StepState::ZERO }; QUEUE_FRAMES + 1];
        let mut queue = FrameQueue::new();
        let (mut sender, mut intake, mut receiver) = queue.split(&mut places);
        let (mut seen, mut lost) = (0, 0);
        for _ in 0..100 {
            assert_eq!(send(&mut sender, 10), 10, "a place is free");
            let (numbers, no_place) = taken(&mut intake, true);
            (seen, lost) = (seen + numbers.len(), lost + no_place);
        }
        assert_eq!((seen, lost), (1000, 1000 - HANDED_FRAMES));
        let expected: Vec<u32> = (0..HANDED_FRAMES as u32).collect();
        assert_eq!(received(&mut receiver), expected);
        assert_eq!(send(&mut sender, 1), 1);
        assert_eq!(taken(&mut intake, true), (vec![1000], 0));
        assert_eq!(received(&mut receiver), [1000]);
    }

    #[test]
    fn a_background_that_wants_none_in_particular_gets_one_at_a_time() {
        let mut places = [const { StepState::ZERO }; QUEUE_FRAMES + 1];
        let mut queue = FrameQueue::new();
        let (mut sender, mut intake, mut receiver) = queue.split(&mut places);
        assert_eq!(send(&mut sender, 10), 10);
        assert_eq!(taken(&mut intake, false).1, 0, "none is lost");
        assert_eq!(received(&mut receiver), [0]);
        assert_eq!(send(&mut sender, 1), 1);
        assert_eq!(taken(&mut intake, false).1, 0);
        assert_eq!(received(&mut receiver), [10]);
    }
}
