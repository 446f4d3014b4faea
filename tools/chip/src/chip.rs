//! The chip without its processor: all peripherals, the lines between them, and the lines to the outside.

mod access;
mod transfers;

use self::transfers::{SPI, Transfers};
use crate::line_levels::Lines;
use crate::peripheral::adc::Adc;
use crate::peripheral::capture::Capture;
use crate::peripheral::crc::Crc;
use crate::peripheral::debug::Dbgmcu;
use crate::peripheral::dma::{self, Dma};
use crate::peripheral::edges::Edges;
use crate::peripheral::exti::Exti;
use crate::peripheral::flash::{Flash, Start};
use crate::peripheral::gpio::Gpio;
use crate::peripheral::pwr::Pwr;
use crate::peripheral::rcc::{Cause, Rcc};
use crate::peripheral::spi::Spi;
use crate::peripheral::syscfg::Syscfg;
use crate::peripheral::timer::Timer;
use crate::peripheral::usart::Usart;
use crate::peripheral::watchdog::{Iwdg, LSI};
use crate::peripheral::window::Wwdg;
use crate::peripheral::{Access, Peripheral, Unit};
use crate::recorder::Recorder;
use crate::registers;
use crate::rule::{Findings, Rule};
use crate::surroundings::Surroundings;
use crate::time::{NEVER, Ticks};
use anyhow::Result;
use stm32_metapac::flash::regs::Optr;

/// Ports of the chip.
const PORTS: usize = 7;
/// Supply, volts.
const SUPPLY_V: f64 = 3.3;

/// Interrupt lines of the peripherals that the model has.
#[derive(Clone, Copy, Debug)]
struct Interrupts {
    exti: [(u32, u16); 7],
    usart1: u16,
    wwdg: u16,
    dma1: [u16; dma::CHANNELS],
}

/// The peripherals and what they are wired to.
pub struct Chip {
    /// Now.
    pub now: Ticks,
    /// Broken rules.
    pub findings: Findings,
    /// The board's other parts.
    pub around: Surroundings,
    /// Where the block of instructions begins that runs.
    pub running_at: u32,
    /// What the board's lines do, if it is recorded.
    pub recorder: Option<Recorder>,
    remapped: bool,
    /// Whether a read may have changed anything.
    changed: bool,
    start: Start,
    stored_options: Option<Optr>,
    pub(crate) rcc: Rcc,
    pwr: Pwr,
    pub(crate) flash: Flash,
    pub(crate) gpio: [Gpio; PORTS],
    pub(crate) exti: Exti,
    pub(crate) syscfg: Syscfg,
    tim2: Timer,
    pub(crate) tim3: Timer,
    pub(crate) tim8: Edges,
    tim16: Capture,
    pub(crate) spi: [Spi; 2],
    /// What DMA moves.
    pub transfers: Transfers,
    crc: Crc,
    usart1: Usart,
    adc1: Adc,
    iwdg: Iwdg,
    wwdg: Wwdg,
    dbgmcu: Dbgmcu,
    pub(crate) lines: Lines,
    interrupts: Interrupts,
    next: Ticks,
}

impl Chip {
    /// After power-on.
    pub fn new(around: Surroundings, start: Start) -> Self {
        let exti = [
            (0x0001, "EXTI0"),
            (0x0002, "EXTI1"),
            (0x0004, "EXTI2"),
            (0x0008, "EXTI3"),
            (0x0010, "EXTI4"),
            (0x03E0, "EXTI9_5"),
            (0xFC00, "EXTI15_10"),
        ];
        let interrupts = Interrupts {
            exti: exti.map(|(lines, name)| (lines, registers::interrupt(name))),
            usart1: registers::interrupt("USART1"),
            wwdg: registers::interrupt("WWDG"),
            dma1: std::array::from_fn(|channel| {
                registers::interrupt(&format!("DMA1_CHANNEL{}", channel + 1))
            }),
        };
        Self {
            now: 0,
            findings: Findings::default(),
            running_at: 0,
            recorder: None,
            remapped: false,
            changed: false,
            start,
            stored_options: None,
            rcc: Rcc::after(Cause::Supply, None),
            pwr: Pwr::after_reset(SUPPLY_V),
            flash: Flash::after_reset(start, around.banks.clone()),
            gpio: std::array::from_fn(Gpio::after_reset),
            exti: Exti::after_reset(),
            syscfg: Syscfg::after_reset(),
            tim2: Timer::after_reset("TIM2", 32),
            tim3: Timer::after_reset("TIM3", 16),
            tim8: Edges::after_reset(),
            tim16: Capture::after_reset(LSI),
            spi: SPI.map(Spi::after_reset),
            transfers: Transfers::after_reset(),
            crc: Crc::after_reset(),
            usart1: Usart::after_reset(),
            adc1: Adc::after_reset(),
            iwdg: Iwdg::after_reset(),
            wwdg: Wwdg::after_reset(),
            dbgmcu: Dbgmcu::after_reset(),
            lines: Lines::default(),
            around,
            interrupts,
            next: NEVER,
        }
    }

