//! Writes an image to the board behind a debug probe: `write IMAGE [SELECTOR]`. Run by `cargo flash`.

use anyhow::{Context, Result, bail};
use link_host::outdated::OUTDATED;
use link_host::probe::attach;
use probe_rs::flashing::{DownloadOptions, ElfLoader, ElfOptions, build_loader};
use std::time::Duration;

/// What an erased byte of flash reads as.
const ERASED: u8 = 0xFF;

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let (image, selector) = match words.as_slice() {
        [image] => (image, None),
        [image, selector] => (image, Some(selector.as_str())),
        other => bail!("found {other:?}, wanted an image and at most a probe's selector"),
    };
    let mut session = attach(selector.filter(|name| *name != "any"))?;
    let format = ElfLoader(ElfOptions::default());
    let mut loader =
        build_loader(&mut session, image, format, None).with_context(|| image.clone())?;
    for page in OUTDATED {
        // A page that is to hold nothing but erased bytes is erased.
        loader.add_data(page.start.into(), &vec![ERASED; page.len()])?;
    }
    // This resets the chip first, so that both banks lie where they are after a reset.
    loader
        .commit(&mut session, DownloadOptions::default())
        .with_context(|| image.clone())?;
    session
        .core(0)?
        .reset_and_halt(Duration::from_millis(500))?;
    session.core(0)?.run()?;
    println!("{image}: written and started");
    Ok(())
}
