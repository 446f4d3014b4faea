//! A simulated courier with a board on it that is spoken to over its debug link, and a look at the courier from outside.

use super::emulated;
use super::link::Link;
use super::sim::SimWire;
use anyhow::Result;
use clap::ValueEnum;
use hal_sim::board::SharedFlash;
use hal_sim::spec::CourierSpec;
use hal_sim::wire::motion::ControllerConfig;
use hal_sim::world::World;
use link_host::emulated::{Emulated, Parts};
use link_host::wire::Wire;

/// What the firmware runs on.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum On {
    /// This process: the firmware's own code, built for this machine.
    #[default]
    Sim,
    /// An emulated Cortex-M4F: the firmware's image in QEMU.
    Emulated,
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
    pub fn start(on: On, spec: CourierSpec, seed: u64) -> Result<Self> {
        let home = spec.places.scatter_corner;
        let world = World::new(spec, ControllerConfig::TYPICAL, home, seed)?;
        let flash = SharedFlash::erased(seed);
        let wire: Box<dyn Wire> = match on {
            On::Sim => Box::new(SimWire::around(world.clone(), flash.clone())?),
            On::Emulated => {
                let parts = Parts::new(world.clone(), flash.clone());
                Box::new(Emulated::start(&emulated::images()?, parts)?)
            }
        };
        let link = Link::connect(wire)?;
        Ok(Self { link, world, flash })
    }

    /// Sequence number of the last sample that the board has taken.
    pub fn sequence(&self) -> u32 {
        let taken = self.world.conversions() - self.world.first_conversion();
        taken.saturating_sub(1) as u32
    }
}
