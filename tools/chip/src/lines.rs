//! The lines of the board, as its README wires them: what the pins drive, and what the parts answer.

use crate::chip::Chip;
use crate::line_levels::Lines;
use crate::peripheral::gpio::{Drive, Gpio};
use crate::registers;
use crate::rule::{Findings, Rule};
use crate::time::{Ticks, to_ns};
use std::sync::LazyLock;

/// The alternate function that gives CONVST to the timer, from the chip's tables.
static CONVST_FUNCTION: LazyLock<u8> = LazyLock::new(|| {
    let is_timer = |function: &u8| registers::is_signal("PC6", *function, "TIM3", "CH1");
    (0..16).find(is_timer).expect("the chip has it")
});

/// The one that gives BUSY to the timer that counts its pulses.
static BUSY_FUNCTION: LazyLock<u8> = LazyLock::new(|| {
    let is_timer = |function: &u8| registers::is_signal("PC8", *function, "TIM8", "CH3");
    (0..16).find(is_timer).expect("the chip has it")
});

/// Port and number of a pin.
type Pin = (usize, u32);

const CONVST: Pin = (2, 6);
const RESET: Pin = (2, 7);
const BUSY: Pin = (2, 8);
const LAMP: Pin = (1, 2);
const MARK: Pin = (2, 9);
const SELECT: [Pin; 2] = [(0, 4), (1, 12)];
/// The converters' buses and the serial line: pin, peripheral, signal.
const BUS: [[(Pin, &str, &str); 3]; 2] = [
    [
        ((0, 5), "SPI1", "SCK"),
        ((0, 6), "SPI1", "MISO"),
        ((0, 7), "SPI1", "MOSI"),
    ],
    [
        ((1, 13), "SPI2", "SCK"),
        ((1, 14), "SPI2", "MISO"),
        ((1, 15), "SPI2", "MOSI"),
    ],
];
const SERIAL: [(Pin, &str, &str); 2] = [((0, 9), "USART1", "TX"), ((0, 10), "USART1", "RX")];
/// Shortest pulse of CONVST that the AD7606C takes (its data sheet, t_LP_CNV), nanoseconds.
const SHORTEST_NS: u64 = 10;

impl Lines {
    /// Brings every line up to date and tells the parts of what has changed.
    pub fn settle(chip: &mut Chip) {
        Self::settle_convst(chip);
        Self::settle_reset(chip);
        for index in 0..2 {
            Self::settle_select(chip, index);
        }
        let (port, pin) = LAMP;
        chip.around.lamp = chip.gpio[port].drive(pin) == Drive::Level(true);
        Self::settle_busy(chip);
        let high = chip.gpio[MARK.0].drive(MARK.1) == Drive::Pulled(true) && !chip.around.at_mark;
        set_line(chip, MARK, high);
        if let Some(recorder) = &mut chip.recorder {
            recorder.levels(chip.now, &chip.lines);
        }
    }

    fn settle_convst(chip: &mut Chip) {
        let own = chip.tim3.channel1(chip.now);
        let level = level_of(chip, CONVST, |function| {
            if function == *CONVST_FUNCTION {
                own
            } else {
                None
            }
        });
        let before = chip.lines.convst;
        if level.is_none() && before.is_some() {
            floats(chip, "CONVST");
        }
        let (was, is) = (before.unwrap_or(false), level.unwrap_or(false));
        if was && !is {
            let edge_ns = chip.gpio[CONVST.0].edge_ns(CONVST.1);
            let width_ns = to_ns(chip.now - chip.lines.convst_since);
            if width_ns < SHORTEST_NS + edge_ns {
                let detail = format!("{width_ns} ns with edges of {edge_ns} ns");
                chip.findings.add(Rule::ConvstWidth, chip.now, detail);
            }
        }
        if was != is {
            chip.lines.convst_since = chip.now;
            let drive = chip.gpio[CONVST.0].drive(CONVST.1);
            let by_timer = matches!(drive, Drive::Function(_));
            chip.around.convst(is, by_timer, chip.now);
        }
        chip.lines.convst = level;
    }

