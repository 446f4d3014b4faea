//! What the sampling interrupts take of a sample, without and with the flash's wait states: plain, with a tooth map, and with as many further
//! terms besides as the board has room for; and the sampling rate up to which no instant is missed.

mod failed;
mod sampling;

use super::fixture::{judge, start};
use crate::image::Image;
use crate::peripheral::flash::Start;
use crate::processor::Processor;
use crate::registers;
use crate::time::from_us;
use crate::wire::Board;
use anyhow::{Result, ensure};
use board_link::{Link, map};
use courier_sensor::calibration::record::Calibration;
use courier_sensor::geometry::Geometry;
use courier_sensor::link::message::Action;
use courier_sensor::model::{
    BACKGROUND_CYCLES, ErrorModel, MAX_LATERAL_ORDER, MAX_OWN_ORDER, Multiplier, Term, TermTable,
    most_rows_beside_a_map,
};
use courier_sensor::teeth::{Grid, MAX_NODES, MapHeader, TRUST_WORDS, Wave};
use hal_sim::wire::fault::{InputFault, When};
use sampling::{LOOK_US, SAMPLING, settle};
use std::fmt;
use std::time::Duration;

/// Two and a half intervals at 20 kHz: at least one instant is missed.
const MISSED_US: u64 = 125;
/// What they may take together, with wait states, of [`SAMPLE_CYCLES`]: plain, and with a map.
const WANTED_CYCLES: u64 = 1500;
const WANTED_MAPPED_CYCLES: u64 = 4000;
/// Cycles of a sample at 20 kHz.
pub(super) const SAMPLE_CYCLES: u64 = 8500;
/// Further terms for which there is to be room beside a map.
const WANTED_TERMS: usize = 8;
/// The rate at which no instant may be missed without a calibration, and the next ones that are tried.
const WANTED_HZ: u32 = 60_000;
const FASTER_HZ: [u32; 4] = [60_000, 70_000, 80_000, 90_000];
/// Five windows of 256 samples, one of which is a whole one of the first segment (`signal/src/settings.rs`, `frozen_samples`).
const WINDOWS_US: u64 = 64_000;
/// A channel that its amplifier cuts off: away from zero, and below the converter's end.
const AT_RAIL_COUNTS: i16 = 20_000;
/// Rate of the image as it ships.
const OWN_HZ: f32 = 20_000.0;

