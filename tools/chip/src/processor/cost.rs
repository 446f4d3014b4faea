//! Cycles of a block of instructions: ARM's tables, as `tools/thumb` has them, and the wait states of its fetches where they are asked for.

use super::fetch::Fetch;
use thumb::{Instruction, REFILL, cost, decode};

/// Blocks that were met, by their address.
pub struct Costs {
    base: u32,
    code: Vec<u8>,
    /// Bytes and cycles of the block that begins at each halfword.
    known: Vec<(u16, u16)>,
    /// Where the block before ended.
    end: u32,
    fetch: Fetch,
}

impl Costs {
    /// For code at `base`.
    pub fn new(base: u32, code: Vec<u8>) -> Self {
        Self {
            base,
            known: vec![(0, 0); code.len() / 2],
            code,
            end: 0,
            fetch: Fetch::default(),
        }
    }

    /// Cycles of the block at `address`, and of getting there if the block before did not lead straight to it.
    ///
    /// `states` are the flash's wait states; 0 leaves them out.
    pub fn block(&mut self, address: u32, bytes: u32, states: u32) -> u32 {
        let refill = if address == self.end { 0 } else { REFILL };
        self.end = address.wrapping_add(bytes);
        let place = (address.wrapping_sub(self.base) / 2) as usize;
        let cycles = match self.known.get(place) {
            Some((known, cycles)) if u32::from(*known) == bytes => u32::from(*cycles),
            Some(_) => {
                let cycles = self.count(address, bytes);
                self.known[place] = (bytes as u16, cycles as u16);
                cycles
            }
            // Code elsewhere: a cycle each instruction of two bytes.
            None => bytes / 2,
        };
        match states {
            0 => cycles + refill,
            _ => cycles + refill + self.fetch.block(address, bytes, cycles, states),
        }
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
        let bytes = code.iter().flat_map(|half| half.to_le_bytes()).collect();
        let mut costs = Costs::new(0x100, bytes);
        assert_eq!(costs.block(0x100, 4, 0), 3 + REFILL);
        assert_eq!(costs.block(0x104, 2, 0), 1);
        assert_eq!(costs.block(0x104, 2, 0), 1 + REFILL);
        assert_eq!(costs.block(0x2000_0000, 4, 0), 2 + REFILL);
    }
}
