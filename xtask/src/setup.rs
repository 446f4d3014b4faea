//! `cargo xtask setup`: says what the emulated board lacks here, asks, installs it, and builds the board's image. `setup chip`: the same
//! for the model of the chip.

use crate::{arm, chip, firmware, permission};
use anyhow::{Result, bail, ensure};
use std::io::{BufRead, IsTerminal, Write};

/// Says what it will do, and does it if the user agrees. Words: `chip` sets up the model of the chip, `--yes` agrees beforehand.
///
/// # Errors
/// The user does not agree, or something cannot be installed or built.
pub fn run(arguments: &[String]) -> Result<()> {
    if let Some(word) = arguments
        .iter()
        .find(|word| !["chip", "--yes"].contains(&word.as_str()))
    {
        bail!("found {word:?}, wanted chip, --yes or nothing");
    }
    let named = |wanted: &str| arguments.iter().any(|word| word == wanted);
    let (of_chip, yes) = (named("chip"), named("--yes"));
    let steps = steps(of_chip);
    if steps.is_empty() {
        eprintln!(
            "setup: everything is there; building the image, which takes minutes the first time"
        );
    } else {
        eprintln!("setup: will run, then build the image:");
        steps.iter().for_each(|step| eprintln!("setup:   {step}"));
        ensure!(
            yes || agreed()?,
            "not agreed, so nothing was installed; with the word --yes it agrees"
        );
    }
    permission::grant();
    match of_chip {
        true => chip::set_up(),
        false => firmware::images(),
    }
}

/// What is missing here, as the commands that bring it.
fn steps(of_chip: bool) -> Vec<String> {
    let program = |name: &str| (!arm::on_path(name)).then(|| format!("apt-get install {name}"));
    let own = match of_chip {
        true => chip::missing(),
        false => program("qemu-system-arm").into_iter().collect(),
    };
    arm::missing()
        .into_iter()
        .chain(own)
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
