//! What is done with every frame at once, in an interrupt below sampling: the stream to the host, and what the frames' status bits have
//! been.
//!
//! So no frame waits for the background, which may be at a page's erase for 22 ms. The background gets the frames that it
//! wants: all while a calibration averages a pose, otherwise the newest. On a board without such an interrupt the main loop calls it.

use super::frames::{FrameIntake, Taken};
use super::sampler::Mailbox;
use crate::link::telemetry::{self, Packer, StreamOrder};
use heapless::spsc::{Consumer, Producer, Queue};

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
        }
    }

    /// Takes all frames that wait.
    pub fn run(&mut self) {
        while let Some(order) = self.orders.dequeue() {
            self.packer.start(order);
        }
        while self.take() {}
        self.mailbox.set_unsent(self.packer.lost());
    }

    /// Takes a frame; false: there is none.
    fn take(&mut self) -> bool {
        let all_wanted = self.mailbox.wants_all();
        let (mailbox, packer, buffer) = (self.mailbox, &mut self.packer, &mut self.buffer);
        let channel = &mut self.channel;
        let taken = self.frames.take(all_wanted, |frame| {
            mailbox.note_status(frame.status);
            packer.push(frame, buffer, |bytes| channel.write(bytes));
        });
        if taken == Some(Taken::Lost) {
            self.mailbox.note_not_handed();
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

    /// The stream of so many frames beside a background that stands still.
    fn streamed(host: &mut Host, mailbox: &Mailbox) {
        let mut places = [const { StepState::ZERO }; QUEUE_FRAMES + 1];
        let (mut queue, mut orders) = (FrameQueue::new(), OrderQueue::new());
        let (mut sender, frames, _receiver) = queue.split(&mut places);
        let (mut order, ordered) = orders.split();
        let mut intake = Intake::new(frames, ordered, mailbox, host);
        let channels = Channels::STATUS.bits();
        let stream = StreamOrder {
            channels,
            decimation: 1,
            samples: FRAMES,
        };
        order.enqueue(stream).unwrap();
        for _ in 0..FRAMES {
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
        streamed(&mut host, &mailbox);
        assert_eq!(host.numbers, (0..FRAMES).collect::<Vec<_>>());
        assert_eq!((mailbox.dropped(), mailbox.unsent()), (0, 0));
    }

    #[test]
    fn what_a_calibration_wanted_and_what_the_host_has_no_room_for_are_counted_apart() {
        let (mut host, mailbox) = (host(false), Mailbox::new());
        mailbox.set_wants_all(true);
        streamed(&mut host, &mailbox);
        assert_eq!(mailbox.dropped(), FRAMES - HANDED_FRAMES as u32);
        assert_eq!(mailbox.unsent(), FRAMES);
    }
}