/// What was measured.
struct Figures {
    plain_without: Cycles,
    plain: Cycles,
    /// With the data cache off, as while bank 2 is written.
    uncached: Cycles,
    /// Where every access waits that DMA may hold up: plain, with the first sample after instants that were missed, and with a channel that
    /// stands still.
    waiting: Cycles,
    missed: Cycles,
    still: Cycles,
    /// The longest sample whose reading fails, or that comes after one, and how it fails.
    failed: (u64, &'static str),
    mapped: Cycles,
    fullest: Cycles,
    /// The longest sample with all that while the converters are set anew, and instants missed meanwhile.
    fullest_anew: (u64, u32),
    rate_max_hz: u32,
}

impl Figures {
    /// The longest sample without a map. One after missed instants has no look at channels that stand still (`signal/src/step.rs`), so
    /// that the two never come together.
    fn worst(&self) -> u64 {
        let Self {
            uncached,
            waiting,
            missed,
            still,
            failed,
            ..
        } = self;
        let cycles = [
            uncached.worst,
            waiting.worst,
            missed.worst,
            still.worst,
            failed.0,
        ];
        cycles.into_iter().fold(0, u64::max)
    }
}

pub fn run(image: &Image) -> Result<String> {
    let figures = measure(image)?;
    let Figures {
        plain_without,
        plain,
        uncached,
        waiting,
        missed,
        still,
        failed: (failed, how),
        mapped,
        fullest,
        fullest_anew: (fullest_anew, missed_anew),
        rate_max_hz,
    } = &figures;
    let terms = most_rows_beside_a_map(OWN_HZ);
    let said = format!(
        "the sampling interrupts take {plain_without} cycles a sample; with wait states {plain}, and with the data cache off {uncached}; where all wait for DMA that can {waiting}, after an instant that was missed {} at most, with a channel that stands still {} at most, with a reading that fails {failed} at most, by {how}; with a map of {MAX_NODES} nodes {mapped}, \
         with {terms} further terms besides {fullest}, and while the converters are set anew {fullest_anew} at most, {missed_anew} instants missed; no instant is missed up to {rate_max_hz} Hz",
        missed.worst, still.worst
    );
    ensure!(
        figures.worst() <= WANTED_CYCLES && mapped.worst <= WANTED_MAPPED_CYCLES,
        "{said}; wanted {WANTED_CYCLES} and {WANTED_MAPPED_CYCLES} cycles or fewer"
    );
    let allowed = SAMPLE_CYCLES - BACKGROUND_CYCLES as u64;
    ensure!(
        terms >= WANTED_TERMS && fullest.worst.max(*fullest_anew) <= allowed,
        "{said}; wanted {WANTED_TERMS} terms or more, and {allowed} cycles or fewer for them and a map"
    );
    ensure!(
        *missed_anew == 0,
        "{said}; wanted none missed while the converters are set anew"
    );
    ensure!(
        *rate_max_hz >= WANTED_HZ,
        "{said}; wanted {WANTED_HZ} Hz or more"
    );
    Ok(said)
}

/// The same as one JSON object, for `cargo xtask bench --json`.
///
/// # Errors
/// As the check's.
pub fn json(image: &Image) -> Result<String> {
    let figures = measure(image)?;
    Ok(format!(
        "{{\"sample_cycles_worst\": {}, \"sample_mapped_cycles_worst\": {}, \"rate_max_hz\": {}, \"terms_beside_map\": {}}}",
        figures.worst(),
        figures.mapped.worst,
        figures.rate_max_hz,
        most_rows_beside_a_map(OWN_HZ)
    ))
}

fn measure(image: &Image) -> Result<Figures> {
    let board = Board::new(start(image, 10, Start::default())?);
    let result = look(&board);
    let mut processor = board.processor.borrow_mut();
    let broken = judge(&mut processor, Ok(String::new()));
    result.and_then(|figures| broken.map(|_| figures))
}

fn look(board: &Board) -> Result<Figures> {
    let mut link = Link::connect(Box::new(board.clone()))?;
    let with_states = |counted| {
        let mut processor = board.processor.borrow_mut();
        processor.set_wait_states(counted)?;
        spent(&mut processor)
    };
    let (plain_without, plain) = (with_states(false)?, with_states(true)?);
    let uncached = without_data_cache(&mut board.processor.borrow_mut())?;
    let before = link.status()?.missed;
    let (waiting, missed, still, failed) = {
        let mut processor = board.processor.borrow_mut();
        processor.set_waiting_for_dma(true);
        let waiting = spent(&mut processor)?;
        let missed = after_a_missed_instant(&mut processor)?;
        let still = while_a_channel_stands_still(&mut processor)?;
        let failed = failed::longest(&mut processor)?;
        processor.set_waiting_for_dma(false);
        (waiting, missed, still, failed)
    };
    ensure!(
        link.status()?.missed > before,
        "no instant was missed while the processor stood still"
    );
    let rate_max_hz = fastest(board, &mut link)?;
    set_rate(&mut board.processor.borrow_mut(), OWN_HZ as u32);
    put_in_force(&mut link, TermTable::equation_3())?;
    let mapped = with_states(true)?;
    put_in_force(&mut link, dearest(most_rows_beside_a_map(OWN_HZ)))?;
    let fullest = with_states(true)?;
    let before = link.status()?.missed;
    let anew = failed::longest_anew(&mut board.processor.borrow_mut())?;
    let fullest_anew = (anew, link.status()?.missed.wrapping_sub(before));
    Ok(Figures {
        plain_without,
        plain,
        uncached,
        waiting,
        missed,
        still,
        failed,
        mapped,
        fullest,
        fullest_anew,
        rate_max_hz,
    })
}

/// Puts a record with these terms, of no board in particular, which becomes this one's, and the largest map in force.
fn put_in_force(link: &mut Link, terms: TermTable) -> Result<()> {
    let mut calibration = Calibration::identity(Geometry::PAPER);
    calibration.model = ErrorModel::zero(terms);
    link.ask(Action::take_over(calibration))?;
    link.pass(Duration::from_millis(1))?;
    let nodes: Vec<i16> = (0..MAX_NODES)
        .map(|n| (n * 37 % 401) as i16 - 200)
        .collect();
    map::load_map(link, fullest_map(), &nodes)?;
    link.pass(Duration::from_millis(1))
}

/// Equation (9) and so many rows that none cost more than: of the highest orders.
fn dearest(rows: usize) -> TermTable {
    let mut table = TermTable::equation_9();
    let kinds = [Multiplier::None, Multiplier::Speed, Multiplier::Direction];
    let orders = -(MAX_LATERAL_ORDER as i8)..=MAX_LATERAL_ORDER as i8;
    let terms = kinds.into_iter().flat_map(|multiplier| {
        orders.clone().map(move |lateral_order| Term {
            own_order: MAX_OWN_ORDER,
            lateral_order,
            theta_power: 1,
            multiplier,
        })
    });
    terms.take(rows).for_each(|term| {
        let _ = table.push(term);
    });
    table
}

/// The largest map that the board takes, every cell trusted, with the waves that `courier map` fits.
fn fullest_map() -> MapHeader {
    let grid = Grid {
        first_teeth: [-10, -10],
        nodes: [20, 20],
    };
    let mut header = MapHeader {
        grids: [grid; 2],
        ..MapHeader::default()
    };
    for (own_order, lateral_order) in [(0, 1), (0, 2), (1, 1), (1, -1), (2, 1), (2, -1)] {
        let wave = Wave {
            own_order,
            lateral_order,
            coefficients_m: [[1.0e-6, -2.0e-6]; 4],
        };
        let _ = header.waves.push(wave);
    }
    let _ = header.trusted.resize(TRUST_WORDS, u32::MAX);
    header
}

/// The same with the data cache off.
fn without_data_cache(processor: &mut Processor) -> Result<Cycles> {
    // ACR, and its bit DCEN (RM0440, 3.7.1).
    let at = registers::address("FLASH");
    let access = processor.chip().read(at, 4);
    processor.chip().write(at, 4, access & !(1 << 10));
    let spent = spent(processor)?;
    processor.chip().write(at, 4, access);
    Ok(spent)
}

/// The same with a sample before which the processor stood still for more than an instant, from between two readings on: an instant that
/// falls into a reading is passed over, in an interrupt of its own.
fn after_a_missed_instant(processor: &mut Processor) -> Result<Cycles> {
    processor.times.restart();
    processor.run(from_us(LOOK_US / 2))?;
    settle(processor)?;
    processor.chip().halt(from_us(MISSED_US));
    so_far(processor, LOOK_US / 2)
}

/// The same with a channel that does not change, at its amplifier's rail: what is said of it at a window's end takes longest.
fn while_a_channel_stands_still(processor: &mut Processor) -> Result<Cycles> {
    let switch = processor.chip().around.converter.input_fault();
    let at_rail = InputFault::Stuck {
        chip: 0,
        channel: 0,
        counts: AT_RAIL_COUNTS,
    };
    switch.set(at_rail, When::Always);
    processor.times.restart();
    let spent = so_far(processor, WINDOWS_US);
    switch.clear();
    spent
}

/// The fastest of the rates, in order, at which no instant is missed; 0: none.
fn fastest(board: &Board, link: &mut Link) -> Result<u32> {
    let mut fastest = 0;
    for rate_hz in FASTER_HZ {
        set_rate(&mut board.processor.borrow_mut(), rate_hz);
        let before = link.status()?.missed;
        link.pass(Duration::from_micros(LOOK_US))?;
        if link.status()?.missed != before {
            break;
        }
        fastest = rate_hz;
    }
    Ok(fastest)
}

/// Another period of TIM3, written as a debugger would: the image stays as it ships.
fn set_rate(processor: &mut Processor, rate_hz: u32) {
    // TIM3's ARR (RM0440, 29.5.12): the period less one.
    let at = registers::address("TIM3") + 0x2C;
    processor.chip().write(at, 4, 170_000_000 / rate_hz - 1);
}

/// Cycles of both sampling interrupts of a sample together: the mean, and the sum of the longest of each.
#[derive(Clone, Copy, Debug)]
pub(super) struct Cycles {
    pub mean: u64,
    pub worst: u64,
}

impl fmt::Display for Cycles {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{} ({} at most)", self.mean, self.worst)
    }
}

/// What the sampling interrupts take from now on.
pub(super) fn spent(processor: &mut Processor) -> Result<Cycles> {
    processor.times.restart();
    so_far(processor, LOOK_US)
}

/// What they have taken since the times were begun anew, after so much more time.
fn so_far(processor: &mut Processor, more_us: u64) -> Result<Cycles> {
    processor.run(from_us(more_us))?;
    let mut together = Cycles { mean: 0, worst: 0 };
    for name in SAMPLING {
        let spent = processor.times.of(16 + registers::interrupt(name));
        ensure!(spent.count > 0, "the interrupt {name} never came");
        together.mean += spent.sum / spent.count;
        together.worst += spent.worst;
    }
    Ok(together)
}
