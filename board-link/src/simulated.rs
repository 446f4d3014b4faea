//! A simulated courier with a board on it that is spoken to over its debug link, and a look at the courier from outside.

use crate::{Link, SimWire, Wire};
use anyhow::Result;
use hal_sim::board::SharedFlash;
use hal_sim::spec::CourierSpec;
use hal_sim::wire::motion::ControllerConfig;
use hal_sim::world::World;

/// Switches a courier's board on, given the courier and the board's flash, and gives the way to it. By default the board is
/// simulated in this process.
#[derive(Clone, Copy, Debug)]
pub struct Starter(pub fn(World, SharedFlash) -> Result<Box<dyn Wire>>);

impl Default for Starter {
    fn default() -> Self {
        Self(|world, flash| Ok(Box::new(SimWire::around(world, flash)?)))
    }
}

/// A courier and its board.
pub struct Simulated {
    /// The board's debug link.
    pub link: Link,
    /// Everything around the board.
    pub world: World,
    /// The flash that its calibrations are stored in.
    pub flash: SharedFlash,
}

impl Simulated {
    /// Switches the board of a courier at rest on, its flash erased.
    ///
    /// # Errors
    /// The courier's errors have no unique inverse, or the board does not start or cannot be had.
    pub fn start(board: Starter, spec: CourierSpec, seed: u64) -> Result<Self> {
        let home = spec.places.scatter_corner;
        let world = World::new(spec, ControllerConfig::TYPICAL, home, seed)?;
        let flash = SharedFlash::erased(seed);
        let Starter(start) = board;
        let link = Link::connect(start(world.clone(), flash.clone())?)?;
        Ok(Self { link, world, flash })
    }

    /// Sequence number of the last sample that the board has taken.
    pub fn sequence(&self) -> u32 {
        let taken = self.world.conversions() - self.world.first_conversion();
        taken.saturating_sub(1) as u32
    }
}
