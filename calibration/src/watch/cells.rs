//! Which quarters of a tooth have been seen: a set of cells that share bits.

/// A set of cells, a bit each. Of those that are new as many are taken for known as the set is full.
#[derive(Clone, Debug)]
pub(crate) struct Cells<const WORDS: usize>([u32; WORDS]);

impl<const WORDS: usize> Cells<WORDS> {
    const IS_POWER: () = assert!(WORDS.is_power_of_two() && WORDS > 1);
    /// None.
    pub const EMPTY: Self = Self([0; WORDS]);

    /// None any more.
    pub fn clear(&mut self) {
        self.0.fill(0);
    }

    /// Notes a cell; whether it was not known.
    pub fn is_new(&mut self, [x, y]: [i32; 2]) -> bool {
        const { Self::IS_POWER };
        // Fibonacci hashing (Knuth, volume 3, section 6.4), a multiplier for each direction.
        let hash = x
            .wrapping_mul(0x9E37_79B1_u32.cast_signed())
            .wrapping_add(y.wrapping_mul(0x85EB_CA77_u32.cast_signed()))
            .cast_unsigned();
        let mixed = (hash ^ hash >> 15).wrapping_mul(0x2C1B_3C6D);
        let bit = mixed >> (32 - 5 - WORDS.trailing_zeros());
        let Some(word) = self.0.get_mut(bit as usize / 32) else {
            return false;
        };
        let mask = 1 << (bit % 32);
        let is_new = *word & mask == 0;
        *word |= mask;
        is_new
    }
}
