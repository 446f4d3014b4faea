//! Cycles of a block of instructions: ARM's tables, as `tools/thumb` has them, and the wait states of its fetches where they are asked for.

use super::fetch::Fetch;
use thumb::{Instruction, REFILL, cost, decode};

/// Blocks that were met, by their address.
pub struct Costs {
    flash: Region,
    ccm: Option<Region>,
    /// Where the block before ended.
    end: u32,
    fetch: Fetch,
}

/// Memory that holds code.
struct Region {
    base: u32,
    code: Vec<u8>,
    /// Bytes and cycles of the block that begins at each halfword.
    known: Vec<(u16, u16)>,
}

impl Costs {
    /// For code in flash at `base`.
    pub fn new(base: u32, code: &[u8]) -> Self {
        Self {
            flash: Region::new(base, code.to_vec()),
            ccm: None,
            end: 0,
            fetch: Fetch::default(),
        }
    }

    /// Another bank lies at `base` now, or the one that does has changed.
    pub fn flash_changed(&mut self, base: u32, code: &[u8]) {
        self.flash = Region::new(base, code.to_vec());
        self.fetch = Fetch::default();
    }

    /// Whether the code in the CCM RAM is known.
    pub fn knows_ccm(&self) -> bool {
        self.ccm.is_some()
    }

    /// The code in the CCM RAM, which never waits for its fetches.
    pub fn learn_ccm(&mut self, base: u32, code: Vec<u8>) {
        self.ccm = Some(Region::new(base, code));
    }

    /// After a reset another image may be there.
    pub fn forget_ccm(&mut self) {
        self.ccm = None;
    }

    /// Cycles of the block at `address`, and of getting there if the block before did not lead straight to it.
    ///
    /// `states` are the flash's wait states; 0 leaves them out.
    pub fn block(&mut self, address: u32, bytes: u32, states: u32) -> u32 {
        let refill = if address == self.end { 0 } else { REFILL };
        self.end = address.wrapping_add(bytes);
        if let Some(cycles) = self.flash.block(address, bytes) {
            let waits = match states {
                0 => 0,
                _ => self.fetch.block(address, bytes, cycles, states),
            };
            return cycles + refill + waits;
        }
        let in_ccm = self.ccm.as_mut().and_then(|ccm| ccm.block(address, bytes));
        // Code elsewhere: a cycle each instruction of two bytes.
        refill + in_ccm.unwrap_or(bytes / 2)
    }
}

impl Region {
    fn new(base: u32, code: Vec<u8>) -> Self {
        let known = vec![(0, 0); code.len() / 2];
        Self { base, code, known }
    }

    /// Cycles of a block; none if it is not here.
    fn block(&mut self, address: u32, bytes: u32) -> Option<u32> {
        let place = (address.wrapping_sub(self.base) / 2) as usize;
        let (known, cycles) = *self.known.get(place)?;
        if u32::from(known) == bytes {
            return Some(u32::from(cycles));
        }
        let cycles = self.count(address, bytes);
        self.known[place] = (bytes as u16, cycles as u16);
        Some(cycles)
    }

    fn count(&self, address: u32, bytes: u32) -> u32 {
        let first = (address - self.base) as usize;
        let end = (first + bytes as usize).min(self.code.len());
        let (mut at, mut sum) = (first, 0);
        let mut before: Option<Instruction> = None;
        while at + 2 <= end {
            let instruction = decode(&self.code[at..]);
            sum += cost(before.as_ref(), &instruction);
            at += instruction.size as usize;
            before = Some(instruction);
        }
        sum
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_block_costs_its_table_and_a_jump_to_it_the_refill() {
        // ldr r0,[r1]; ldr r1,[r2]; nop
        let code = [0x6808u16, 0x6811, 0xBF00];
        let bytes: Vec<u8> = code.iter().flat_map(|half| half.to_le_bytes()).collect();
        let mut costs = Costs::new(0x100, &bytes);
        assert_eq!(costs.block(0x100, 4, 0), 3 + REFILL);
        assert_eq!(costs.block(0x104, 2, 0), 1);
        assert_eq!(costs.block(0x104, 2, 0), 1 + REFILL);
        assert_eq!(costs.block(0x2000_0000, 4, 0), 2 + REFILL);
        costs.learn_ccm(0x1000_0000, bytes);
        assert_eq!(costs.block(0x1000_0000, 4, 4), 3 + REFILL);
    }
}
