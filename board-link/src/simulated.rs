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
        let [_, last_ns] = self.world.sampled_ns();
        self.number_at(last_ns)
    }

    /// Sequence number of the sampling instant at this time: its time over the period, so that missed instants count. 0 before the first.
    pub fn number_at(&self, time_ns: u64) -> u32 {
        let [first_ns, _] = self.world.sampled_ns();
        let period_ns = 1.0e9 / f64::from(self.link.hello().rate_hz);
        (time_ns.saturating_sub(first_ns) as f64 / period_ns).round() as u32
    }
}
