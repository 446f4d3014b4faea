//! The chip's own tables, as stm32-metapac carries them: which register lies where, which bits it has, which clock it wants.

use crate::peripheral::Unit;
use std::sync::LazyLock;
use stm32_metapac::metadata::ir::{Access, Array, BitOffset, Block, BlockItemInner, FieldSet, IR};
use stm32_metapac::metadata::{METADATA, Peripheral};

/// A register of the chip.
#[derive(Clone, Copy, Debug)]
pub struct Register {
    /// Its peripheral's part of the model; none: the model has none.
    pub unit: Option<Unit>,
    /// Its peripheral's name.
    pub peripheral: &'static str,
    /// Its name.
    pub name: &'static str,
    /// Its place in an array of registers.
    pub index: u32,
    /// Its offset from the peripheral's base, bytes.
    pub offset: u32,
    /// Bits that mean something.
    pub bits: u32,
    /// Whether it can be written.
    pub writable: bool,
    /// The bit that switches its clock on: name of the register and the bit.
    pub clock: Option<(&'static str, u32)>,
}

/// Addresses that have peripherals, `[first, end)`.
const WINDOWS: [(u32, u32); 4] = [
    (0x4000_0000, 0x4003_0000),
    (0x4800_0000, 0x4800_2000),
    (0x5000_0000, 0x5006_1000),
    (0xE004_2000, 0xE004_2400),
];

/// R1MODE is bit 8 (RM0440, 6.4.21; ST's stm32g474xx.h). stm32-metapac 21 has it at bit 0.
pub const NOT_BOOSTED: u32 = 1 << 8;
/// Where stm32-metapac 21 is wrong: peripheral, register, its bits.
const CORRECTIONS: [(&str, &str, u32); 1] = [("PWR", "cr5", NOT_BOOSTED)];

/// All registers, by address.
pub struct Map {
    registers: Vec<Register>,
    /// For each window, the number of the register + 1 at each word.
    windows: [Vec<u16>; WINDOWS.len()],
}

/// The STM32G474RE's. The tables are searched by name, which takes a tenth of a second.
pub static MAP: LazyLock<Map> = LazyLock::new(Map::new);

impl Map {
    fn new() -> Self {
        let mut map = Self {
            registers: Vec::new(),
            windows: WINDOWS.map(|(first, end)| vec![0; ((end - first) / 4) as usize]),
        };
        for peripheral in METADATA.peripherals {
            map.add(peripheral);
        }
        map
    }

    fn add(&mut self, peripheral: &'static Peripheral) {
        let Some(tables) = &peripheral.registers else {
            return;
        };
        let base = peripheral.address as u32;
        let clock = peripheral.rcc.as_ref().and_then(|rcc| rcc.enable.as_ref());
        let clock = clock.map(|enable| {
            let bit = bit_of(enable.register, enable.field);
            (enable.register, bit)
        });
        let head = Register {
            unit: Unit::named(peripheral.name),
            peripheral: peripheral.name,
            name: "",
            index: 0,
            offset: 0,
            bits: 0,
            writable: true,
            clock,
        };
        let mut block = find_block(tables.ir, tables.block);
        while let Some(now) = block {
            self.add_block(base, now, tables.ir, head);
            self.add_inner_blocks(base, now, tables.ir, head);
            block = now.extends.and_then(|name| find_block(tables.ir, name));
        }
    }

    /// Blocks within a block, as the channels of a DMA controller: the register's index is the block's.
    fn add_inner_blocks(
        &mut self,
        base: u32,
        block: &'static Block,
        ir: &'static IR,
        head: Register,
    ) {
        for item in block.items {
            let BlockItemInner::Block(inner) = &item.inner else {
                continue;
            };
            let Some(inner) = find_block(ir, inner.block) else {
                continue;
            };
            for (index, first) in offsets(item.byte_offset, item.array.as_ref()) {
                let head = Register {
                    index,
                    offset: first,
                    ..head
                };
                self.add_block(base, inner, ir, head);
            }
        }
    }

