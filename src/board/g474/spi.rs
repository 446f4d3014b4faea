//! SPI1 to converter chip 0 and SPI2 to chip 1: 21.25 MHz, chip select by software. Here byte by byte, for the chips' registers and the
//! self-test; conversions are fetched by DMA (`reading`). Every wait is bounded.

use super::clocks::CLOCK_HZ;
use super::pins::{self, Pin};
use crate::drivers::converter::timing::SCLK_HZ;
use embedded_hal::spi::{self, Operation, SpiDevice};
use stm32_metapac::rcc::regs::{Apb1rstr1, Apb2rstr};
use stm32_metapac::spi::Spi;
use stm32_metapac::spi::regs::Cr2;
use stm32_metapac::spi::vals::{Br, Cpha, Cpol, Ds, Frxth, Mstr};
use stm32_metapac::{RCC, SPI1, SPI2};

/// The peripheral of each chip.
pub const BUS: [Spi; 2] = [SPI1, SPI2];

/// Looks at the status register before giving up: some hundred times a byte.
const PATIENCE: u32 = 10_000;

/// The peripheral did not answer in time.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Timeout;

impl spi::Error for Timeout {
    fn kind(&self) -> spi::ErrorKind {
        spi::ErrorKind::Other
    }
}

// What `Br::DIV8` makes of the clock.
const _: () = assert!(CLOCK_HZ / 8 == SCLK_HZ);

/// Switches both peripherals on: mode 2, 8 bits, 170 MHz / 8.
pub fn start() {
    RCC.apb2enr().modify(|w| w.set_spi1en(true));
    RCC.apb1enr1().modify(|w| w.set_spi2en(true));
    BUS.into_iter().for_each(configure);
}

/// Resets both peripherals and sets them again: after a transfer that did not end nothing is known of their state.
#[inline(never)]
pub fn set_anew() {
    // No other peripheral is held in reset, so nothing is read first: this runs in the sampling interrupt.
    RCC.apb2rstr().write(|w| w.set_spi1rst(true));
    RCC.apb2rstr().write_value(Apb2rstr(0));
    RCC.apb1rstr1().write(|w| w.set_spi2rst(true));
    RCC.apb1rstr1().write_value(Apb1rstr1(0));
    let [first, second] = BUS;
    configure(first);
    configure(second);
}

/// Bytes of 8 bits, each of which is told: DS from bit 8, FRXTH at bit 12 (RM0440, 39.9.2).
const BYTES: Cr2 = Cr2((Ds::BITS8 as u32) << 8 | (Frxth::QUARTER as u32) << 12);

/// Bytes that the receiver holds at most, and so does the sender.
const FIFO_BYTES: usize = 4;

/// Empties a receiver: a byte that was left there would shift every transfer that follows.
#[inline(always)]
pub fn drain(bus: Spi) {
    for _ in 0..FIFO_BYTES {
        if !bus.sr().read().rxne() {
            return;
        }
        let _ = bus.dr8().read();
    }
}

/// Bytes are moved by DMA from now on, until the peripheral is [set anew](set_anew).
#[inline(always)]
pub fn serve_by_dma(bus: Spi) {
    let mut cr2 = BYTES;
    cr2.set_rxdmaen(true);
    cr2.set_txdmaen(true);
    bus.cr2().write_value(cr2);
}

#[inline(always)]
fn configure(bus: Spi) {
    bus.cr2().write_value(BYTES);
    bus.cr1().write(|w| {
        w.set_cpol(Cpol::IDLE_HIGH);
        w.set_cpha(Cpha::FIRST_EDGE);
        w.set_mstr(Mstr::MASTER);
        w.set_br(Br::DIV8);
        w.set_ssm(true);
        w.set_ssi(true);
        w.set_spe(true);
    });
}

/// A chip-select frame that the peripheral works off by itself.
pub struct UnderWay {
    bus: Spi,
    select: Pin,
    bytes: usize,
}

/// Begins to exchange a frame with chip 0 or 1; its first four bytes, which is what the FIFO holds.
#[inline(always)]
pub fn begin(chip: u8, bytes: &[u8]) -> UnderWay {
    let Device { bus, select } = Device::new(usize::from(chip));
    drain(bus);
    select.level(false);
    let bytes = bytes.iter().take(FIFO_BYTES);
    let count = bytes.len();
    bytes.for_each(|byte| bus.dr8().write_value(*byte));
    UnderWay {
        bus,
        select,
        bytes: count,
    }
}

impl UnderWay {
    /// Waits for the rest of it and takes what came back, zeros after it.
    ///
    /// # Errors
    /// The peripheral is silent.
    #[inline(always)]
    pub fn end<const N: usize>(self) -> Result<[u8; N], Timeout> {
        let mut reply = [0; N];
        let is_idle = |_| self.bus.sr().read().0 & UNDER_WAY == 0;
        let has_ended = (0..PATIENCE).any(is_idle);
        self.select.level(true);
        if !has_ended {
            set_anew();
            return Err(Timeout);
        }
        for place in reply.iter_mut().take(self.bytes) {
            *place = self.bus.dr8().read();
        }
        Ok(reply)
    }
}

/// Bits of the status register while something is still to be sent: BSY, and FTLVL (RM0440, 39.9.3).
const UNDER_WAY: u32 = 1 << 7 | 3 << 11;

/// Waits for a byte.
#[inline(always)]
fn receive(bus: Spi) -> Result<u8, Timeout> {
    for _ in 0..PATIENCE {
        if bus.sr().read().rxne() {
            return Ok(bus.dr8().read());
        }
    }
    Err(Timeout)
}

/// One chip on its bus.
pub struct Device {
    bus: Spi,
    select: Pin,
}

impl Device {
    /// Chip 0 or 1.
    pub fn new(chip: usize) -> Self {
        Self {
            bus: BUS[chip & 1],
            select: pins::SELECT[chip & 1],
        }
    }

    fn run(&self, operation: &mut Operation<'_, u8>) -> Result<(), Timeout> {
        match operation {
            Operation::Read(read) => read
                .iter_mut()
                .try_for_each(|byte| self.exchange(0).map(|got| *byte = got)),
            Operation::Write(write) => write
                .iter()
                .try_for_each(|byte| self.exchange(*byte).map(|_| ())),
            Operation::TransferInPlace(bytes) => bytes
                .iter_mut()
                .try_for_each(|byte| self.exchange(*byte).map(|got| *byte = got)),
            Operation::Transfer(read, write) => {
                for index in 0..read.len().max(write.len()) {
                    let got = self.exchange(write.get(index).copied().unwrap_or(0))?;
                    if let Some(place) = read.get_mut(index) {
                        *place = got;
                    }
                }
                Ok(())
            }
            Operation::DelayNs(ns) => {
                embedded_hal::delay::DelayNs::delay_ns(&mut super::clocks::Delay, *ns);
                Ok(())
            }
        }
    }

    /// One byte out and one in.
    fn exchange(&self, byte: u8) -> Result<u8, Timeout> {
        self.bus.dr8().write_value(byte);
        receive(self.bus)
    }
}

impl spi::ErrorType for Device {
    type Error = Timeout;
}

impl SpiDevice for Device {
    #[inline]
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Timeout> {
        drain(self.bus);
        self.select.level(false);
        let result = operations
            .iter_mut()
            .try_for_each(|operation| self.run(operation));
        self.select.level(true);
        if result.is_err() {
            set_anew();
        }
        result
    }
}
