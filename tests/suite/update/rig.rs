//! Two banks of flash and what the firmware does with them.

use courier_sensor::calibration::record::{Calibration, Instant};
use courier_sensor::calibration::slots::Slots;
use courier_sensor::geometry::Geometry;
use courier_sensor::update::choice::choose;
use courier_sensor::update::header::{self, CRC32, Header};
use courier_sensor::update::install::{Install, Progress, Rules, UpdateRefusal, next_number};
use courier_sensor::update::layout::{
    BANK_BYTES, BODY_START, IMAGE_START, JOURNAL_END, JOURNAL_START, SLOTS_START,
};
use courier_sensor::update::trial::{self, Standing};
use courier_sensor::update::version::Version;
use courier_sensor::update::{key, standing};
use ed25519_compact::{KeyPair, Seed};
use embedded_storage::nor_flash::NorFlash;
use hal_sim::wire::flash::{Flash, PAGE_BYTES};

/// Seed of the development key.
pub const SEED: [u8; 32] = [0x43; 32];
/// Bytes that the host sends at once.
const CHUNK: usize = 384;
/// Body of the test's images: crosses a page's border.
const BODY_BYTES: usize = PAGE_BYTES;

pub fn version(minor: u16) -> Version {
    Version {
        major: 0,
        minor,
        patch: 0,
    }
}

/// An image as it is sent: header and body.
#[derive(Clone)]
pub struct Image {
    pub header: [u8; header::BYTES],
    pub body: Vec<u8>,
}

/// Signs an image.
pub fn image_of(board: &str, minor: u16, seed: [u8; 32], body_bytes: usize) -> Image {
    let body: Vec<u8> = (0..body_bytes)
        .map(|place| (place as u8).wrapping_mul(31) ^ minor as u8)
        .collect();
    let pair = KeyPair::from_seed(Seed::new(seed));
    let mut header = Header {
        board: header::board(board),
        version: version(minor),
        body_bytes: body_bytes as u32,
        body_crc: CRC32.checksum(&body),
        key: *pair.pk,
        signature: [0; 64],
    };
    let message = [&header.signed()[..], &body].concat();
    header.signature = *pair.sk.sign(message, None);
    Image {
        header: header.encode(),
        body,
    }
}

/// One that the board takes.
pub fn image(minor: u16) -> Image {
    image_of("g474", minor, SEED, BODY_BYTES)
}

/// The board's two banks.
#[derive(Clone)]
pub struct Board {
    pub banks: [Flash; 2],
}

/// What runs.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Running {
    pub bank: usize,
    pub minor: u16,
    pub standing: Standing,
}

impl Board {
    /// Version 0.1.0 in bank 1 as a debug probe writes it.
    pub fn factory(seed: u64, ecc: bool) -> Self {
        let bank = |seed| {
            let flash = Flash::new(BANK_BYTES as usize / PAGE_BYTES, seed);
            if ecc { flash } else { flash.without_ecc() }
        };
        let mut banks = [bank(2 * seed), bank(2 * seed + 1)];
        let image = image(1);
        banks[0].force(IMAGE_START as usize, &image.header);
        banks[0].force(BODY_START as usize, &image.body);
        Self { banks }
    }

    /// Writes version 0.1.0 into bank 1 as a debug probe does, which also takes the other image's header and the own journal away.
    pub fn written_by_probe(&mut self) {
        let image = image(1);
        let [first, second] = &mut self.banks;
        first.force(IMAGE_START as usize, &image.header);
        first.force(BODY_START as usize, &image.body);
        first.erase(JOURNAL_START, JOURNAL_END).unwrap();
        second
            .erase(IMAGE_START, IMAGE_START + PAGE_BYTES as u32)
            .unwrap();
    }

    /// The power goes after so many steps of either bank's work from now.
    pub fn cut_after(&mut self, steps: u64) {
        self.banks.iter_mut().for_each(|bank| bank.cut_after(steps));
    }

    /// Steps done so far.
    pub fn steps(&self) -> u64 {
        self.banks.iter().map(Flash::steps).sum()
    }

    pub fn power_up(&mut self) {
        self.banks.iter_mut().for_each(Flash::power_up);
    }

    fn near_and_far(&mut self, near: usize) -> (&mut Flash, &mut Flash) {
        let [first, second] = &mut self.banks;
        if near == 0 {
            (first, second)
        } else {
            (second, first)
        }
    }

    pub fn far(&mut self, running: &Running) -> &mut Flash {
        &mut self.banks[1 - running.bank]
    }

    /// Reset: the first stage, then the image's start.
    pub fn start(&mut self) -> Option<Running> {
        let chosen = choose(&mut self.banks, standing::is_whole)?;
        let (near, far) = self.near_and_far(chosen.bank);
        let header = standing::read(near).header?;
        assert!(
            standing::is_whole(near, &header),
            "half an image is started"
        );
        let standing = trial::start(near, far);
        Some(Running {
            bank: chosen.bank,
            minor: header.version.minor,
            standing,
        })
    }

    /// The calibration that the running image finds.
    pub fn calibration(&mut self, running: &Running) -> Option<u32> {
        let slots = Slots::new(self.far(running), SLOTS_START).load();
        slots.ok().map(|(_, found)| found.made.uptime_s)
    }

    /// Stores one, told apart by `mark`.
    pub fn commit(&mut self, running: &Running, mark: u32) -> bool {
        assert_eq!(running.standing.trial, None, "nothing is stored on trial");
        let calibration = Calibration {
            made: Instant {
                unix_s: None,
                uptime_s: mark,
            },
            ..Calibration::identity(Geometry::PAPER)
        };
        let mut slots = Slots::new(self.far(running), SLOTS_START);
        slots.commit(&calibration, false).is_ok()
    }

    /// Takes the calibration in force out of force.
    pub fn roll_back(&mut self, running: &Running) {
        let mut slots = Slots::new(self.far(running), SLOTS_START);
        slots.roll_back().unwrap();
    }

    pub fn rules(running: &Running) -> Rules {
        Rules {
            board: header::board("g474"),
            version: version(running.minor),
            key: key::DEVELOPMENT,
            allow_older: false,
        }
    }

    /// Sends an image and has it installed.
    pub fn update(&mut self, running: &Running, image: &Image) -> Result<(), UpdateRefusal> {
        let rules = Self::rules(running);
        let (near, far) = self.near_and_far(running.bank);
        let number = next_number(standing::read(near).highest_number(), &standing::read(far));
        let mut install = Install::begin(far, &image.header, &rules, number)?;
        for (index, piece) in image.body.chunks(CHUNK).enumerate() {
            install.data(far, (index * CHUNK) as u32, piece)?;
        }
        install.finish()?;
        while install.work(far) {}
        match install.progress() {
            Progress::Installed { .. } => Ok(()),
            Progress::Failed(refusal) => Err(refusal),
            other => panic!("{other:?}"),
        }
    }

    /// What a host says once it has seen the new image work.
    pub fn accept(&mut self, running: &Running) -> bool {
        let number = running.standing.trial.expect("on trial");
        running.standing.moved.is_ok() && trial::accept(self.far(running), number).is_ok()
    }
}