    fn add_block(&mut self, base: u32, block: &'static Block, ir: &'static IR, head: Register) {
        for item in block.items {
            let BlockItemInner::Register(register) = &item.inner else {
                continue;
            };
            let bits = register.fieldset.and_then(|name| find_fieldset(ir, name));
            let bits = bits.map_or(u32::MAX, mask);
            let corrected = CORRECTIONS
                .iter()
                .find(|(peripheral, name, _)| *peripheral == head.peripheral && *name == item.name);
            let bits = corrected.map_or(bits, |(_, _, bits)| *bits);
            let first = head.offset + item.byte_offset;
            for (index, offset) in offsets(first, item.array.as_ref()) {
                let found = Register {
                    name: item.name,
                    index: head.index + index,
                    offset,
                    bits,
                    writable: register.access != Access::Read,
                    ..head
                };
                self.put(base + offset, found);
            }
        }
    }

    /// The first of several that share an address (input and output mode, 8 and 16 bits) is kept, with the bits of all.
    fn put(&mut self, address: u32, register: Register) {
        let Some(place) = place(address) else {
            return;
        };
        let slot = &mut self.windows[place.0][place.1];
        if *slot == 0 {
            self.registers.push(register);
            *slot = self.registers.len() as u16;
        } else {
            self.registers[usize::from(*slot) - 1].bits |= register.bits;
        }
    }