    /// A reset; the supply's own leaves nothing as it was.
    ///
    /// # Errors
    /// The host's bank of the flash is one of another size.
    pub fn reset(&mut self, cause: Cause) -> Result<()> {
        // Option bytes are loaded when the supply comes and when it is asked for (RM0440, 3.4.2); until then they wait.
        self.stored_options = self.flash.programmed_options().or(self.stored_options);
        if matches!(cause, Cause::Supply | Cause::Options) {
            self.start.options = self.stored_options.take().unwrap_or(self.start.options);
        }
        self.rcc = Rcc::after(cause, (cause != Cause::Supply).then_some(&self.rcc));
        self.pwr = Pwr::after_reset(self.pwr.supply_v);
        self.flash = Flash::after_reset(self.start, self.around.banks.clone());
        self.gpio = std::array::from_fn(Gpio::after_reset);
        self.exti = Exti::after_reset();
        self.syscfg = Syscfg::after_reset();
        self.tim2 = Timer::after_reset("TIM2", 32);
        self.tim3 = Timer::after_reset("TIM3", 16);
        self.tim8 = Edges::after_reset();
        self.tim16 = Capture::after_reset(self.tim16.period);
        self.spi = SPI.map(Spi::after_reset);
        self.transfers.reset();
        self.crc = Crc::after_reset();
        self.usart1 = Usart::after_reset();
        self.adc1 = Adc::after_reset();
        self.iwdg = Iwdg::after_reset();
        self.wwdg = Wwdg::after_reset();
        if cause == Cause::Supply {
            self.dbgmcu = Dbgmcu::after_reset();
            for bank in &mut self.around.banks {
                bank.power_up()?;
            }
        }
        self.lines = Lines::default();
        self.around.release(self.now);
        self.settle();
        Ok(())
    }

    /// The processor's cycle, ticks.
    pub fn cycle(&self) -> Ticks {
        self.rcc.clocks().cycle()
    }

    /// The next instant at which a peripheral does something by itself.
    pub fn next(&self) -> Ticks {
        self.next
    }

    /// Whether the watchdog wants a reset.
    pub fn watchdog_expired(&self) -> bool {
        self.iwdg.expired() || self.wwdg.expired()
    }

    /// Whether a load of the option bytes, and so a reset, is asked for.
    pub fn loads_options(&self) -> bool {
        self.flash.launched()
    }

    /// Whether the banks of the flash have changed places: code runs from bank 2.
    pub fn banks_swapped(&self) -> bool {
        self.flash.swapped()
    }

    /// A debugger halts the processor for so long: the peripherals go on, but what it freezes.
    pub fn halt(&mut self, duration: Ticks) {
        if self.dbgmcu.watchdog_frozen() {
            self.iwdg.stood_still(duration);
        }
        if self.dbgmcu.window_watchdog_frozen() {
            self.wwdg.stood_still(duration);
        }
        self.advance_to(self.now + duration);
    }

    /// The slow oscillator has another period than it should, as the captures see it; the watchdog keeps its own.
    pub fn set_slow_clock(&mut self, period: Ticks) {
        self.tim16.period = period;
    }

    /// A byte that nobody asked for gets into the bus's FIFO.
    pub fn disturb_bus(&mut self, byte: u8) {
        self.with(|chip, access| chip.spi[0].answer(byte, access));
    }

    /// A double word of the code is found to have wrong check bits.
    pub fn disturb_code(&mut self) {
        let near = self.flash.near();
        self.flash.note_double_error(near, 0x2000);
    }

    /// Interrupt lines that are up, a bit each.
    pub fn interrupt_lines(&self) -> u128 {
        let (pending, of_dma) = (self.exti.pending(), self.transfers.dma1.interrupts());
        let mut up = 0;
        if pending != 0 {
            for (lines, number) in self.interrupts.exti {
                up |= u128::from(pending & lines != 0) << number;
            }
        }
        if of_dma != 0 {
            for (channel, number) in self.interrupts.dma1.iter().enumerate() {
                up |= u128::from(of_dma >> channel & 1) << number;
            }
        }
        up |= u128::from(self.wwdg.interrupts()) << self.interrupts.wwdg;
        up | u128::from(self.usart1.interrupts()) << self.interrupts.usart1
    }

    /// Lets time pass.
    pub fn advance_to(&mut self, until: Ticks) {
        while self.next <= until {
            self.now = self.now.max(self.next);
            self.happen();
            self.settle();
        }
        self.now = until;
    }

