//! A chip without its processor, and what brings it to where the faults begin.

use chip::chip::Chip;
use chip::peripheral::flash::Start;
use chip::rule::Rule;
use chip::surroundings::Surroundings;
use chip::time::from_us;
use hal_sim::board::SharedFlash;
use hal_sim::presets;
use hal_sim::wire::motion::ControllerConfig;
use hal_sim::world::World;

/// What is around a chip: `hal-sim`'s parts, both banks erased.
pub fn around() -> Surroundings {
    let world = World::new(
        presets::ideal(1),
        ControllerConfig::TYPICAL,
        Default::default(),
        1,
    );
    Surroundings::new(world.expect("monotonic"), SharedFlash::erased(1))
}

pub fn chip(start: Start) -> Chip {
    Chip::new(around(), start)
}

/// A fault must trip the rule whose name this is, with `_` for `-`.
pub fn trip(rule: &str, fault: fn(&mut Chip)) {
    let rule = Rule::ALL
        .iter()
        .find(|known| known.name().replace('-', "_") == rule)
        .unwrap_or_else(|| panic!("{rule} is no rule"));
    let mut chip = chip(Start::default());
    fault(&mut chip);
    let found = chip.findings.list();
    let tripped = found.iter().any(|violation| violation.rule == *rule);
    assert!(tripped, "{}: found {found:?}", rule.name());
}

/// Nothing broken so far.
pub fn assert_kept(chip: &Chip) {
    let found = chip.findings.list();
    assert!(found.is_empty(), "{found:?}");
}

pub fn set(chip: &mut Chip, address: u32, bits: u32) {
    let value = chip.read(address, 4);
    chip.write(address, 4, value | bits);
}

pub fn clear(chip: &mut Chip, address: u32, bits: u32) {
    let value = chip.read(address, 4);
    chip.write(address, 4, value & !bits);
}

pub fn wait_us(chip: &mut Chip, us: u64) {
    let until = chip.now + from_us(us);
    chip.advance_to(until);
}
