//! SPI1 to both converter chips: 21.25 MHz, polled, chip select by software.
//!
//! A frame is 18 bytes at 0.38 us: polling costs less than an interrupt or a DMA request a byte would. Every wait is bounded.

use super::pins::{self, Pin};
use embedded_hal::spi::{self, Operation, SpiDevice};
use stm32_metapac::spi::vals::{Br, Cpha, Cpol, Ds, Frxth, Mstr};
use stm32_metapac::{RCC, SPI1};

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

/// Switches the peripheral on: mode 2, 8 bits, 170 MHz / 8.
pub fn start() {
    RCC.apb2enr().modify(|w| w.set_spi1en(true));
    configure();
}

/// Resets the peripheral and sets it again: after a transfer that did not end nothing is known of its state.
#[cold]
#[inline(never)]
fn set_anew() {
    RCC.apb2rstr().modify(|w| w.set_spi1rst(true));
    RCC.apb2rstr().modify(|w| w.set_spi1rst(false));
    configure();
}

/// Bytes that the receiver holds at most.
const RECEIVER_BYTES: u32 = 4;

/// Empties the receiver: a byte that was left there would shift every transfer that follows.
#[inline(always)]
fn drain() {
    for _ in 0..RECEIVER_BYTES {
        if !SPI1.sr().read().rxne() {
            return;
        }
        let _ = SPI1.dr8().read();
    }
}

fn configure() {
    SPI1.cr2().write(|w| {
        w.set_ds(Ds::BITS8);
        w.set_frxth(Frxth::QUARTER);
    });
    SPI1.cr1().write(|w| {
        w.set_cpol(Cpol::IDLE_HIGH);
        w.set_cpha(Cpha::FIRST_EDGE);
        w.set_mstr(Mstr::MASTER);
        w.set_br(Br::DIV8);
        w.set_ssm(true);
        w.set_ssi(true);
        w.set_spe(true);
    });
}

/// One chip on the bus.
pub struct Device {
    select: Pin,
}

impl Device {
    /// Chip 0 or 1.
    pub fn new(chip: usize) -> Self {
        Self {
            select: pins::SELECT[chip & 1],
        }
    }
}

impl spi::ErrorType for Device {
    type Error = Timeout;
}

impl SpiDevice for Device {
    #[inline]
    fn transaction(&mut self, operations: &mut [Operation<'_, u8>]) -> Result<(), Timeout> {
        drain();
        self.select.level(false);
        let result = operations.iter_mut().try_for_each(run);
        self.select.level(true);
        if result.is_err() {
            set_anew();
        }
        result
    }
}

#[inline]
fn run(operation: &mut Operation<'_, u8>) -> Result<(), Timeout> {
    match operation {
        Operation::Read(read) => read
            .iter_mut()
            .try_for_each(|byte| exchange(0).map(|got| *byte = got)),
        Operation::Write(write) => write
            .iter()
            .try_for_each(|byte| exchange(*byte).map(|_| ())),
        Operation::TransferInPlace(bytes) => bytes
            .iter_mut()
            .try_for_each(|byte| exchange(*byte).map(|got| *byte = got)),
        Operation::Transfer(read, write) => {
            for index in 0..read.len().max(write.len()) {
                let got = exchange(write.get(index).copied().unwrap_or(0))?;
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
#[inline(always)]
fn exchange(byte: u8) -> Result<u8, Timeout> {
    SPI1.dr8().write_value(byte);
    for _ in 0..PATIENCE {
        if SPI1.sr().read().rxne() {
            return Ok(SPI1.dr8().read());
        }
    }
    Err(Timeout)
}
