//! Images that are not to run: what is installed stays, and is started again.

use super::{BOARD, Bench, Seen, sleeper};
use crate::check::fixture::judge;
use crate::image::Image as Elf;
use anyhow::{Context, Result, bail, ensure};
use board_link::image::{DEVELOPMENT_SEED, Image};
use courier_sensor::update::order::UpdateOrder;
use courier_sensor::update::version::Version;
use heapless::Vec;

/// Longer than the image that is sent, so that half of it is something.
const BODY_BYTES: usize = 3000;

pub fn run(elf: &Elf) -> Result<String> {
    let mut bench = Bench::factory(elf, 22)?;
    let result = refuse(&mut bench);
    judge(&mut bench.board.processor.borrow_mut(), result)
}

fn refuse(bench: &mut Bench) -> Result<String> {
    let own = Version::OWN;
    let older = Version {
        minor: 0,
        patch: 0,
        ..own
    };
    let body = || vec![0x5A; BODY_BYTES];
    let good = sleeper(own)?;
    let mut forged = good.clone();
    forged.header.signature[5] ^= 1;
    let mut damaged = good.clone();
    damaged.body[9] ^= 1;
    let cases = [
        (
            "another board's image",
            Image::sign(DEVELOPMENT_SEED, "emulated", own, body())?,
            "for another board",
        ),
        (
            "an older version",
            Image::sign(DEVELOPMENT_SEED, BOARD, older, body())?,
            "older than",
        ),
        (
            "another key",
            Image::sign([9; 32], BOARD, own, body())?,
            "does not trust",
        ),
        ("a wrong signature", forged, "signature is wrong"),
        ("a damaged body", damaged, "damaged"),
    ];
    bench.store(1)?;
    for (what, image, wanted) in &cases {
        let told = match bench.install(image) {
            Ok(()) => bail!("found {what} installed, wanted it refused"),
            Err(error) => format!("{error:#}"),
        };
        ensure!(
            told.contains(wanted),
            "{what}: found {told:?}, wanted {wanted:?}"
        );
        still(bench, what)?;
    }
    half(bench)?;
    still(bench, "half an image")?;
    Ok(format!(
        "{} and half an image: the board starts as before after each",
        cases.map(|(what, ..)| what).join(", ")
    ))
}

/// After a restart it is as it was.
fn still(bench: &mut Bench, what: &str) -> Result<()> {
    bench.restart()?;
    bench.expect(Seen::kept(Version::OWN, 1), what)
}

/// Half an image cannot be finished.
fn half(bench: &mut Bench) -> Result<()> {
    let image = Image::sign(
        DEVELOPMENT_SEED,
        BOARD,
        Version::OWN,
        vec![0x5A; BODY_BYTES],
    )?;
    let header = Vec::from_slice(&image.header.encode()).ok();
    bench.ask(UpdateOrder::Begin {
        header: header.context("a header's length")?,
        allow_older: false,
    })?;
    bench.ask(UpdateOrder::Piece {
        offset: 0,
        bytes: Vec::from_slice(&image.body[..256]).unwrap_or_default(),
    })?;
    let told = match bench.ask(UpdateOrder::Finish) {
        Ok(_) => bail!("found half an image taken for a whole one"),
        Err(error) => format!("{error:#}"),
    };
    ensure!(
        told.contains("256 bytes of the image, wanted 3000"),
        "found {told:?}, wanted how much is missing"
    );
    Ok(())
}
