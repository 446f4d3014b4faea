//! What is done with every frame at once, in an interrupt below sampling: the stream to the host, and what the frames' status bits have
//! been.
//!
//! So no frame waits for the background, which may be at a page's erase for 22 ms. The background gets the frames that it
//! wants: all while a calibration averages a pose, otherwise the newest. On a board without such an interrupt the main loop calls it.

use super::frames::{FrameIntake, HANDED_FRAMES, QUEUE_FRAMES, Taken};
use super::sampler::Mailbox;
use crate::link::telemetry::{self, Packer, StreamOrder};
use heapless::spsc::{Consumer, Producer, Queue};

/// Frames that wait where sampling and the stream want more time than there is: all but two of the places that are the intake's own, so
/// that none is lost. Fewer wait while a block of the stream is sent beside sampling interrupts at their limit (the chip's check `stream`).
const BEHIND_FRAMES: usize = QUEUE_FRAMES - HANDED_FRAMES - 2;
/// Frames that the stream then leaves out, so that the background gets time for a turn: 5 ms at 20 kHz.
const PAUSE_FRAMES: u32 = 100;

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
    /// Frames that the stream leaves out from here.
    pause_frames: u32,
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
            pause_frames: 0,
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

    /// Takes a frame; false: there is none. The stream must not take all the time that sampling leaves: where it could, frames are left
    /// out of it, and counted as not sent.
    fn take(&mut self) -> bool {
        if self.frames.waiting() >= BEHIND_FRAMES {
            self.pause_frames = PAUSE_FRAMES;
        }
        let all_wanted = self.mailbox.wants_all();
        let (mailbox, packer, buffer) = (self.mailbox, &mut self.packer, &mut self.buffer);
        let channel = &mut self.channel;
        let is_sent = self.pause_frames == 0;
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
            self.pause_frames = self.pause_frames.saturating_sub(1);
        }
        taken.is_some()
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use crate::app::frames::{FrameQueue, FrameSender};
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
    fn a_stream_that_falls_behind_pauses() {
        let (mut host, mailbox) = (host(true), Mailbox::new());
        let mut places = [const { StepState::ZERO }; QUEUE_FRAMES + 1];
        let (mut queue, mut orders) = (FrameQueue::new(), OrderQueue::new());
        let (mut sender, frames, _receiver) = queue.split(&mut places);
        let (mut order, ordered) = orders.split();
        let mut intake = Intake::new(frames, ordered, &mailbox, &mut host);
        let samples = 2 * PAUSE_FRAMES;
        let stream = StreamOrder {
            channels: Channels::STATUS.bits(),
            decimation: 1,
            samples,
        };
        order.enqueue(stream).unwrap();
        // One that comes in time, then so many at once, then the rest, each in time.
        send(&mut sender);
        intake.run();
        for _ in 0..BEHIND_FRAMES {
            send(&mut sender);
        }
        intake.run();
        for _ in 1 + BEHIND_FRAMES as u32..samples + PAUSE_FRAMES {
            send(&mut sender);
            intake.run();
        }
        assert_eq!((mailbox.unsent(), mailbox.dropped()), (PAUSE_FRAMES, 0));
        let sent: Vec<u32> = (0..1).chain(1 + PAUSE_FRAMES..samples).collect();
        assert_eq!(host.numbers[..sent.len()], sent);
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
