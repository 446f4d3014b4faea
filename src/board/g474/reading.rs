//! Both converters' frames of a conversion, fetched by DMA at the same time: 6.8 us in which the processor is free.
//!
//! BUSY's edge interrupts the processor, which selects both chips and starts the two channels that send; the two that receive run in a
//! circle and are never set again. Some 80 cycles a sample would be saved if the edge started the channels by itself (DMAMUX1's
//! request generators and synchronisation). That is left out: the manual does not say whether an EXTI line reaches DMAMUX1 as the pin's level
//! or as the line's pending bit, and no board has shown it yet. Here nothing depends on it.
//!
//! One buffer is enough: the interrupt at a transfer's end and that of BUSY's edge have the same priority, and of two that wait the former
//! comes first (its number is lower). So no transfer begins while a frame is read.
#![allow(unsafe_code)] // memory that the DMA controller writes

use super::{pins, spi};
use crate::drivers::ad7606c::{FRAME_BYTES, FrameBytes};
use core::cell::UnsafeCell;
use core::sync::atomic::{
    AtomicU8,
    Ordering::{Relaxed, SeqCst},
    compiler_fence,
};
use stm32_metapac::bdma::Ch;
use stm32_metapac::bdma::regs::{Cr, Isr, Ndtr};
use stm32_metapac::bdma::vals::{Dir, Pl};
use stm32_metapac::spi::Spi;
use stm32_metapac::{DMA1, DMAMUX1, RCC};

/// Channels of DMA1 that receive from chip 0 and chip 1. By plain numbers: at others the accessor can panic.
#[inline(always)]
fn receiving() -> [Ch; 2] {
    [DMA1.ch(0), DMA1.ch(1)]
}

/// Channels that send to chip 0 and chip 1.
#[inline(always)]
fn sending() -> [Ch; 2] {
    [DMA1.ch(2), DMA1.ch(3)]
}

/// Request lines of these channels, in DMAMUX1's order: SPI1 and SPI2 receive, SPI1 and SPI2 send (RM0440, table 91; stm32-metapac).
const REQUESTS: [u8; 4] = [10, 12, 11, 13];
/// Looks at the other chip's channel at a transfer's end: a byte takes 64 cycles and a look eight or more. Both buses run at the same clock, and
/// the other chip's was started first.
const PATIENCE: u32 = 8;

/// Where the DMA controller puts a frame; at a multiple of four, so that it is read by words.
#[repr(C, align(4))]
struct Place(UnsafeCell<FrameBytes>);

// SAFETY: the processor reads it in the interrupt at a transfer's end alone, see the head of this file.
unsafe impl Sync for Place {}

static FRAMES: [Place; 2] = [const { Place(UnsafeCell::new([0; FRAME_BYTES])) }; 2];
/// What is sent while a conversion is read: zeros (AD7606C data sheet: SDI stays low). One byte, sent again and again; set at the start.
/// In the last section of the RAM, which is SRAM2: in flash each byte would hold up the fetches of the code that runs meanwhile, six
/// cycles at worst and 216 a sample, and in SRAM1 the end of the interrupt that starts a reading, where the stack is.
#[unsafe(link_section = ".uninit.dma")]
static ZERO: AtomicU8 = AtomicU8::new(0);

/// Why there are no frames.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum NoFrames {
    /// No transfer had been started.
    NotBegun,
    /// The transfer did not come to its end.
    Incomplete,
}

/// The channels' state.
#[derive(Debug)]
pub struct Reading {
    stage: Stage,
}

/// Whose the buses are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// The processor's.
    ByHand,
    /// The DMA controller's, which waits.
    Ready,
    /// The DMA controller's, and a transfer has been started and not been finished.
    UnderWay,
    /// The DMA controller's, which has a byte too many or too few: it would shift the frames that follow.
    Shifted,
}

/// Set-up of the channels that receive, and of those that send.
const RECEIVING: Cr = channel(false);
const SENDING: Cr = channel(true);

const fn channel(sends: bool) -> Cr {
    // Bits of CCR (RM0440, 12.6.3): TCIE 1, DIR 4, CIRC 5, MINC 7, PL 12 and 13. Receiving goes before sending.
    let receives = 1 << 5 | 1 << 7 | (Pl::VERY_HIGH as u32) << 12;
    let sending = (Dir::FROM_MEMORY as u32) << 4 | (Pl::HIGH as u32) << 12;
    Cr(if sends { sending } else { receives })
}

/// The last to end interrupts: chip 1's, started last.
const INTERRUPTS: Cr = Cr(RECEIVING.0 | 1 << 1);
const ENABLE: u32 = 1;

impl Reading {
    /// Sets the channels up; the buses stay the processor's.
    pub fn start() -> Self {
        RCC.ahb1enr().modify(|w| {
            w.set_dma1en(true);
            w.set_dmamux1en(true);
        });
        for (channel, request) in REQUESTS.into_iter().enumerate() {
            DMAMUX1.ccr(channel).modify(|w| w.set_dmareq_id(request));
        }
        // What lies in that section is not set up before the program.
        ZERO.store(0, Relaxed);
        for (chip, bus) in spi::BUS.iter().enumerate() {
            let data = bus.dr8().as_ptr() as u32;
            receiving()[chip].par().write_value(data);
            receiving()[chip]
                .mar()
                .write_value(FRAMES[chip].0.get() as u32);
            sending()[chip].par().write_value(data);
            sending()[chip].mar().write_value(ZERO.as_ptr() as u32);
        }
        Self {
            stage: Stage::ByHand,
        }
    }

