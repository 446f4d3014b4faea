//! What the checks have in common: a chip in a world of its own, and the judgement of the rules that its run broke.

use crate::chip::Chip;
use crate::image::Image;
use crate::peripheral::flash::Start;
use crate::processor::{BANK_BYTES, FLASH, Processor};
use crate::surroundings::Surroundings;
use anyhow::{Result, bail};
use hal_sim::board::SharedFlash;
use hal_sim::presets;
use hal_sim::wire::flash::Flash;
use hal_sim::wire::motion::ControllerConfig;
use hal_sim::world::World;
use std::cell::RefCell;
use std::rc::Rc;

/// Pages of bank 2.
const PAGES: usize = 128;

/// The ideal courier with its board, the chip as the README wants it, nothing stored.
pub(crate) fn world(seed: u64) -> Result<(World, SharedFlash)> {
    let spec = presets::ideal(seed);
    let world = World::new(spec, ControllerConfig::TYPICAL, Default::default(), seed)?;
    let flash = SharedFlash(Rc::new(RefCell::new(Flash::new(PAGES, seed))));
    Ok((world, flash))
}

/// A chip in a world of its own, switched on.
pub(crate) fn start(image: &Image, seed: u64, start: Start) -> Result<Processor> {
    let (world, flash) = world(seed)?;
    start_in(image, world, flash, start)
}

/// A chip in this world, switched on.
pub(crate) fn start_in(
    image: &Image,
    world: World,
    flash: SharedFlash,
    start: Start,
) -> Result<Processor> {
    let code = image.flash(FLASH, BANK_BYTES as usize)?;
    Processor::start(&code, Chip::new(Surroundings::new(world, flash), start))
}

/// Fails if a rule was broken, whatever else went wrong; both are told.
pub(crate) fn judge(processor: &mut Processor, result: Result<String>) -> Result<String> {
    let broken = processor.findings().list();
    if broken.is_empty() {
        return result;
    }
    let lines: Vec<String> = broken
        .iter()
        .map(|violation| format!("\n  {violation}"))
        .collect();
    let rules = format!("{} rules broken:{}", lines.len(), lines.concat());
    match result {
        Ok(said) => bail!("{said}; {rules}"),
        Err(error) => Err(error.context(rules)),
    }
}
