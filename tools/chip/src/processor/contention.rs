//! How long DMA may hold the processor up, at worst, where both want the same bus.
//!
//! The bus matrix gives each master one access after the other, by turns (RM0440, 2.1; AN2548, 2.2). So an access of the processor's waits for
//! one of DMA's at most: a cycle of arbitration, and that access. Which accesses meet is not known; every one that could is counted.

/// Cycles that a byte holds up which DMA puts into RAM or takes from it: one of arbitration, one of the access (AN4031, table 5).
const RAM: u32 = 2;
/// Cycles that an access holds up which DMA makes to a bus's data register: one of arbitration, one of the matrix, two of the slow bus (AN4031,
/// table 4).
const REGISTER: u64 = 4;
/// Where the processor goes by the same port of the matrix as DMA to the data registers: both slow buses, and the fast one before them.
const PORT: std::ops::Range<u32> = 0x4000_0000..0x4800_0000;

/// SRAM2 has a port of its own (RM0440, 2.1). What else lies there no sampling interrupt touches: the record of a fault (`memory.x`, .uninit).
const SRAM2: std::ops::Range<u32> = 0x2001_4000..0x2001_8000;
/// SRAM1 and SRAM2.
const ALL_RAM: std::ops::Range<u32> = 0x2000_0000..0x2001_8000;

/// Bytes that DMA has moved.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Moved {
    /// Taken from flash.
    pub from_flash: u32,
    /// Put into RAM, or taken from SRAM1.
    pub in_ram: u32,
}

impl Moved {
    /// A byte that was sent from here.
    pub fn note_sent(&mut self, memory: u32) {
        match () {
            () if SRAM2.contains(&memory) => {}
            () if ALL_RAM.contains(&memory) => self.in_ram += 1,
            () => self.from_flash += 1,
        }
    }
}

/// Cycles that these bytes may hold up a block of instructions: `in_flash` says whether it is fetched from there, with so many wait states.
pub fn of_block(moved: Moved, in_flash: bool, states: u32) -> u32 {
    let fetches = if in_flash { moved.from_flash } else { 0 };
    // A fetch waits for one of arbitration and for DMA's own, which no cache serves.
    RAM * moved.in_ram + (states + 2) * fetches
}

/// Cycles that an access to a register may be held up while DMA serves the buses.
pub fn of_access(address: u32, serves: bool) -> u64 {
    match serves && PORT.contains(&address) {
        true => REGISTER,
        false => 0,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_shares_no_bus_is_not_held_up() {
        let mut moved = Moved::default();
        // Two bytes from SRAM1, one from SRAM2, three from flash.
        let places = [0x2000_0000, 0x2001_3FFF, 0x2001_4000];
        let flash = [0x0800_0000; 3];
        places
            .into_iter()
            .chain(flash)
            .for_each(|place| moved.note_sent(place));
        assert_eq!(of_block(moved, false, 4), 2 * RAM);
        assert_eq!(of_block(moved, true, 4), 2 * RAM + 3 * 6);
        assert_eq!(of_block(Moved::default(), true, 4), 0);
        // TIM2, and a port of pins.
        assert_eq!(of_access(0x4000_0024, true), REGISTER);
        assert_eq!(of_access(0x4000_0024, false), 0);
        assert_eq!(of_access(0x4800_0010, true), 0);
    }
}
