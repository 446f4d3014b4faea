//! Sets the option bytes of the board behind a debug probe: `options [--yes] [SELECTOR]`. Run by `cargo xtask option-bytes`.

use anyhow::{Result, bail, ensure};
use courier_sensor::health::{option_faults, wanted_options};
use link_host::option_bytes::{launch, program, read};
use link_host::probe::{ProbeMemory, attach};
use probe_rs::Session;
use std::io::{BufRead, IsTerminal, Write};
use std::time::Duration;

/// What halting the processor may take, and a restart with new option bytes.
const PATIENCE: Duration = Duration::from_millis(500);

fn main() -> Result<()> {
    let words: Vec<String> = std::env::args().skip(1).collect();
    let (yes, rest): (Vec<&String>, Vec<&String>) = words.iter().partition(|word| *word == "--yes");
    let selector = match rest.as_slice() {
        [] => None,
        [selector] => Some(selector.as_str()),
        other => bail!("found {other:?}, wanted at most --yes and a probe's selector"),
    };
    let selector = selector.filter(|name| *name != "any");
    let mut session = attach(selector)?;
    let now = look(&mut session)?;
    let wanted = wanted_options(now);
    if now == wanted {
        println!("option bytes {now:#010x}: as wanted");
        return Ok(());
    }
    println!("option bytes {now:#010x}, to be {wanted:#010x}:");
    for fault in option_faults(now) {
        println!("  {fault}");
    }
    ensure!(
        !yes.is_empty() || agreed()?,
        "option bytes: nothing was set; --yes sets them without asking"
    );
    {
        let mut core = session.core(0)?;
        core.halt(PATIENCE)?;
        let mut memory = ProbeMemory(&mut core);
        program(&mut memory, wanted)?;
        launch(&mut memory);
    }
    drop(session);
    std::thread::sleep(PATIENCE);
    let found = look(&mut attach(selector)?)?;
    ensure!(
        found == wanted,
        "option bytes: found {found:#010x} after the restart, wanted {wanted:#010x}"
    );
    println!("option bytes {found:#010x}: set, and the board restarted");
    Ok(())
}

fn look(session: &mut Session) -> Result<u32> {
    let mut core = session.core(0)?;
    read(&mut ProbeMemory(&mut core))
}

/// Whether the user agrees; no if nobody can be asked.
fn agreed() -> Result<bool> {
    let input = std::io::stdin();
    if !input.is_terminal() {
        return Ok(false);
    }
    print!("Set them? The board restarts. [y/N] ");
    std::io::stdout().flush()?;
    let mut answer = String::new();
    input.lock().read_line(&mut answer)?;
    Ok(matches!(answer.trim(), "y" | "Y" | "yes"))
}
