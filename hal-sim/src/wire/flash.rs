//! A NOR flash like the STM32G4's: pages of 2 KiB, double words of 8 bytes written once, bits that only fall, a power cut at any step.
//!
//! A step is one byte of a program or one eighth of a page's erase. A cut leaves the double word or page it falls into undefined; with
//! `ecc` a torn double word cannot be read at all, as on the part.

use effects::random::{ChaCha8Rng, SeedableRng, uniform};
use embedded_storage::nor_flash::{
    ErrorType, NorFlash, NorFlashError, NorFlashErrorKind, ReadNorFlash, check_erase, check_read,
    check_write,
};

/// Smallest erase.
pub const PAGE_BYTES: usize = 2048;
/// Smallest write.
pub const WORD_BYTES: usize = 8;
const ERASE_STEPS: usize = 8;
const ERASED: u8 = 0xFF;

/// What the flash says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum FlashError {
    /// Out of bounds or not aligned.
    Arguments(NorFlashErrorKind),
    /// A double word was written twice without an erase between.
    WrittenTwice,
    /// A double word whose check bits do not match.
    Uncorrectable,
    /// There is no power.
    Off,
    /// The operation did not end well (a fault put on it).
    Failed,
}

impl NorFlashError for FlashError {
    fn kind(&self) -> NorFlashErrorKind {
        match self {
            Self::Arguments(kind) => *kind,
            _ => NorFlashErrorKind::Other,
        }
    }
}

/// The flash. `&mut` of it is a flash as well, so that its owner can look at it afterwards.
#[derive(Clone, Debug)]
pub struct Flash {
    bytes: Vec<u8>,
    /// A double word: programmed since its last erase, and torn.
    programmed: Vec<bool>,
    torn: Vec<bool>,
    ecc: bool,
    powered: bool,
    worn: bool,
    steps_left: Option<u64>,
    steps: u64,
    forced: u64,
    rng: ChaCha8Rng,
}

/// What a flash holds: its bytes, and of each double word whether it has been programmed since its last erase and whether it is torn.
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct Contents {
    /// The bytes.
    pub bytes: Vec<u8>,
    /// Whether each double word is programmed.
    pub programmed: Vec<bool>,
    /// Whether each double word is torn.
    pub torn: Vec<bool>,
}

impl Flash {
    /// What it holds.
    pub fn contents(&self) -> Contents {
        Contents {
            bytes: self.bytes.clone(),
            programmed: self.programmed.clone(),
            torn: self.torn.clone(),
        }
    }

    /// Makes it hold what another one of the same size does.
    ///
    /// # Panics
    /// The sizes differ.
    pub fn take_over(&mut self, contents: Contents) {
        assert_eq!(
            [
                contents.bytes.len(),
                contents.programmed.len(),
                contents.torn.len()
            ],
            [self.bytes.len(), self.programmed.len(), self.torn.len()],
            "the contents of a flash of another size"
        );
        self.bytes = contents.bytes;
        self.programmed = contents.programmed;
        self.torn = contents.torn;
    }

    /// Erased flash of so many pages.
    pub fn new(pages: usize, seed: u64) -> Self {
        let words = pages * PAGE_BYTES / WORD_BYTES;
        Self {
            bytes: vec![ERASED; pages * PAGE_BYTES],
            programmed: vec![false; words],
            torn: vec![false; words],
            ecc: true,
            powered: true,
            worn: false,
            steps_left: None,
            steps: 0,
            forced: 0,
            rng: ChaCha8Rng::seed_from_u64(seed),
        }
    }

    /// Torn double words read as whatever bits they hold, without an error.
    pub fn without_ecc(mut self) -> Self {
        self.ecc = false;
        self
    }

    /// From now on nothing erases.
    pub fn wear_out(&mut self) {
        self.worn = true;
    }

    /// Cuts the power after so many steps from now.
    pub fn cut_after(&mut self, steps: u64) {
        self.steps_left = Some(steps);
    }

    /// Power comes back, and stays.
    pub fn power_up(&mut self) {
        self.powered = true;
        self.steps_left = None;
    }

    /// Steps done so far: what a cut's place is counted in.
    pub fn steps(&self) -> u64 {
        self.steps
    }

    /// Overwrites bytes without any rule: for records that another firmware left, and for decay.
    pub fn force(&mut self, offset: usize, bytes: &[u8]) {
        self.forced += 1;
        self.bytes[offset..][..bytes.len()].copy_from_slice(bytes);
        for word in offset / WORD_BYTES..(offset + bytes.len()).div_ceil(WORD_BYTES) {
            self.programmed[word] = true;
            self.torn[word] = false;
        }
    }

