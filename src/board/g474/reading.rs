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
/// Looks at the other chip's channel at a transfer's end: both run at the same clock, and a byte takes 64 cycles.
const PATIENCE: u32 = 64;

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

/// A transfer did not come to its end.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Incomplete;

/// The channels' state.
#[derive(Debug)]
pub struct Reading {
    stage: Stage,
}

/// Whose the buses are.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Stage {
    /// The processor's.
    Off,
    /// The DMA controller's, which waits.
    Ready,
    /// The DMA controller's, and a transfer has been started and not been finished.
    UnderWay,
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
        Self { stage: Stage::Off }
    }

    /// Whether a transfer has been started and not been finished.
    #[inline(always)]
    pub fn is_under_way(&self) -> bool {
        self.stage == Stage::UnderWay
    }

    /// Selects both chips and starts a transfer from each.
    #[inline(always)]
    pub fn begin(&mut self) {
        if self.stage == Stage::Off {
            self.arm();
        }
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
    /// [`Incomplete`]: not all of both frames is there.
    #[inline(always)]
    pub fn finish(&mut self) -> Result<[&FrameBytes; 2], Incomplete> {
        if !self.is_under_way() || !both_complete() {
            release();
            if self.stage == Stage::UnderWay {
                self.stage = Stage::Ready;
            }
            return Err(Incomplete);
        }
        release();
        self.stage = Stage::Ready;
        // The reads that follow are of what the controller has written.
        compiler_fence(SeqCst);
        let [first, second] = &FRAMES;
        // SAFETY: see `Place`; the transfer has ended, and the next one begins after the borrow of `self`.
        Ok(unsafe { [&*first.0.get(), &*second.0.get()] })
    }

    /// The buses become the DMA controller's.
    #[cold]
    #[inline(never)]
    fn arm(&mut self) {
        self.stage = Stage::Ready;
        DMA1.ifcr().write_value(Isr(0x1111));
        let set_ups = [RECEIVING, INTERRUPTS];
        for ((bus, channel), set_up) in spi::BUS.into_iter().zip(receiving()).zip(set_ups) {
            spi::drain(bus);
            bus.cr2().modify(|w| w.set_rxdmaen(true));
            channel.ndtr().write_value(Ndtr(FRAME_BYTES as u32));
            channel.cr().write_value(set_up);
            channel.cr().write_value(Cr(set_up.0 | ENABLE));
            bus.cr2().modify(|w| w.set_txdmaen(true));
        }
    }

    /// The buses become the processor's again, whatever went on there.
    #[cold]
    #[inline(never)]
    pub fn disarm(&mut self) {
        let before = core::mem::replace(&mut self.stage, Stage::Off);
        if before == Stage::Off {
            return;
        }
        for channel in receiving() {
            channel.cr().write_value(RECEIVING);
        }
        for channel in sending() {
            channel.cr().write_value(SENDING);
        }
        select(false);
        for bus in spi::BUS {
            bus.cr2().modify(|w| {
                w.set_rxdmaen(false);
                w.set_txdmaen(false);
            });
            spi::drain(bus);
        }
        if before == Stage::UnderWay {
            spi::set_anew();
        }
        DMA1.ifcr().write_value(Isr(0x1111));
    }
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
