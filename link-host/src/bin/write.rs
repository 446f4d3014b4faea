//! Writes an image to the board behind a debug probe: `write IMAGE [SELECTOR]`. Run by `cargo flash`.

use anyhow::{Context, Result, bail};
use link_host::probe::attach;
use probe_rs::flashing::{ElfLoader, ElfOptions, download_file};
use std::time::Duration;

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let (image, selector) = match words.as_slice() {
        [image] => (image, None),
        [image, selector] => (image, Some(selector.as_str())),
        other => bail!("found {other:?}, wanted an image and at most a probe's selector"),
    };
    let mut session = attach(selector.filter(|name| *name != "any"))?;
    download_file(&mut session, image, ElfLoader(ElfOptions::default()))
        .with_context(|| image.clone())?;
    session
        .core(0)?
        .reset_and_halt(Duration::from_millis(500))?;
    session.core(0)?.run()?;
    println!("{image}: written and started");
    Ok(())
}