    /// Everything that is due now.
    fn happen(&mut self) {
        self.with(|chip, access| {
            chip.rcc.advance(access);
            chip.flash.advance(access);
            chip.tim3.advance(access);
            chip.tim16.advance(access);
            let triggers = chip.tim3.take_triggers();
            chip.tim2.count_triggers(triggers);
            for (index, spi) in chip.spi.iter_mut().enumerate() {
                spi.advance(access);
                if let Some(byte) = spi.take_gone() {
                    let answer = chip.around.exchange(index, byte);
                    if let Some(recorder) = &mut chip.recorder {
                        recorder.byte(index, spi.gone_between(), answer.unwrap_or(0));
                    }
                    if let Some(answer) = answer {
                        spi.answer(answer, access);
                    }
                }
            }
            let looks = chip.usart1.next() <= access.now;
            chip.usart1.advance(access);
            if looks && chip.usart1.listens() {
                while let Some(byte) = chip.around.receive(access.now) {
                    chip.usart1.receive(byte);
                }
            }
            if chip.adc1.next() <= access.now {
                chip.adc1.temperature_c = chip.around.temperature_c();
                chip.adc1.advance(access);
            }
            chip.wwdg.advance(access);
            chip.iwdg.advance(access);
            if chip.iwdg.expired() {
                access.broken(Rule::Watchdog, "it was not fed");
            }
        });
    }

    /// Brings lines and the next instant up to date.
    fn settle(&mut self) {
        self.with(|chip, access| chip.transfers.serve(&mut chip.spi, access));
        if let Some(byte) = self.usart1.take_begun() {
            self.lines
                .check_serial(&self.gpio, self.now, &mut self.findings);
            self.around.send(byte, self.now);
        }
        Lines::settle(self);
        let own = [
            self.rcc.next(),
            self.flash.next(),
            self.tim3.next(),
            self.tim16.next(),
            self.spi[0].next(),
            self.spi[1].next(),
            self.usart1.next(),
            self.adc1.next(),
            self.iwdg.next(),
            self.wwdg.next(),
        ];
        let lines = self
            .tim3
            .next_edge(self.now)
            .min(self.around.busy_falls(self.now));
        self.next = own.into_iter().fold(lines, Ticks::min);
    }

    fn with<R>(&mut self, work: impl FnOnce(&mut Self, &mut Access) -> R) -> R {
        let mut findings = std::mem::take(&mut self.findings);
        let mut access = Access {
            now: self.now,
            clocks: self.rcc.clocks(),
            findings: &mut findings,
        };
        let result = work(self, &mut access);
        self.findings = findings;
        result
    }

    fn unit(&mut self, unit: Unit) -> &mut dyn Peripheral {
        match unit {
            Unit::Rcc => &mut self.rcc,
            Unit::Pwr => &mut self.pwr,
            Unit::Flash => &mut self.flash,
            Unit::Gpio(port) => &mut self.gpio[port],
            Unit::Exti => &mut self.exti,
            Unit::Syscfg => &mut self.syscfg,
            Unit::Tim2 => &mut self.tim2,
            Unit::Tim3 => &mut self.tim3,
            Unit::Tim8 => &mut self.tim8,
            Unit::Tim16 => &mut self.tim16,
            Unit::Spi(index) => &mut self.spi[index],
            Unit::Dma1 => &mut self.transfers.dma1,
            Unit::Dmamux1 => &mut self.transfers.dmamux1,
            Unit::Crc => &mut self.crc,
            Unit::Usart1 => &mut self.usart1,
            Unit::Adc1 | Unit::Adc12Common => &mut self.adc1,
            Unit::Iwdg => &mut self.iwdg,
            Unit::Wwdg => &mut self.wwdg,
            Unit::Dbgmcu => &mut self.dbgmcu,
        }
    }

    /// The clock controller resets a peripheral. The watchdog and the clock controller itself have no such bit.
    fn set_back(&mut self, unit: Unit) {
        match unit {
            Unit::Pwr => self.pwr = Pwr::after_reset(self.pwr.supply_v),
            Unit::Flash => self.flash = Flash::after_reset(self.start, self.around.banks.clone()),
            Unit::Gpio(port) => self.gpio[port] = Gpio::after_reset(port),
            Unit::Syscfg => self.syscfg = Syscfg::after_reset(),
            Unit::Tim2 => self.tim2 = Timer::after_reset("TIM2", 32),
            Unit::Tim3 => self.tim3 = Timer::after_reset("TIM3", 16),
            Unit::Tim8 => self.tim8 = Edges::after_reset(),
            Unit::Spi(index) => self.spi[index] = Spi::after_reset(SPI[index]),
            Unit::Dma1 => self.transfers.dma1 = Dma::after_reset(),
            Unit::Crc => self.crc = Crc::after_reset(),
            Unit::Usart1 => self.usart1 = Usart::after_reset(),
            Unit::Adc1 | Unit::Adc12Common => self.adc1 = Adc::after_reset(),
            _ => {}
        }
    }
}
