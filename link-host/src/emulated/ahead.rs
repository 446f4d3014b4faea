//! Instants answered before they come: most of the handing over between the two processes is saved, and each bit on the
//! wire stays what it would have been.

use super::shared::SharedRam;
use crate::memory::TargetMemory;
use anyhow::Result;
use courier_sensor::emulation::{
    AHEAD_BASE, AHEAD_BYTES, AHEAD_INSTANTS, AheadWord, ahead_instant, ahead_question,
};
use hal_sim::wire::ad7606c::Ad7606c;
use hal_sim::world::World;

/// Instants at which the board asked what was expected, before some are answered ahead.
const TRUST: u32 = 32;

/// What each chip was asked last, and the instants given.
#[derive(Default)]
pub struct Ahead {
    questions: [Vec<u8>; 2],
    /// Chips as they were before their transfer at each instant given.
    before: Vec<[Ad7606c; 2]>,
    /// Instants in a row at which the questions were those before.
    steady: u32,
}

impl Ahead {
    fn word(word: AheadWord) -> u32 {
        AHEAD_BASE + 4 * word as u32
    }

    /// A chip was asked for this at an instant; what was done ahead is undone.
    ///
    /// # Errors
    /// The memory cannot be reached.
    pub fn learn(
        &mut self,
        chip: usize,
        question: &[u8],
        world: &World,
        ram: &mut SharedRam,
    ) -> Result<()> {
        self.take_back(world, ram)?;
        let Some(known) = self.questions.get_mut(chip) else {
            return Ok(());
        };
        if known != question {
            self.steady = 0;
            known.clear();
            known.extend_from_slice(question);
        }
        Ok(())
    }

    /// Undoes what was done ahead and not taken.
    ///
    /// # Errors
    /// The memory cannot be reached.
    pub fn take_back(&mut self, world: &World, ram: &mut SharedRam) -> Result<()> {
        if self.before.is_empty() {
            return Ok(());
        }
        let taken = ram.read_word(Self::word(AheadWord::Taken))? as usize;
        let chips = ram.read_word(Self::word(AheadWord::Chips))?;
        let of = |chip: usize| {
            // Of the last instant taken, a chip may have been read and the other not.
            let whole = chips >> chip & 1 != 0;
            if whole || taken == 0 {
                taken
            } else {
                taken - 1
            }
        };
        for chip in 0..2 {
            if let Some(before) = self.before.get(of(chip)) {
                world
                    .converter
                    .with_chip(chip, |now| now.clone_from(&before[chip]));
            }
        }
        self.steady = 0;
        self.clear(ram)
    }

    /// Nothing is answered ahead any more.
    ///
    /// # Errors
    /// The memory cannot be reached.
    pub fn clear(&mut self, ram: &mut SharedRam) -> Result<()> {
        self.before.clear();
        for word in [AheadWord::Given, AheadWord::Taken, AheadWord::Chips] {
            ram.write_word(Self::word(word), 0)?;
        }
        Ok(())
    }

    /// An instant was asked for: all that was given is taken. Returns how many further ones may be answered now.
    ///
    /// # Errors
    /// The memory cannot be reached.
    pub fn begin(&mut self, ram: &mut SharedRam) -> Result<u32> {
        self.clear(ram)?;
        let known = |question: &Vec<u8>| (1..=AHEAD_BYTES as usize).contains(&question.len());
        if !self.questions.iter().all(known) {
            self.steady = 0;
            return Ok(0);
        }
        for (chip, question) in self.questions.iter().enumerate() {
            let place = ahead_question(chip as u32);
            ram.write_word(place, question.len() as u32)?;
            ram.write(place + 4, question)?;
        }
        self.steady = (self.steady + 1).min(TRUST);
        Ok(if self.steady < TRUST {
            0
        } else {
            AHEAD_INSTANTS
        })
    }

    /// The first instant given is the one that was asked for.
    ///
    /// # Errors
    /// The memory cannot be reached.
    pub fn take_first(&self, ram: &mut SharedRam) -> Result<()> {
        let taken = self.before.len().min(1) as u32;
        ram.write_word(Self::word(AheadWord::Taken), taken)
    }

    /// What a chip will be asked.
    pub fn question(&self, chip: usize) -> &[u8] {
        &self.questions[chip]
    }

    /// Leaves an instant's answers: stamp, conversion, both transfers, and the chips as they were before these.
    ///
    /// # Errors
    /// The memory cannot be reached.
    pub fn give(
        &mut self,
        stamp: u32,
        conversion: u32,
        transfers: [Vec<u8>; 2],
        before: [Ad7606c; 2],
        ram: &mut SharedRam,
    ) -> Result<()> {
        let index = self.before.len() as u32;
        let place = ahead_instant(index);
        ram.write_word(place, stamp)?;
        ram.write_word(place + 4, conversion)?;
        for (answer, chip) in transfers.iter().zip(0..) {
            ram.write(place + 8 + chip * AHEAD_BYTES, answer)?;
        }
        self.before.push(before);
        ram.write_word(Self::word(AheadWord::Given), index + 1)
    }
}
