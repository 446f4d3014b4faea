//! `cargo xtask setup`: says what the emulated board lacks here, asks, installs it, and builds the board's image.

use crate::{arm, firmware, permission};
use anyhow::{Result, bail, ensure};
use std::io::{BufRead, IsTerminal, Write};

/// Says what it will do, and does it if the user agrees. Words: `--yes` agrees beforehand.
///
/// # Errors
/// The user does not agree, or something cannot be installed or built.
pub fn run(arguments: &[String]) -> Result<()> {
    let yes = match arguments {
        [] => false,
        [word] if word == "--yes" => true,
        [word, ..] => bail!("found {word:?}, wanted --yes or nothing"),
    };
    let steps = steps();
    if steps.is_empty() {
        eprintln!(
            "setup: everything is there; building the image, which takes minutes the first time"
        );
    } else {
        eprintln!("setup: will run, then build the image:");
        steps.iter().for_each(|step| eprintln!("setup:   {step}"));
        ensure!(
            yes || agreed()?,
            "not agreed, so nothing was installed; `cargo xtask setup --yes` agrees"
        );
    }
    permission::grant();
    firmware::images()
}

/// What is missing here, as the commands that bring it.
fn steps() -> Vec<String> {
    let program = |name: &str| (!arm::on_path(name)).then(|| format!("apt-get install {name}"));
    arm::missing()
        .into_iter()
        .chain(program("qemu-system-arm"))
        .chain(firmware::missing_linker())
        .collect()
}

/// Asks on the terminal; where there is none, nobody agrees.
fn agreed() -> Result<bool> {
    if !std::io::stdin().is_terminal() {
        return Ok(false);
    }
    eprint!("setup: go on? [y/N] ");
    std::io::stderr().flush()?;
    let mut answer = String::new();
    std::io::stdin().lock().read_line(&mut answer)?;
    Ok(matches!(answer.trim(), "y" | "Y" | "yes"))
}