    /// The register that an address belongs to.
    pub fn find(&self, address: u32) -> Option<&Register> {
        let (window, word) = place(address)?;
        let number = self.windows[window][word].checked_sub(1)?;
        self.registers.get(usize::from(number))
    }
}

fn place(address: u32) -> Option<(usize, usize)> {
    let inside = |(first, end): &(u32, u32)| (*first..*end).contains(&address);
    let window = WINDOWS.iter().position(inside)?;
    Some((window, ((address - WINDOWS[window].0) / 4) as usize))
}

/// Whether an address can belong to a peripheral at all.
pub fn is_peripheral(address: u32) -> bool {
    place(address).is_some()
}

fn offsets(first: u32, array: Option<&Array>) -> Vec<(u32, u32)> {
    match array {
        None => vec![(0, first)],
        Some(Array::Regular(many)) => {
            let numbers = 0..many.len;
            numbers.map(|k| (k, first + k * many.stride)).collect()
        }
        Some(Array::Cursed(many)) => {
            let places = many.offsets.iter().zip(0..);
            places.map(|(offset, k)| (k, first + offset)).collect()
        }
    }
}

/// Tables write a block's name in capitals in one place and in small letters in another.
fn same(a: &str, b: &str) -> bool {
    let plain = |text: &str| text.replace('_', "").to_lowercase();
    plain(a) == plain(b)
}

fn find_block(ir: &'static IR, name: &str) -> Option<&'static Block> {
    ir.blocks.iter().find(|block| same(block.name, name))
}

fn find_fieldset(ir: &'static IR, name: &str) -> Option<&'static FieldSet> {
    ir.fieldsets.iter().find(|set| set.name == name)
}

/// All bits of a register that some field has.
fn mask(set: &'static FieldSet) -> u32 {
    let mut mask = 0;
    for field in set.fields {
        let starts = match &field.bit_offset {
            BitOffset::Regular(at) => vec![(at.offset, field.bit_size)],
            BitOffset::Cursed(at) => {
                let ranges = at.ranges.iter();
                ranges
                    .map(|r| (*r.start(), r.end() - r.start() + 1))
                    .collect()
            }
        };
        for (start, size) in starts {
            let one = ((1u64 << size) - 1) as u32;
            for (_, offset) in offsets(start, field.array.as_ref()) {
                mask |= one << offset;
            }
        }
    }
    mask
}

/// The bit of a field in the clock controller.
fn bit_of(register: &str, field: &str) -> u32 {
    let rcc = METADATA.peripherals.iter().find(|p| p.name == "RCC");
    let tables = rcc.and_then(|p| p.registers.as_ref());
    let sets = tables.map_or(&[][..], |tables| tables.ir.fieldsets);
    let set = sets.iter().find(|set| same(set.name, register));
    let fields = set.map_or(&[][..], |set| set.fields);
    let field = fields.iter().find(|known| same(known.name, field));
    match field.map(|field| &field.bit_offset) {
        Some(BitOffset::Regular(at)) => at.offset,
        _ => panic!("the chip's tables have no bit {field:?} in {register}"),
    }
}

/// Peripherals of the model that a write of this value to a reset register of the clock controller sets back.
pub fn set_back(register: &str, value: u32) -> Vec<Unit> {
    let resets = METADATA.peripherals.iter().filter_map(|peripheral| {
        let reset = peripheral.rcc.as_ref()?.reset.as_ref()?;
        let hit =
            same(reset.register, register) && value >> bit_of(reset.register, reset.field) & 1 == 1;
        Unit::named(peripheral.name).filter(|_| hit)
    });
    resets.collect()
}

/// Number of a peripheral's DMA request line ("SPI1", "RX").
pub fn dma_request(peripheral: &str, signal: &str) -> u32 {
    let found = METADATA.peripherals.iter().find(|p| p.name == peripheral);
    let mut lines = found.map_or(&[][..], |p| p.dma_channels).iter();
    let line = lines.find(|line| line.signal == signal && line.dmamux == Some("DMAMUX1"));
    let number = line.and_then(|line| line.request);
    number.expect("the chip's tables have it")
}

/// Address of a peripheral.
pub fn address(peripheral: &str) -> u32 {
    let found = METADATA.peripherals.iter().find(|p| p.name == peripheral);
    found.expect("the chip's tables have it").address as u32
}

/// Number of an interrupt line.
pub fn interrupt(name: &str) -> u16 {
    let found = METADATA.interrupts.iter().find(|line| line.name == name);
    found.expect("the chip's tables name it").number as u16
}

/// Whether a pin ("PA5") has an alternate function of that number.
pub fn has_function(pin: &str, number: u8) -> bool {
    let pins = METADATA.peripherals.iter().flat_map(|p| p.pins);
    let mut of_pin = pins.filter(|known| known.pin == pin);
    of_pin.any(|known| known.af == Some(number))
}

/// Whether a pin's alternate function of that number is this peripheral's signal.
pub fn is_signal(pin: &str, number: u8, peripheral: &str, signal: &str) -> bool {
    let found = METADATA.peripherals.iter().find(|p| p.name == peripheral);
    let mut pins = found.map_or(&[][..], |p| p.pins).iter();
    pins.any(|known| known.pin == pin && known.signal == signal && known.af == Some(number))
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn registers_are_found_with_their_bits_and_clocks() {
        let map = &*MAP;
        let find = |address| *map.find(address).expect("a register");
        let cr = find(0x4002_1000);
        assert_eq!(
            (cr.peripheral, cr.name, cr.bits & 1 << 24),
            ("RCC", "cr", 1 << 24)
        );
        let moder = find(0x4800_0800);
        assert_eq!((moder.peripheral, moder.bits), ("GPIOC", u32::MAX));
        assert_eq!(moder.clock, Some(("AHB2ENR", 2)));
        let second = find(0x4800_0024);
        assert_eq!((second.name, second.index), ("afr", 1));
        assert_eq!(find(0x4000_0424).name, "cnt");
        assert_eq!(find(0xE004_2008).name, "apb1lfzr");
        // DMA1's channel 2: four registers, 20 bytes behind those of channel 1.
        let count = find(0x4002_0020);
        assert_eq!(
            (count.peripheral, count.name, count.index),
            ("DMA1", "ndtr", 1)
        );
        assert!(map.find(0x4000_0FFC).is_none());
        assert!(map.find(0x6000_0000).is_none());
    }

    #[test]
    fn a_reset_register_names_its_peripherals() {
        assert_eq!(set_back("apb2rstr", 1 << 12), [Unit::Spi(0)]);
        assert_eq!(set_back("apb2rstr", 0), []);
        assert_eq!(set_back("ahb2rstr", 1 << 2), [Unit::Gpio(2)]);
    }

    #[test]
    fn lines_and_functions_come_from_the_chips_tables() {
        assert_eq!(interrupt("EXTI9_5"), 23);
        assert_eq!(
            (dma_request("SPI1", "RX"), dma_request("SPI2", "TX")),
            (10, 13)
        );
        assert!(is_signal("PA5", 5, "SPI1", "SCK"));
        assert!(is_signal("PC6", 2, "TIM3", "CH1"));
        assert!(has_function("PA9", 7) && !has_function("PA9", 0));
    }
}