    /// Whether a transfer has been started and not been finished.
    #[inline(always)]
    pub fn is_under_way(&self) -> bool {
        self.stage == Stage::UnderWay
    }

    /// Whether a transfer may be started.
    #[inline(always)]
    pub fn is_ready(&self) -> bool {
        self.stage == Stage::Ready
    }

    /// Selects both chips and starts a transfer from each.
    #[inline(always)]
    pub fn begin(&mut self) {
        self.stage = Stage::UnderWay;
        select(true);
        // Written out: the image is built for size, which leaves loops as they are. Both are ready before one starts: from then on DMA takes
        // the bus that their registers are on.
        let [first, second] = sending();
        prepare(first);
        prepare(second);
        first.cr().write_value(Cr(SENDING.0 | ENABLE));
        second.cr().write_value(Cr(SENDING.0 | ENABLE));
    }

    /// Ends a transfer: both chips are deselected. The frames stay until the next [`Reading::begin`].
    ///
    /// # Errors
    /// [`NoFrames`].
    #[inline(always)]
    pub fn finish(&mut self) -> Result<[&FrameBytes; 2], NoFrames> {
        if !self.is_under_way() {
            release();
            return Err(NoFrames::NotBegun);
        }
        let complete = both_complete();
        release();
        self.stage = Stage::Ready;
        if !complete {
            return Err(NoFrames::Incomplete);
        }
        // The reads that follow are of what the controller has written.
        compiler_fence(SeqCst);
        let [first, second] = &FRAMES;
        // SAFETY: see `Place`; the transfer has ended, and the next one begins after the borrow of `self`.
        Ok(unsafe { [&*first.0.get(), &*second.0.get()] })
    }

    /// Frames were not as the chips send them: if that is for a byte too many or too few, no transfer may be started before
    /// [`Reading::make_ready`]. That takes as long as the check of both frames, so it waits for the next instant.
    #[inline(always)]
    pub fn doubt(&mut self) {
        // A channel that receives begins anew by itself: between two frames it has a whole one before it.
        let left = |channel: Ch| channel.ndtr().read().0;
        let [first, second] = receiving();
        if left(first) & left(second) != FRAME_BYTES as u32 || left(first) != left(second) {
            self.stage = Stage::Shifted;
        }
    }

    /// The buses become the DMA controller's, whatever went on there: a transfer may be started.
    #[inline(never)]
    pub fn make_ready(&mut self) {
        match self.stage {
            Stage::Ready => return,
            // Both buses are at rest, and what was left over is in memory or in a receiver.
            Stage::Shifted => {}
            Stage::ByHand | Stage::UnderWay => stop(),
        }
        self.stage = Stage::Ready;
        let [first, second] = receiving();
        receive(first, spi::BUS[0], RECEIVING);
        receive(second, spi::BUS[1], INTERRUPTS);
        DMA1.ifcr().write_value(Isr(0x1111));
    }

    /// The buses become the processor's, whatever went on there.
    #[inline(never)]
    pub fn by_hand(&mut self) {
        if self.stage != Stage::ByHand {
            self.stage = Stage::ByHand;
            stop();
        }
    }
}

/// Switches all channels off, deselects both chips and sets both buses anew: nothing is known of their state.
#[inline(never)]
fn stop() {
    let ([first, second], [third, fourth]) = (receiving(), sending());
    first.cr().write_value(RECEIVING);
    second.cr().write_value(RECEIVING);
    third.cr().write_value(SENDING);
    fourth.cr().write_value(SENDING);
    select(false);
    spi::set_anew();
}

/// A channel receives a whole frame from now on, and then the next.
#[inline(always)]
fn receive(channel: Ch, bus: Spi, set_up: Cr) {
    channel.cr().write_value(set_up);
    spi::drain(bus);
    channel.ndtr().write_value(Ndtr(FRAME_BYTES as u32));
    channel.cr().write_value(Cr(set_up.0 | ENABLE));
    spi::serve_by_dma(bus);
}

/// Selects both chips, or neither.
#[inline(always)]
fn select(low: bool) {
    let [first, second] = pins::SELECT;
    first.level(!low);
    second.level(!low);
}

/// Deselects both chips and takes the flags of all channels back.
#[inline(always)]
fn release() {
    select(false);
    // The global bit of each channel takes its flags back.
    DMA1.ifcr().write_value(Isr(0x1111));
}

/// Sets a channel up that sends, to be switched on.
#[inline(always)]
fn prepare(channel: Ch) {
    channel.cr().write_value(SENDING);
    channel.ndtr().write_value(Ndtr(FRAME_BYTES as u32));
}

/// Whether all bytes of both chips have come; the first chip's may come some cycles later.
#[inline(always)]
fn both_complete() -> bool {
    // TCIF of channels 1 and 2.
    const BOTH: u32 = 1 << 1 | 1 << 5;
    let look = || DMA1.isr().read().0 & BOTH == BOTH;
    // The first look is nearly always enough.
    look() || (1..PATIENCE).any(|_| look())
}
