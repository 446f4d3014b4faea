//! A good image is installed over the link while the board samples, starts on trial with the calibration, is accepted, and works in the bank
//! that it is in. Then the same with a cut in each operation ([`cuts`]).

use super::cuts::{self, Update};
use super::{Bench, START_UP, Seen, next};
use crate::bank::Bank;
use crate::check::fixture::judge;
use crate::image::Image as Elf;
use crate::processor::{BANK_BYTES, FLASH};
use anyhow::{Context, Result, ensure};
use courier_sensor::link::message::Action;
use courier_sensor::update::order::UpdateOrder;
use courier_sensor::update::version::Version;
use embedded_storage::nor_flash::NorFlash;
use link_host::outdated::OUTDATED;

pub fn run(elf: &Elf) -> Result<String> {
    let mut bench = Bench::factory(elf, 21)?;
    let mut noted = None;
    let result = update(&mut bench, elf, &mut noted);
    let said = judge(&mut bench.board.processor.borrow_mut(), result)?;
    let cuts = cuts::cut(&noted.context("an update was made")?)?;
    Ok(format!("{said}; {cuts}"))
}

/// `noted`: what the update did to the flash.
fn update(bench: &mut Bench, elf: &Elf, noted: &mut Option<Update>) -> Result<String> {
    let image = next(elf)?;
    let version = image.header.version;
    bench.store(1)?;
    bench.expect(Seen::kept(Version::OWN, 1), "before the update")?;
    let before = bench.link.status()?;
    let banks = bench.banks.each_ref().map(|bank| bank.0.borrow().clone());
    let log = bench.log();
    bench.install(&image)?;
    let after = bench.link.status()?;
    let (samples, missed) = (after.samples - before.samples, after.missed - before.missed);
    ensure!(
        missed == 0 && samples > 0,
        "found {missed} instants missed of {samples} during an update, wanted none"
    );
    bench.restart()?;
    bench.expect(Seen::on_trial(version, 1), "after the restart")?;
    let lose_unknown = false;
    ensure!(
        bench.link.ask(Action::Commit { lose_unknown }).is_err(),
        "an image on trial stores a calibration"
    );
    bench.ask(UpdateOrder::Accept)?;
    *noted = Some(Update {
        before: banks,
        operations: log.borrow().clone(),
    });
    // In the bank that it is in now it stores beside it, and is started again.
    bench.store(2)?;
    bench.restart()?;
    bench.expect(Seen::kept(version, 2), "after the acceptance")?;
    write_by_probe(bench, elf)?;
    bench.expect(
        Seen::kept(Version::OWN, 2),
        "after a probe has written bank 1",
    )?;
    Ok(format!(
        "{} bytes installed over {samples} samples, none missed; on trial, accepted, a calibration stored from bank 2; written over by a probe",
        image.body.len()
    ))
}

/// What `cargo flash` does: the image goes into bank 1, and what is out of date then is erased.
fn write_by_probe(bench: &mut Bench, elf: &Elf) -> Result<()> {
    Bank::new(bench.banks[0].clone()).load(&elf.flash(FLASH, BANK_BYTES as usize)?);
    for page in OUTDATED {
        let offset = page.start - FLASH;
        let (bank, offset) = (offset / BANK_BYTES, offset % BANK_BYTES);
        let erased = bench.banks[bank as usize].erase(offset, offset + page.len() as u32);
        erased.map_err(|error| anyhow::anyhow!("the probe: {error:?}"))?;
    }
    bench.board.processor.borrow_mut().cut_power()?;
    bench.link.pass(START_UP)?;
    bench.link.reconnect()
}