    fn settle_reset(chip: &mut Chip) {
        let level = level_of(chip, RESET, |_| None);
        let before = chip.lines.reset;
        if level.is_none() && before.is_some() {
            floats(chip, "RESET");
        }
        if level.unwrap_or(false) != before.unwrap_or(false) {
            chip.around.reset(level.unwrap_or(false), chip.now);
        }
        chip.lines.reset = level;
    }

    fn settle_select(chip: &mut Chip, index: usize) {
        let level = level_of(chip, SELECT[index], |_| None);
        let before = chip.lines.selected[index];
        if level.is_none() && before.is_some() {
            floats(chip, "a chip select");
        }
        let (was, is) = (before == Some(false), level == Some(false));
        if was != is {
            Self::check_bus(chip, index, is);
            chip.around.select(index, is, chip.now);
        }
        chip.lines.selected[index] = level;
    }

    fn check_bus(chip: &mut Chip, index: usize, selects: bool) {
        if chip.spi[index].busy() {
            let detail = "a chip select changes while a byte is under way";
            chip.findings.add(Rule::SpiSelect, chip.now, detail.into());
        }
        if selects && chip.spi[index].unread() > 0 {
            let detail = format!("{} bytes wait in the FIFO", chip.spi[index].unread());
            chip.findings.add(Rule::SpiStale, chip.now, detail);
        }
        if selects && !std::mem::replace(&mut chip.lines.bus_checked[index], true) {
            check_signals(&chip.gpio, &BUS[index], chip.now, &mut chip.findings);
        }
    }

    /// The serial line's pins, at the first byte.
    pub fn check_serial(&mut self, gpio: &[Gpio], now: Ticks, findings: &mut Findings) {
        if !std::mem::replace(&mut self.serial_checked, true) {
            check_signals(gpio, &SERIAL, now, findings);
        }
    }

    fn settle_busy(chip: &mut Chip) {
        let busy = chip.around.busy(chip.now);
        let (port, pin) = BUSY;
        set_line(chip, BUSY, busy);
        if busy != chip.lines.busy {
            chip.lines.busy = busy;
            if chip.syscfg.port(pin) == port {
                chip.exti.edge(pin, busy);
            }
            if chip.gpio[port].drive(pin) == Drive::Function(*BUSY_FUNCTION) {
                chip.tim8.edge(busy);
            }
        }
    }
}

/// What a part, or a resistor alone, makes of a line.
fn set_line(chip: &mut Chip, (port, pin): Pin, high: bool) {
    let lines = &mut chip.gpio[port].lines;
    *lines = *lines & !(1 << pin) | u32::from(high) << pin;
}

/// Level of a line; none if nothing drives or pulls it. `function` is what a peripheral drives.
fn level_of(chip: &Chip, pin: Pin, function: impl Fn(u8) -> Option<bool>) -> Option<bool> {
    let port = &chip.gpio[pin.0];
    match port.drive(pin.1) {
        Drive::Level(high) | Drive::Pulled(high) => Some(high),
        Drive::Function(number) => function(number).or(match port.pull(pin.1) {
            1 => Some(true),
            2 => Some(false),
            _ => None,
        }),
        Drive::Floating => None,
    }
}

fn floats(chip: &mut Chip, line: &str) {
    let detail = format!("{line} is neither driven nor pulled");
    chip.findings.add(Rule::FloatingLine, chip.now, detail);
}

fn check_signals(gpio: &[Gpio], pins: &[(Pin, &str, &str)], now: Ticks, findings: &mut Findings) {
    for ((port, pin), peripheral, signal) in pins {
        let name = format!("P{}{pin}", char::from(b'A' + *port as u8));
        let right = match gpio[*port].drive(*pin) {
            Drive::Function(number) => registers::is_signal(&name, number, peripheral, signal),
            _ => false,
        };
        if !right {
            let detail = format!("{name} is not {peripheral}'s {signal}");
            findings.add(Rule::AlternateFunction, now, detail);
        }
    }
}