    /// How often [`Flash::force`] was called: who keeps a copy of this flash sees by it that the copy is out of date.
    pub fn forced(&self) -> u64 {
        self.forced
    }

    /// The bytes as they are.
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Whether each double word is torn.
    pub fn torn(&self) -> &[bool] {
        &self.torn
    }

    /// Uses one step; false when the power has just gone.
    fn step(&mut self) -> bool {
        if self.steps_left == Some(0) {
            self.powered = false;
            return false;
        }
        self.steps_left = self.steps_left.map(|left| left - 1);
        self.steps += 1;
        true
    }

    fn on(&self) -> Result<(), FlashError> {
        if self.powered {
            Ok(())
        } else {
            Err(FlashError::Off)
        }
    }

    /// Any of the bits that differ may or may not have changed.
    fn undefined(&mut self, from: u8, to: u8) -> u8 {
        let mask = uniform(&mut self.rng, 0.0, 256.0) as u8;
        (from & mask) | (to & !mask)
    }

    fn program_word(&mut self, word: usize, data: &[u8]) -> Result<(), FlashError> {
        if self.programmed[word] {
            return Err(FlashError::WrittenTwice);
        }
        for (index, &byte) in data.iter().enumerate() {
            let place = word * WORD_BYTES + index;
            if !self.step() {
                // Cut before the first byte: the word is untouched.
                if index > 0 {
                    self.bytes[place] = self.undefined(ERASED, byte);
                    self.programmed[word] = true;
                    self.torn[word] = true;
                }
                return Err(FlashError::Off);
            }
            self.bytes[place] &= byte;
        }
        self.programmed[word] = true;
        Ok(())
    }

    fn erase_page(&mut self, page: usize) -> Result<(), FlashError> {
        for step in 0..ERASE_STEPS {
            if !self.step() {
                if step > 0 {
                    self.leave_half_erased(page);
                }
                return Err(FlashError::Off);
            }
        }
        let words = PAGE_BYTES / WORD_BYTES;
        self.bytes[page * PAGE_BYTES..][..PAGE_BYTES].fill(ERASED);
        self.programmed[page * words..][..words].fill(false);
        self.torn[page * words..][..words].fill(false);
        Ok(())
    }

    /// Words that read as they did, as erased, or as neither.
    fn leave_half_erased(&mut self, page: usize) {
        let words = PAGE_BYTES / WORD_BYTES;
        for word in page * words..(page + 1) * words {
            let fate = uniform(&mut self.rng, 0.0, 3.0) as u8;
            for place in word * WORD_BYTES..(word + 1) * WORD_BYTES {
                self.bytes[place] = match fate {
                    0 => self.bytes[place],
                    1 => ERASED,
                    _ => self.undefined(self.bytes[place], ERASED),
                };
            }
            self.torn[word] = self.programmed[word] && fate == 2;
            // Not to be written before a whole erase, whatever it reads as.
            self.programmed[word] = true;
        }
    }
}

impl ErrorType for Flash {
    type Error = FlashError;
}

impl ReadNorFlash for Flash {
    const READ_SIZE: usize = 1;

    fn read(&mut self, offset: u32, bytes: &mut [u8]) -> Result<(), FlashError> {
        self.on()?;
        check_read(self, offset, bytes.len()).map_err(FlashError::Arguments)?;
        let start = offset as usize;
        let mut words = start / WORD_BYTES..(start + bytes.len()).div_ceil(WORD_BYTES);
        if self.ecc && words.any(|word| self.torn[word]) {
            return Err(FlashError::Uncorrectable);
        }
        bytes.copy_from_slice(&self.bytes[start..][..bytes.len()]);
        Ok(())
    }

    fn capacity(&self) -> usize {
        self.bytes.len()
    }
}

impl NorFlash for Flash {
    const WRITE_SIZE: usize = WORD_BYTES;
    const ERASE_SIZE: usize = PAGE_BYTES;

    fn erase(&mut self, from: u32, to: u32) -> Result<(), FlashError> {
        self.on()?;
        check_erase(self, from, to).map_err(FlashError::Arguments)?;
        if self.worn {
            return Err(FlashError::Failed);
        }
        (from as usize / PAGE_BYTES..to as usize / PAGE_BYTES)
            .try_for_each(|page| self.erase_page(page))
    }

    fn write(&mut self, offset: u32, bytes: &[u8]) -> Result<(), FlashError> {
        self.on()?;
        check_write(self, offset, bytes.len()).map_err(FlashError::Arguments)?;
        let first = offset as usize / WORD_BYTES;
        let mut words = bytes.chunks_exact(WORD_BYTES).enumerate();
        words.try_for_each(|(index, data)| self.program_word(first + index, data))
    }
}
