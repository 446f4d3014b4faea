//! The same bits on this machine and on the emulated Cortex-M4F: signal path, whole recordings, Givens rows, solve.

use crate::arm::{self, say};
use crate::plugin::{self, Build};
use crate::recordings;
use anyhow::{Context, Result, ensure};
use cases::encoder::{TURN, Turns};
use cases::parity::{INPUTS, ROWS, frames, rows, signal};
use cases::setups::Setup;
use cases::{PACKED, UNKNOWNS};
use courier_sensor::encoder::Learner;
use courier_sensor::lsq::Estimator;
use std::path::Path;

/// Compares digests of every bit over all generated inputs and over whole recordings.
///
/// # Errors
/// The first one that differs, with both.
pub fn check() -> Result<()> {
    let image = plugin::build_image(&arm::ensure()?, Build::Firmware)?;
    generated(&image)?;
    recorded(&image)
}

fn generated(image: &Path) -> Result<()> {
    let there = plugin::run_image(image, &["parity"])?;
    for setup in Setup::ALL {
        compare(&there, &format!("signal {setup:?}"), signal(setup))?;
    }
    let mut estimator: Box<Estimator<UNKNOWNS, PACKED>> = Box::new(Estimator::new(UNKNOWNS));
    compare(&there, "rows", rows(&mut estimator))?;
    compare(
        &there,
        "encoder",
        cases::encoder::digest(&mut Learner::new(), &mut Turns::new(TURN)),
    )?;
    say(&format!(
        "{INPUTS} inputs of the signal path and {ROWS} Givens rows with their solutions, one encoder by itself: the same bits"
    ));
    Ok(())
}

fn recorded(image: &Path) -> Result<()> {
    let folder = arm::target_dir().join("parity");
    std::fs::create_dir_all(&folder).with_context(|| folder.display().to_string())?;
    // A name without what QEMU's option takes for a separator.
    let file = folder.join("frames.bin");
    for recording in recordings::all()? {
        std::fs::write(&file, recordings::bytes(&recording.frames))
            .with_context(|| file.display().to_string())?;
        let there = plugin::run_image(image, &["frames", &file.display().to_string()])?;
        for setup in Setup::ALL {
            let here = frames(setup, recording.frames.iter().copied());
            compare(&there, &format!("frames {setup:?}"), here)
                .with_context(|| recording.name.clone())?;
        }
        let (name, count) = (&recording.name, recording.frames.len());
        say(&format!("recording {name}, {count} samples: the same bits"));
    }
    Ok(())
}

/// Finds `name` in what the image said and compares its digest with this machine's.
fn compare(there: &str, name: &str, here: u64) -> Result<()> {
    let line = there.lines().find_map(|line| line.strip_prefix(name));
    let found = line
        .with_context(|| format!("parity: the image said nothing of {name}"))?
        .trim();
    let here = format!("{here:016x}");
    ensure!(
        found == here,
        "parity: {name}: found {found} on the Cortex-M4F, wanted {here} as here"
    );
    Ok(())
}
