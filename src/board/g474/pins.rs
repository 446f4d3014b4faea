//! Pins. The map is in the README; every pin is named here once.

use core::convert::Infallible;
use embedded_hal::digital::{ErrorType, InputPin, OutputPin};
use stm32_metapac::gpio::Gpio;
use stm32_metapac::gpio::regs::Bsrr;
use stm32_metapac::gpio::vals::{Moder, Ospeedr, Pupdr};
use stm32_metapac::{GPIOA, GPIOB, GPIOC, RCC};

/// One pin of a port.
#[derive(Clone, Copy)]
pub struct Pin {
    port: Gpio,
    number: usize,
}

/// Chip selects of converter chips 0 and 1.
pub const SELECT: [Pin; 2] = [Pin::new(GPIOA, 4), Pin::new(GPIOB, 12)];
/// SPI1 to chip 0 and SPI2 to chip 1: clock, data from the converter, data to it.
pub const SPI: [[Pin; 3]; 2] = [
    [Pin::new(GPIOA, 5), Pin::new(GPIOA, 6), Pin::new(GPIOA, 7)],
    [
        Pin::new(GPIOB, 13),
        Pin::new(GPIOB, 14),
        Pin::new(GPIOB, 15),
    ],
];
/// USART1 to the motion controller: transmit, receive.
pub const SERIAL: [Pin; 2] = [Pin::new(GPIOA, 9), Pin::new(GPIOA, 10)];
/// Start of conversion: a plain output while the converters are set up, then the timer's (TIM3 channel 1).
pub const CONVST: Pin = Pin::new(GPIOC, 6);
/// Reset of both converters.
pub const RESET: Pin = Pin::new(GPIOC, 7);
/// Busy line of chip 0; its falling edge is the sampling interrupt, and a timer counts its pulses (TIM8 channel 3).
pub const BUSY: Pin = Pin::new(GPIOC, 8);
/// Reference mark or end stop: low at it.
pub const MARK: Pin = Pin::new(GPIOC, 9);
/// Status LED.
pub const LED: Pin = Pin::new(GPIOB, 2);

/// Alternate functions (data sheet DS12288, table 13).
const SPI1_OR_2: u8 = 5;
const USART1: u8 = 7;
const TIM3: u8 = 2;
const TIM8: u8 = 4;

/// Sets every pin to its purpose.
pub fn start() {
    RCC.ahb2enr().modify(|w| {
        w.set_gpioaen(true);
        w.set_gpioben(true);
        w.set_gpiocen(true);
    });
    for pin in SELECT {
        pin.level(true);
        pin.mode(Moder::OUTPUT);
    }
    for pin in [CONVST, RESET, LED] {
        pin.mode(Moder::OUTPUT);
    }
    // Its edges start conversions from the self-test on.
    CONVST.fast();
    // The timer drives CONVST only once its channel is on: until then the pin floats.
    CONVST.pull(Pupdr::PULL_DOWN);
    // A line that is not driven reads as not busy, so that its interrupt never comes and the silence is noticed.
    BUSY.pull(Pupdr::PULL_DOWN);
    BUSY.mode(Moder::INPUT);
    MARK.pull(Pupdr::PULL_UP);
    MARK.mode(Moder::INPUT);
    for pin in SPI.iter().flatten() {
        pin.alternate(SPI1_OR_2);
    }
    SERIAL.iter().for_each(|pin| pin.alternate(USART1));
    SERIAL[1].pull(Pupdr::PULL_UP);
}

/// Gives CONVST to the timer that starts conversions, and BUSY to the one that counts its pulses. Its interrupt and its level are as before.
pub fn hand_to_timers() {
    CONVST.alternate(TIM3);
    BUSY.alternate(TIM8);
}

impl Pin {
    const fn new(port: Gpio, number: usize) -> Self {
        Self { port, number }
    }

    fn mode(self, mode: Moder) {
        self.port.moder().modify(|w| w.set_moder(self.number, mode));
    }

    fn pull(self, pull: Pupdr) {
        self.port.pupdr().modify(|w| w.set_pupdr(self.number, pull));
    }

    fn alternate(self, function: u8) {
        let (half, place) = (self.number / 8, self.number % 8);
        self.port.afr(half).modify(|w| w.set_afr(place, function));
        self.fast();
        self.mode(Moder::ALTERNATE);
    }

    fn fast(self) {
        self.port
            .ospeedr()
            .modify(|w| w.set_ospeedr(self.number, Ospeedr::HIGH_SPEED));
    }

    /// Sets an output.
    #[inline(always)]
    pub fn level(self, high: bool) {
        // The register's own accessors can panic at a pin's number; this runs in the sampling interrupt.
        let bit = 1 << (self.number & 15);
        self.port
            .bsrr()
            .write_value(Bsrr(if high { bit } else { bit << 16 }));
    }
}

impl Pin {
    /// Level of an input.
    fn reads_high(self) -> bool {
        self.port.idr().read().0 >> (self.number & 15) & 1 == 1
    }

    /// Whether an input reads low.
    pub fn is_grounded(self) -> bool {
        !self.reads_high()
    }
}

impl ErrorType for Pin {
    type Error = Infallible;
}

impl OutputPin for Pin {
    fn set_low(&mut self) -> Result<(), Infallible> {
        self.level(false);
        Ok(())
    }

    fn set_high(&mut self) -> Result<(), Infallible> {
        self.level(true);
        Ok(())
    }
}

impl InputPin for Pin {
    fn is_high(&mut self) -> Result<bool, Infallible> {
        Ok(self.reads_high())
    }

    fn is_low(&mut self) -> Result<bool, Infallible> {
        self.is_high().map(|high| !high)
    }
}
