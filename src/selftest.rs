//! What a board tests of itself, as arithmetic on values: the board's own files read and write its registers and memory.

/// Words of memory that lose what they hold.
pub trait Words {
    /// How many.
    fn count(&self) -> usize;
    /// One of them, as the memory gives it.
    fn read(&self, index: usize) -> u32;
    /// Writes one.
    fn write(&mut self, index: usize, word: u32);
}

/// Words that are written in turn with their opposites: all bits alike, and neighbours different, so that no two bits of a word always agree.
const PATTERNS: [u32; 2] = [0x0000_0000, 0x5555_5555];

/// March test C- (van de Goor, "Using March Tests to Test SRAMs", IEEE Design & Test 10(1), 1993): finds bits that are stuck or do not
/// change, addresses that mean the same place or none, and bits that change with another. Ten accesses a word and pattern.
///
/// # Errors
/// The index of a word that did not keep what was written.
pub fn march(memory: &mut impl Words) -> Result<(), usize> {
    PATTERNS.iter().try_for_each(|pattern| {
        let (zeros, ones) = (*pattern, !*pattern);
        let count = memory.count();
        for index in 0..count {
            memory.write(index, zeros);
        }
        for index in 0..count {
            turn(memory, index, zeros, ones)?;
        }
        for index in 0..count {
            turn(memory, index, ones, zeros)?;
        }
        for index in (0..count).rev() {
            turn(memory, index, zeros, ones)?;
        }
        for index in (0..count).rev() {
            turn(memory, index, ones, zeros)?;
        }
        (0..count).try_for_each(|index| expect(memory, index, zeros))
    })
}

fn turn(memory: &mut impl Words, index: usize, from: u32, to: u32) -> Result<(), usize> {
    expect(memory, index, from)?;
    memory.write(index, to);
    Ok(())
}

fn expect(memory: &impl Words, index: usize, word: u32) -> Result<(), usize> {
    match memory.read(index) == word {
        true => Ok(()),
        false => Err(index),
    }
}

/// Pulses that answer others one by one, and how many of them were missing so far: each conversion that is started is answered by a pulse of
/// BUSY.
#[derive(Clone, Copy, Debug, Default)]
pub struct Answers {
    /// What was asked less what was answered, modulo 2^16, at the last look.
    seen: u16,
    missing: i32,
}

impl Answers {
    /// Both counts modulo 2^16, when the newest pulse should have been there. How many are missing since both counts were zero; negative:
    /// there were more than were asked for. To be called before 2^15 more are missing.
    pub fn look(&mut self, asked: u16, answered: u16) -> i32 {
        let now = asked.wrapping_sub(answered);
        let more = now.wrapping_sub(self.seen).cast_signed();
        (self.seen, self.missing) = (now, self.missing.saturating_add(more.into()));
        self.missing
    }
}

/// Frequency of a clock, hertz, by a 16-bit counter of `counter_hz` that was captured twice, `periods` of that clock apart. None if both
/// captures are the same.
pub const fn captured_hz(captures: [u16; 2], periods: u32, counter_hz: u32) -> Option<u32> {
    let counts = captures[1].wrapping_sub(captures[0]) as u64;
    match counts {
        0 => None,
        _ => Some((periods as u64 * counter_hz as u64 / counts) as u32),
    }
}

#[cfg(test)]
mod tests {
    extern crate std;
    use super::*;
    use std::vec;
    use std::vec::Vec;

    #[test]
    fn missing_answers_add_up_over_both_counters_ends() {
        let mut answers = Answers::default();
        let (mut asked, mut answered) = (0u16, 0u16);
        let mut expected = 0;
        for (more, missing) in [
            (2000, 0),
            (40_000, 3),
            (30_000, 0),
            (30_000, 30_000),
            (60_000, 30_000),
            (5, -1),
            (40_000, 30_000),
        ] {
            asked = asked.wrapping_add(more);
            answered = answered.wrapping_add((i32::from(more) - missing) as u16);
            expected += missing;
            assert_eq!(answers.look(asked, answered), expected);
        }
    }

    /// Memory with one flaw.
    struct Flawed<F> {
        words: Vec<u32>,
        flaw: F,
    }

    impl<F: Fn(&mut Vec<u32>, usize, u32)> Words for Flawed<F> {
        fn count(&self) -> usize {
            self.words.len()
        }

        fn read(&self, index: usize) -> u32 {
            self.words[index]
        }

        fn write(&mut self, index: usize, word: u32) {
            (self.flaw)(&mut self.words, index, word);
        }
    }

    fn tested(flaw: impl Fn(&mut Vec<u32>, usize, u32)) -> Result<(), usize> {
        let words = vec![0xDEAD_BEEF; 64];
        march(&mut Flawed { words, flaw })
    }

    #[test]
    fn sound_memory_passes_and_each_kind_of_flaw_is_found() {
        assert_eq!(tested(|words, index, word| words[index] = word), Ok(()));
        for bit in [0, 7, 31] {
            for stuck in [0, 1 << bit] {
                let found = tested(|words, index, word| {
                    let flawed = index == 9;
                    words[index] = if flawed {
                        word & !(1 << bit) | stuck
                    } else {
                        word
                    };
                });
                assert_eq!(found, Err(9), "bit {bit} stuck at {stuck}");
            }
        }
        // Two addresses that are the same word.
        let same = |words: &mut Vec<u32>, index: usize, word| words[index & !16] = word;
        assert!(tested(same).is_err());
        // A bit that changes when another rises, and one that follows another of its own word.
        assert!(
            tested(|words, index, word| {
                if index == 40 && word & 1 > words[40] & 1 {
                    words[3] ^= 1 << 5;
                }
                words[index] = word;
            })
            .is_err()
        );
        assert!(
            tested(|words, index, word| {
                words[index] = if index == 5 {
                    word & !2 | (word & 1) << 1
                } else {
                    word
                };
            })
            .is_err()
        );
    }

    #[test]
    fn a_clock_is_known_by_two_captures_also_over_the_counters_end() {
        // Eight periods of 32 kHz are 42,500 cycles of 170 MHz.
        for first in [0u16, 30_000, u16::MAX] {
            let captures = [first, first.wrapping_add(42_500)];
            assert_eq!(captured_hz(captures, 8, 170_000_000), Some(32_000));
        }
        assert_eq!(captured_hz([7, 7], 8, 170_000_000), None);
    }
}
