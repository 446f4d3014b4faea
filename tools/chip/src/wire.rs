//! The debug link to the modelled chip: the rings in its RAM, found there as a debug probe finds them.

use crate::processor::{End, Processor};
use crate::time::from_ns;
use anyhow::Result;
use board_link::Wire;
use link_host::memory::TargetMemory;
use link_host::rtt::Rtt;

use std::cell::RefCell;
use std::rc::Rc;
use std::time::Duration;

/// Where a probe looks for the rings, and how far.
const RAM: (u32, u32) = (0x2000_0000, 128 << 10);
/// The ring of commands.
const COMMAND_CHANNEL: usize = 0;

/// A chip that several hold: the link, and the check that looks into it. Clones are the same chip.
#[derive(Clone)]
pub struct Board {
    /// The chip.
    pub processor: Rc<RefCell<Processor>>,
    /// As they were found: after how many resets, and where.
    rings: Rc<RefCell<Option<(u32, u32, Rtt)>>>,
}

impl Board {
    /// A board with this chip.
    pub fn new(processor: Processor) -> Self {
        Self {
            processor: Rc::new(RefCell::new(processor)),
            rings: Rc::default(),
        }
    }

    /// The rings, once the image that runs now has set them up.
    fn rings(&self) -> Result<Option<Rtt>> {
        let mut processor = self.processor.borrow_mut();
        let resets = processor.resets();
        let mut rings = self.rings.borrow_mut();
        let mut memory = Memory(&mut processor);
        // Those of before a reset are there until the first stage takes them away.
        let known = rings.as_ref().filter(|(of, ..)| *of == resets);
        let known = known.map(|(_, at, _)| *at);
        let found = Rtt::find(&mut memory, known, RAM)?;
        *rings = found.map(|(at, rtt)| (resets, at, rtt));
        Ok(rings.as_ref().map(|(.., rtt)| rtt.clone()))
    }
}

struct Memory<'a>(&'a mut Processor);

impl TargetMemory for Memory<'_> {
    fn read(&mut self, address: u32, bytes: &mut [u8]) -> Result<()> {
        self.0.read_memory(address, bytes)
    }

    fn write(&mut self, address: u32, bytes: &[u8]) -> Result<()> {
        self.0.write_memory(address, bytes)
    }
}

impl Wire for Board {
    fn receive(&mut self, channel: usize, bytes: &mut [u8]) -> Result<usize> {
        let Some(rtt) = self.rings()? else {
            return Ok(0);
        };
        let mut processor = self.processor.borrow_mut();
        rtt.read(&mut Memory(&mut processor), channel, bytes)
    }

    fn send(&mut self, bytes: &[u8]) -> Result<usize> {
        let Some(rtt) = self.rings()? else {
            return Ok(0);
        };
        let mut processor = self.processor.borrow_mut();
        rtt.write(&mut Memory(&mut processor), COMMAND_CHANNEL, bytes)
    }

    /// A supply that goes comes back at once.
    fn pass(&mut self, time: Duration) -> Result<()> {
        let mut processor = self.processor.borrow_mut();
        let end = processor.now() + from_ns(time.as_nanos() as u64);
        while processor.now() < end {
            let left = end - processor.now();
            if processor.run(left)? == End::PowerLost {
                processor.cut_power()?;
            }
        }
        Ok(())
    }
}
