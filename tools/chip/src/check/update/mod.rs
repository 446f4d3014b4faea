//! A new firmware over the link: what comes of a good one, of a supply that goes, and of images that are not to run.

mod cuts;
pub mod good;
pub mod refused;
pub mod trial;

use super::fixture::world;
use crate::bank::{Bank, Log};
use crate::chip::Chip;
use crate::image::Image as Elf;
use crate::peripheral::flash::Start;
use crate::processor::{BANK_BYTES, FLASH, Processor};
use crate::surroundings::Surroundings;
use crate::wire::Board;
use anyhow::{Context, Result, bail, ensure};
use board_link::image::{DEVELOPMENT_SEED, Image};
use board_link::{Link, update};
use courier_sensor::calibration::record::Calibration;
use courier_sensor::geometry::Geometry;
use courier_sensor::link::message::{Action, Reply, Source};
use courier_sensor::model::{ErrorModel, TermTable};
use courier_sensor::update::header::Header;
use courier_sensor::update::layout::{BODY_START, IMAGE_START};
use courier_sensor::update::order::{UpdateOrder, UpdateStatus};
use courier_sensor::update::version::Version;
use hal_sim::board::SharedFlash;
use std::time::Duration;

/// Name of the board in an image's header.
const BOARD: &str = "g474";
/// From a reset until the link answers: first stage, set-up, and a copy of the calibration that takes two erases.
const START_UP: Duration = Duration::from_millis(150);

/// A board that runs the image as it ships, with both its banks at hand.
struct Bench {
    board: Board,
    link: Link,
    banks: [SharedFlash; 2],
}

impl Bench {
    /// Bank 1 as a debug probe writes it, nothing stored.
    fn factory(elf: &Elf, seed: u64) -> Result<Self> {
        let banks = [0, 1].map(|bank| SharedFlash::erased(2 * seed + bank));
        Bank::new(banks[0].clone()).load(&elf.flash(FLASH, BANK_BYTES as usize)?);
        Self::with_banks(banks, seed)
    }

    /// A board with these banks is switched on.
    fn with_banks(banks: [SharedFlash; 2], seed: u64) -> Result<Self> {
        let board = Board::new(switched_on(&banks, seed)?);
        let link = Link::connect(Box::new(board.clone()))?;
        Ok(Self { board, link, banks })
    }

    /// From now on each operation of either bank is noted.
    fn log(&self) -> Log {
        let log = Log::default();
        let mut processor = self.board.processor.borrow_mut();
        for (number, bank) in processor.chip().around.banks.iter().enumerate() {
            bank.note_in(number, &log);
        }
        log
    }

    fn ask(&mut self, order: UpdateOrder) -> Result<UpdateStatus> {
        update::ask(&mut self.link, order)
    }

    fn install(&mut self, image: &Image) -> Result<()> {
        update::send(
            &mut self.link,
            image,
            false,
            &indicatif::ProgressBar::hidden(),
        )
    }

    fn restart(&mut self) -> Result<()> {
        let done = self.link.ask(Action::Restart)?;
        ensure!(
            done == Reply::Done,
            "found {done:?} as the reply to a restart"
        );
        self.link.pass(START_UP)?;
        self.link.reconnect()
    }

    /// Stores a calibration that is told from others by this number.
    fn store(&mut self, mark: u32) -> Result<()> {
        let mut calibration = Calibration::identity(Geometry::PAPER);
        calibration.model = ErrorModel::zero(TermTable::equation_3());
        calibration.made.uptime_s = mark;
        let lose_unknown = false;
        self.link.ask(Action::take_over(calibration))?;
        match self.link.ask(Action::Commit { lose_unknown })? {
            Reply::Place(_) => Ok(()),
            other => bail!("found {other:?} as the reply to a commit, wanted its place"),
        }
    }

    /// What runs, whether it is on trial, and the calibration in force.
    fn seen(&mut self) -> Result<Seen> {
        let status = self.ask(UpdateOrder::Status)?;
        let mark = match self.link.ask(Action::Read(Source::InForce)) {
            Ok(Reply::Calibration(calibration)) => Some(calibration.made.uptime_s),
            _ => None,
        };
        Ok(Seen {
            version: status.running,
            on_trial: status.trial_left_s.is_some(),
            mark,
        })
    }

    fn expect(&mut self, wanted: Seen, when: &str) -> Result<()> {
        let found = self.seen()?;
        ensure!(
            found == wanted,
            "{when}: found {found:?}, wanted {wanted:?}"
        );
        Ok(())
    }
}

/// How a board stands.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
struct Seen {
    version: Version,
    on_trial: bool,
    mark: Option<u32>,
}

impl Seen {
    fn kept(version: Version, mark: u32) -> Self {
        let on_trial = false;
        Self {
            version,
            on_trial,
            mark: Some(mark),
        }
    }

    fn on_trial(version: Version, mark: u32) -> Self {
        let on_trial = true;
        Self {
            on_trial,
            ..Self::kept(version, mark)
        }
    }
}

/// A chip with these banks, switched on.
fn switched_on(banks: &[SharedFlash; 2], seed: u64) -> Result<Processor> {
    let (world, _) = world(seed)?;
    let around = Surroundings::with_banks(world, banks.clone());
    let mut processor = Processor::start(&[], Chip::new(around, Start::default()))?;
    processor.may_reset = true;
    Ok(processor)
}

/// The image that ships, as an update to the next version.
fn next(elf: &Elf) -> Result<Image> {
    let bank = elf.flash(FLASH, BANK_BYTES as usize)?;
    let header = bank[IMAGE_START as usize..].first_chunk();
    let header = Header::parse(header.context("a header's length")?)
        .map_err(|error| anyhow::anyhow!("found {error}, wanted the shipped image's header"))?;
    let version = Version {
        minor: header.version.minor + 1,
        ..header.version
    };
    let body = bank[BODY_START as usize..][..header.body_bytes as usize].to_vec();
    Image::sign(DEVELOPMENT_SEED, BOARD, version, body)
}

/// An image that sleeps for ever: its vectors, and two instructions.
fn sleeper(version: Version) -> Result<Image> {
    let start = FLASH + BODY_START + 8;
    let mut body = vec![];
    body.extend(0x2000_1000u32.to_le_bytes());
    body.extend((start | 1).to_le_bytes());
    // wfi, and back to it.
    body.extend([0xBF30u16, 0xE7FD].map(u16::to_le_bytes).concat());
    Image::sign(DEVELOPMENT_SEED, BOARD, version, body)
}
