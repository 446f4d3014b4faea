//! `chip trace IMAGE FILE.vcd [SECONDS]`: what a logic analyser sees at the pins while the image samples, as the file that such an
//! instrument's program writes. `courier trace` judges it, as it judges that of a board.

use crate::check::fixture;
use crate::image::Image;
use crate::peripheral::flash::Start;
use crate::processor::{End, Processor};
use crate::recorder::{Change, NAMES, Recorder};
use crate::time::{TICK_HZ, Ticks, from_us};
use anyhow::{Context, Result, ensure};
use std::fs::File;
use std::io::{BufWriter, Write};
use std::path::Path;
use vcd::{TimescaleUnit, Writer};

/// What is recorded without a word about it, seconds: 40 conversions.
const SECONDS: f64 = 0.002;
/// The longest trace, seconds: its file has 180 MB.
const LONGEST_S: f64 = 1.0;
/// Conversions of the start and the self-test, and some more: from there on the board samples by its timer.
const SETTLED: u64 = 100;
/// The start takes 40 ms.
const PATIENCE_MS: u64 = 150;

/// Runs the image and writes the file.
///
/// # Errors
/// There is no such image, it does not come to sample, or breaks a rule, or the file cannot be written.
pub fn run(image: &Path, file: &Path, seconds: Option<&String>) -> Result<()> {
    let seconds = seconds.map_or(Ok(SECONDS), |text| text.parse());
    let seconds = seconds.ok().filter(|s| *s > 0.0 && *s <= LONGEST_S);
    let seconds = seconds.with_context(|| format!("wanted seconds above 0 to {LONGEST_S}"))?;
    let mut processor = fixture::start(&Image::open(image)?, 1, Start::default())?;
    let recorded = record(&mut processor, (seconds * TICK_HZ as f64) as Ticks);
    let (changes, end) = recorded?;
    fixture::judge(&mut processor, Ok("recorded".into()))?;
    let file = File::create(file).with_context(|| file.display().to_string())?;
    let mut file = BufWriter::new(file);
    write(&changes, end, &mut file)?;
    Ok(file.flush()?)
}

/// Lets the board start, then keeps what its lines do for so long; the changes, from instant 0 on, and the end.
fn record(processor: &mut Processor, duration: Ticks) -> Result<(Vec<Change>, Ticks)> {
    for _ in 0..PATIENCE_MS {
        if processor.chip().around.converter.conversions() >= SETTLED {
            break;
        }
        ensure!(
            processor.run(from_us(1000))? == End::Time,
            "the supply went by itself"
        );
    }
    let taken = processor.chip().around.converter.conversions();
    ensure!(
        taken >= SETTLED,
        "found {taken} conversions in {PATIENCE_MS} ms, wanted {SETTLED}"
    );
    let begin = processor.now();
    let chip = processor.chip();
    let mut recorder = Recorder::new(begin);
    recorder.levels(begin, &chip.lines);
    chip.recorder = Some(recorder);
    processor.run(duration)?;
    let end = processor.now() - begin;
    let changes = processor.chip().recorder.take().map(Recorder::changes);
    Ok((changes.unwrap_or_default(), end))
}

/// Picoseconds of a number of ticks: 680 ticks are 500 ns.
const fn picoseconds(ticks: Ticks) -> u64 {
    ticks * 12_500 / 17
}

/// The file: a line each, in picoseconds.
fn write(changes: &[Change], end: Ticks, file: &mut impl Write) -> Result<()> {
    let mut writer = Writer::new(file);
    writer.comment("a model of the STM32G474 that runs the firmware's image")?;
    writer.timescale(1, TimescaleUnit::PS)?;
    writer.add_module("board")?;
    let wires = NAMES.map(|name| writer.add_wire(1, name));
    writer.upscope()?;
    writer.enddefinitions()?;
    let mut last = None;
    for change in changes {
        let at = picoseconds(change.at);
        if last.replace(at) != Some(at) {
            writer.timestamp(at)?;
        }
        if let Ok(wire) = wires[change.line] {
            writer.change_scalar(wire, change.high)?;
        }
    }
    writer.timestamp(picoseconds(end))?;
    Ok(writer.flush()?)
}
