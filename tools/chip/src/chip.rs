//! The chip without its processor: all peripherals, the lines between them, and the lines to the outside.

use crate::lines::Lines;
use crate::peripheral::adc::{self, Adc};
use crate::peripheral::capture::Capture;
use crate::peripheral::crc::Crc;
use crate::peripheral::debug::Dbgmcu;
use crate::peripheral::dma::{self, Dma, Dmamux};
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
use crate::peripheral::{Access, Peripheral, Unit};
use crate::processor::FLASH;
use crate::registers::{self, Map, Register};
use crate::rule::{Findings, Rule};
use crate::surroundings::Surroundings;
use crate::time::{NEVER, Ticks};
use std::rc::Rc;
use stm32_metapac::flash::regs::Optr;

/// Ports of the chip.
const PORTS: usize = 7;
/// The converters' buses.
const SPI: [&str; 2] = ["SPI1", "SPI2"];
/// Offset of their data register (RM0440, 39.9.4).
const SPI_DATA: u32 = 0x0C;
/// Supply, volts.
const SUPPLY_V: f64 = 3.3;

/// Interrupt lines of the peripherals that the model has.
#[derive(Clone, Copy, Debug)]
struct Interrupts {
    exti: [(u32, u16); 7],
    usart1: u16,
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
    map: Map,
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
    tim16: Capture,
    pub(crate) spi: [Spi; 2],
    dma1: Dma,
    dmamux1: Dmamux,
    crc: Crc,
    code: Rc<[u8]>,
    stored: Vec<(u32, u8)>,
    requests: [(u32, usize, bool); 4],
    usart1: Usart,
    adc1: Adc,
    iwdg: Iwdg,
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
            dma1: std::array::from_fn(|channel| {
                registers::interrupt(&format!("DMA1_CHANNEL{}", channel + 1))
            }),
        };
        Self {
            now: 0,
            findings: Findings::default(),
            map: Map::new(),
            start,
            stored_options: None,
            rcc: Rcc::after(Cause::Supply, None),
            pwr: Pwr::after_reset(SUPPLY_V),
            flash: Flash::after_reset(start, around.flash.clone()),
            gpio: std::array::from_fn(Gpio::after_reset),
            exti: Exti::after_reset(),
            syscfg: Syscfg::after_reset(),
            tim2: Timer::after_reset("TIM2", 32),
            tim3: Timer::after_reset("TIM3", 16),
            tim16: Capture::after_reset(LSI),
            spi: SPI.map(Spi::after_reset),
            dma1: Dma::after_reset(),
            dmamux1: Dmamux::after_reset(),
            crc: Crc::after_reset(),
            code: Rc::new([]),
            stored: vec![],
            requests: std::array::from_fn(|k| {
                let (index, receives) = (k / 2, k % 2 == 0);
                let signal = if receives { "RX" } else { "TX" };
                (registers::dma_request(SPI[index], signal), index, receives)
            }),
            usart1: Usart::after_reset(),
            adc1: Adc::after_reset(),
            iwdg: Iwdg::after_reset(),
            dbgmcu: Dbgmcu::after_reset(),
            lines: Lines::default(),
            around,
            interrupts,
            next: NEVER,
        }
    }

    /// A reset; the supply's own leaves nothing as it was.
    pub fn reset(&mut self, cause: Cause) {
        // Option bytes are loaded when the supply comes and when it is asked for (RM0440, 3.4.2); until then they wait.
        self.stored_options = self.flash.programmed_options().or(self.stored_options);
        if matches!(cause, Cause::Supply | Cause::Options) {
            self.start.options = self.stored_options.take().unwrap_or(self.start.options);
        }
        self.rcc = Rcc::after(cause, (cause != Cause::Supply).then_some(&self.rcc));
        self.pwr = Pwr::after_reset(self.pwr.supply_v);
        self.flash = Flash::after_reset(self.start, self.around.flash.clone());
        self.gpio = std::array::from_fn(Gpio::after_reset);
        self.exti = Exti::after_reset();
        self.syscfg = Syscfg::after_reset();
        self.tim2 = Timer::after_reset("TIM2", 32);
        self.tim3 = Timer::after_reset("TIM3", 16);
        self.tim16 = Capture::after_reset(self.tim16.period);
        self.spi = SPI.map(Spi::after_reset);
        self.dma1 = Dma::after_reset();
        self.dmamux1 = Dmamux::after_reset();
        self.crc = Crc::after_reset();
        self.stored.clear();
        self.usart1 = Usart::after_reset();
        self.adc1 = Adc::after_reset();
        self.iwdg = Iwdg::after_reset();
        if cause == Cause::Supply {
            self.dbgmcu = Dbgmcu::after_reset();
            self.around.flash.power_up();
        }
        self.lines = Lines::default();
        self.around.release(self.now);
        self.settle();
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
        self.iwdg.expired()
    }

    /// Whether a load of the option bytes, and so a reset, is asked for.
    pub fn loads_options(&self) -> bool {
        self.flash.launched()
    }

    /// A debugger halts the processor for so long: the peripherals go on, but what it freezes.
    pub fn halt(&mut self, duration: Ticks) {
        if self.dbgmcu.watchdog_frozen() {
            self.iwdg.stood_still(duration);
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
        self.flash.note_double_error(false, 0x1000);
    }

    /// Interrupt lines that are up, a bit each.
    pub fn interrupt_lines(&self) -> u128 {
        let pending = self.exti.pending();
        let mut up = 0;
        for (lines, number) in self.interrupts.exti {
            up |= u128::from(pending & lines != 0) << number;
        }
        let of_dma = self.dma1.interrupts();
        for (channel, number) in self.interrupts.dma1.iter().enumerate() {
            up |= u128::from(of_dma >> channel & 1) << number;
        }
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
                    spi.answer(answer, access);
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
            chip.iwdg.advance(access);
            if chip.iwdg.expired() {
                access.broken(Rule::Watchdog, "it was not fed");
            }
        });
    }

    /// Brings lines and the next instant up to date.
    fn settle(&mut self) {
        self.with(Self::serve_dma);
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
        ];
        let lines = self
            .tim3
            .next_edge(self.now)
            .min(self.around.busy_falls(self.now));
        self.next = own.into_iter().fold(lines, Ticks::min);
    }

    /// Serves the requests of the peripherals, one byte after the other, until none is left.
    fn serve_dma(&mut self, access: &mut Access) {
        while let Some((channel, index, receives)) = self.next_request() {
            let Some(item) = self.dma1.next_item(channel, access) else {
                continue;
            };
            if receives {
                let byte = self.spi[index].dma_read();
                self.stored.push((item.memory, byte));
            } else {
                let at = item.memory.wrapping_sub(FLASH) as usize;
                let byte = self.code.get(at).copied().unwrap_or(0xFF);
                self.spi[index].dma_write(byte, access);
            }
        }
    }

    /// The channel that is served next, the bus whose request it is, and which of the two.
    fn next_request(&self) -> Option<(usize, usize, bool)> {
        let running = (0..dma::CHANNELS).filter(|channel| self.dma1.runs(*channel));
        let asked = running.filter_map(|channel| {
            let (_, index, receives) = self.request_of(channel)?;
            let asks = self.spi[index].requests(receives);
            asks.then_some((channel, index, receives))
        });
        asked.max_by_key(|(channel, ..)| (self.dma1.priority(*channel), usize::MAX - channel))
    }

    fn request_of(&self, channel: usize) -> Option<(u32, usize, bool)> {
        let number = self.dmamux1.request(channel);
        let mut known = self.requests.iter();
        known.find(|(line, ..)| *line == number).copied()
    }

    /// A channel that is switched on must listen to the register that it serves.
    fn watch_dma(&mut self, access: &mut Access) {
        for channel in self.dma1.take_enabled() {
            let (register, to_peripheral) = self.dma1.target(channel);
            let fits = self
                .request_of(channel)
                .is_some_and(|(_, index, receives)| {
                    let data = registers::address(SPI[index]) + SPI_DATA;
                    data == register && receives != to_peripheral
                });
            if !fits {
                let detail = format!(
                    "channel {} serves {register:#010x} at request {}",
                    channel + 1,
                    self.dmamux1.request(channel)
                );
                access.broken(Rule::DmaRequest, detail);
            }
        }
    }

    /// The bytes of bank 1, which DMA may read.
    pub fn set_code(&mut self, code: &[u8]) {
        self.code = code.into();
    }

    /// Whether DMA has put anything into memory since the last look.
    pub fn has_stored(&self) -> bool {
        !self.stored.is_empty()
    }

    /// Bytes that DMA has put into memory since the last call, with their addresses.
    pub fn take_stored(&mut self) -> Vec<(u32, u8)> {
        std::mem::take(&mut self.stored)
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
            Unit::Tim16 => &mut self.tim16,
            Unit::Spi(index) => &mut self.spi[index],
            Unit::Dma1 => &mut self.dma1,
            Unit::Dmamux1 => &mut self.dmamux1,
            Unit::Crc => &mut self.crc,
            Unit::Usart1 => &mut self.usart1,
            Unit::Adc1 | Unit::Adc12Common => &mut self.adc1,
            Unit::Iwdg => &mut self.iwdg,
            Unit::Dbgmcu => &mut self.dbgmcu,
        }
    }

    /// What every access must be: to a register that there is, with its clock on.
    fn look_up(&mut self, address: u32) -> Option<(Register, Unit)> {
        let Some(register) = self.map.find(address).copied() else {
            let detail = format!("{address:#010x}: no register of the chip's tables");
            self.findings.add(Rule::Unmodelled, self.now, detail);
            return None;
        };
        let Some(unit) = register.unit else {
            let detail = format!(
                "{}.{}: not in the model",
                register.peripheral, register.name
            );
            self.findings.add(Rule::Unmodelled, self.now, detail);
            return None;
        };
        if let Some((enable, bit)) = register.clock
            && !self.rcc.enabled(enable, bit)
        {
            let detail = format!("{}.{}", register.peripheral, register.name);
            self.findings.add(Rule::PeripheralClock, self.now, detail);
            return None;
        }
        Some((register, unit))
    }

    /// A read by the processor, of `width` bytes.
    pub fn read(&mut self, address: u32, width: usize) -> u32 {
        let Some((register, unit)) = self.look_up(address & !3) else {
            return 0;
        };
        let value = self.with(|chip, access| match unit {
            Unit::Adc12Common => chip.adc1.common.0,
            _ => chip.unit(unit).read(&register, access),
        });
        if is_data(&register) {
            self.settle();
        }
        match width {
            4 => value,
            _ => value >> (8 * (address & 3)) & ((1u64 << (8 * width)) - 1) as u32,
        }
    }

    /// A write by the processor, of `width` bytes.
    pub fn write(&mut self, address: u32, width: usize, value: u32) {
        let Some((register, unit)) = self.look_up(address & !3) else {
            return;
        };
        self.with(|chip, access| {
            let name = || format!("{}.{}", register.peripheral, register.name);
            if !register.writable {
                return access.broken(Rule::ReadOnly, name());
            }
            if !is_data(&register) {
                // 16-bit registers of a timer may be written as such (RM0440, 30.5).
                let halves = width == 2 && matches!(unit, Unit::Tim2 | Unit::Tim3);
                if width != 4 && !halves {
                    access.broken(Rule::AccessWidth, format!("{}: {width} bytes", name()));
                }
                let before = match unit {
                    Unit::Adc12Common => chip.adc1.common.0,
                    _ => chip.unit(unit).peek(&register),
                };
                let changed = (before ^ value) & !register.bits;
                if changed != 0 {
                    access.broken(Rule::ReservedBit, format!("{}: bits {changed:#x}", name()));
                }
            } else if matches!(unit, Unit::Spi(_)) && width != 1 {
                let detail = format!("{}.dr: two bytes in one write", register.peripheral);
                access.broken(Rule::AccessWidth, detail);
            }
            match unit {
                Unit::Adc12Common => adc::write_common(&mut chip.adc1, &register, value, access),
                Unit::Crc if is_data(&register) => chip.crc.write_data(value, width, access),
                _ => chip.unit(unit).write(&register, value, access),
            }
            chip.watch_clocks(unit, access);
            chip.watch_dma(access);
        });
        if unit == Unit::Rcc && register.name.contains("rstr") {
            registers::set_back(register.name, value)
                .into_iter()
                .for_each(|unit| self.set_back(unit));
        }
        self.settle();
    }

    /// The clock controller resets a peripheral. The watchdog and the clock controller itself have no such bit.
    fn set_back(&mut self, unit: Unit) {
        match unit {
            Unit::Pwr => self.pwr = Pwr::after_reset(self.pwr.supply_v),
            Unit::Flash => self.flash = Flash::after_reset(self.start, self.around.flash.clone()),
            Unit::Gpio(port) => self.gpio[port] = Gpio::after_reset(port),
            Unit::Syscfg => self.syscfg = Syscfg::after_reset(),
            Unit::Tim2 => self.tim2 = Timer::after_reset("TIM2", 32),
            Unit::Tim3 => self.tim3 = Timer::after_reset("TIM3", 16),
            Unit::Spi(index) => self.spi[index] = Spi::after_reset(SPI[index]),
            Unit::Dma1 => self.dma1 = Dma::after_reset(),
            Unit::Crc => self.crc = Crc::after_reset(),
            Unit::Usart1 => self.usart1 = Usart::after_reset(),
            Unit::Adc1 | Unit::Adc12Common => self.adc1 = Adc::after_reset(),
            _ => {}
        }
    }

    /// Clock, regulator and flash must fit one another after each change of one of them.
    fn watch_clocks(&mut self, unit: Unit, access: &mut Access) {
        self.rcc.watchdog_runs = self.iwdg.runs();
        self.tim16.oscillates = self.iwdg.runs();
        if unit == Unit::Pwr {
            let level = self.flash.options().bor_lev();
            self.pwr.check_warning(level, access);
        }
        if !matches!(unit, Unit::Rcc | Unit::Pwr | Unit::Flash) {
            return;
        }
        access.clocks = self.rcc.clocks();
        let hz = access.clocks.hclk_hz;
        let (fastest_hz, a_state_hz) = self.pwr.limits_hz();
        if hz > fastest_hz {
            let detail = format!("{hz} Hz, the regulator's range allows {fastest_hz} Hz");
            access.broken(Rule::VoltageRange, detail);
        }
        let states = u32::from(self.flash.acr().latency().to_bits());
        if hz > (states + 1) * a_state_hz {
            let detail = format!("{states} wait states at {hz} Hz");
            access.broken(Rule::FlashLatency, detail);
        }
    }

    /// A read of bank 2, and how long it has to wait.
    pub fn read_bank2(&mut self, offset: u32, width: usize) -> u32 {
        // Read while write: the bank answers when it is done (RM0440, 5.3.4).
        let until = self.flash.busy_until();
        if until > self.now {
            self.advance_to(until);
        }
        let mut bytes = [0; 4];
        self.flash.read_bank2(offset, &mut bytes[..width]);
        u32::from_le_bytes(bytes)
    }

    /// A store into bank 2.
    pub fn write_bank2(&mut self, offset: u32, width: usize, value: u32) {
        self.with(|chip, access| chip.flash.write_bank2(offset, value, width, access));
        self.settle();
    }
}

/// Registers whose reads and writes move data, in a width of the data's own.
fn is_data(register: &Register) -> bool {
    matches!(
        register.name,
        "dr16" | "dr32" | "dr8" | "rdr" | "tdr" | "dr"
    )
}
