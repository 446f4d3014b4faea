//! What is done with every frame at once, in an interrupt below sampling: the stream to the host, and what the frames' status bits have
//! been.
//!
//! So no frame waits for the background, which may be at a page's erase for 22 ms. The background gets the frames that it
//! wants: all while a calibration averages a pose, otherwise the newest. On a board without such an interrupt the main loop calls it.

use super::frames::{FrameIntake, Taken};
use super::sampler::Mailbox;
use crate::link::telemetry::{self, Packer, StreamOrder};
use heapless::spsc::{Consumer, Producer, Queue};

/// Frames that go into the stream while the background makes no turn: 80 ms of them at 20 kHz. Its longest turn, a commit with a page's
/// erase of 22 ms or a solution of 15 ms of its own time, is over within half of that where it gets half of what sampling leaves.
const PATIENCE_FRAMES: u32 = 1600;
/// Those that a turn adds to what is left, so that a background that has got no time gets it after 5 ms, turn by turn.
const FRAMES_A_TURN: u32 = 100;

/// Orders of a host on their way to the intake.
pub type OrderQueue = Queue<StreamOrder, 4>;
/// The end that gives orders.
pub type OrderSender<'q> = Producer<'q, StreamOrder>;

/// The channel to the host that the stream goes through. It never waits.
pub trait Telemetry {
    /// Gives a whole frame of the link; false: there was no room and nothing was taken.
    fn write(&mut self, bytes: &[u8]) -> bool;
}

/// The intake. Owned by its interrupt.
pub struct Intake<'q, 'f, T> {
    frames: FrameIntake<'q, 'f>,
    orders: Consumer<'q, StreamOrder>,
    mailbox: &'q Mailbox,
    packer: Packer,
    buffer: [u8; telemetry::FRAME_BYTES],
    channel: T,
    /// Turns of the background when the intake last looked, and frames that may go into the stream before a further one.
    turns: u32,
    credit_frames: u32,
}

impl<'q, 'f, T: Telemetry> Intake<'q, 'f, T> {
    /// No stream yet.
    pub fn new(
        frames: FrameIntake<'q, 'f>,
        orders: Consumer<'q, StreamOrder>,
        mailbox: &'q Mailbox,
        channel: T,
    ) -> Self {
        Self {
            frames,
            orders,
            mailbox,
            packer: Packer::default(),
            buffer: [0; telemetry::FRAME_BYTES],
            channel,
            turns: 0,
            credit_frames: PATIENCE_FRAMES,
        }
    }

    /// Takes all frames that wait.
    pub fn run(&mut self) {
        while let Some(order) = self.orders.dequeue() {
            self.packer.start(order);
        }
        self.give_credit();
        while self.take() {}
        self.mailbox.set_unsent(self.packer.lost());
    }

    /// The stream must not take all the time that sampling leaves: where it could, frames are left out of it, and counted as not sent.
    fn give_credit(&mut self) {
        let turns = self.mailbox.turns();
        let made = turns.wrapping_sub(self.turns).min(PATIENCE_FRAMES);
        self.turns = turns;
        self.credit_frames = (self.credit_frames + made * FRAMES_A_TURN).min(PATIENCE_FRAMES);
    }

    /// Takes a frame; false: there is none.
    fn take(&mut self) -> bool {
        let all_wanted = self.mailbox.wants_all();
        let (mailbox, packer, buffer) = (self.mailbox, &mut self.packer, &mut self.buffer);
        let channel = &mut self.channel;
        let is_sent = self.credit_frames > 0;
        let taken = self.frames.take(all_wanted, |frame| {
            mailbox.note_status(frame.status);
            if is_sent {
                packer.push(frame, buffer, |bytes| channel.write(bytes));
            }
        });
        if taken == Some(Taken::Lost) {
            self.mailbox.note_not_handed();
        }
        if taken.is_some() {
            self.credit_frames = self.credit_frames.saturating_sub(1);
        }
        taken.is_some()
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::app::frames::{FrameQueue, FrameSender, HANDED_FRAMES, QUEUE_FRAMES};
    use crate::link::framing::Decoder;
    use crate::link::telemetry::{Block, Channels};
    use crate::step::StepState;
    use std::vec::Vec;

    /// Takes a frame of the link, or has no room for any.
    struct Host {
        has_room: bool,
        decoder: Decoder<{ telemetry::FRAME_BYTES }>,
        numbers: Vec<u32>,
    }

    impl Telemetry for &mut Host {
        fn write(&mut self, bytes: &[u8]) -> bool {
            for byte in bytes.iter().filter(|_| self.has_room) {
                if let Some(Ok(block)) = self.decoder.feed::<Block>(*byte) {
                    let samples = block.samples();
                    self.numbers.extend(samples.map(|sample| sample.sequence));
                }
            }
            self.has_room
        }
    }

    const FRAMES: u32 = 1000;

    fn send(sender: &mut FrameSender<'_, '_>) {
        sender.state.skip(1);
        assert!(sender.send(), "a place is free");
    }

    /// The stream of so many frames beside a background that stands still, or makes a turn before the last of them.
    fn streamed(host: &mut Host, mailbox: &Mailbox, count: u32, turns_at_last: u32) {
        let mut places = [const { StepState::ZERO }; QUEUE_FRAMES + 1];
        let (mut queue, mut orders) = (FrameQueue::new(), OrderQueue::new());
        let (mut sender, frames, _receiver) = queue.split(&mut places);
        let (mut order, ordered) = orders.split();
        let mut intake = Intake::new(frames, ordered, mailbox, host);
        let channels = Channels::STATUS.bits();
        let stream = StreamOrder {
            channels,
            decimation: 1,
            samples: count,
        };
        order.enqueue(stream).unwrap();
        for k in 0..count {
            if k + 1 == count {
                (0..turns_at_last).for_each(|_| mailbox.note_turn());
            }
            send(&mut sender);
            intake.run();
        }
    }

    fn host(has_room: bool) -> Host {
        Host {
            has_room,
            decoder: Decoder::new(),
            numbers: Vec::new(),
        }
    }

    #[test]
    fn a_background_that_stands_still_costs_the_stream_nothing() {
        let (mut host, mailbox) = (host(true), Mailbox::new());
        streamed(&mut host, &mailbox, FRAMES, 0);
        assert_eq!(host.numbers, (0..FRAMES).collect::<Vec<_>>());
        assert_eq!((mailbox.dropped(), mailbox.unsent()), (0, 0));
    }

    #[test]
    fn a_background_that_gets_no_time_is_not_held_up_by_the_stream() {
        let (mut host, mailbox) = (host(true), Mailbox::new());
        streamed(&mut host, &mailbox, 2 * PATIENCE_FRAMES, 1);
        let sent = PATIENCE_FRAMES + 1;
        let left_out = 2 * PATIENCE_FRAMES - sent;
        assert_eq!(mailbox.unsent(), left_out);
        let last = host.numbers.last().copied();
        assert!(last <= Some(2 * PATIENCE_FRAMES - 1), "{last:?}");
    }

    #[test]
    fn what_a_calibration_wanted_and_what_the_host_has_no_room_for_are_counted_apart() {
        let (mut host, mailbox) = (host(false), Mailbox::new());
        mailbox.set_wants_all(true);
        streamed(&mut host, &mailbox, FRAMES, 0);
        assert_eq!(mailbox.dropped(), FRAMES - HANDED_FRAMES as u32);
        assert_eq!(mailbox.unsent(), FRAMES);
    }
}
