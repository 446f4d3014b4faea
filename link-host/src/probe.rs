//! A board behind a debug probe.

use crate::memory::TargetMemory;
use crate::rtt::Rtt;
use anyhow::{Context, Result, bail};
use board_link::Wire;
use probe_rs::probe::list::{Accessibility, Lister};
use probe_rs::probe::{DebugProbeInfo, DebugProbeSelector};
use probe_rs::{Core, MemoryInterface, Permissions, Session};
use std::time::Duration;

/// The chip, as probe-rs names it.
pub const CHIP: &str = "STM32G474RETx";
/// Its RAM.
const RAM: (u32, u32) = (0x2000_0000, 128 << 10);
/// The ring of commands.
const COMMAND_CHANNEL: usize = 0;

/// A probe that is there and may be opened.
pub struct Found(DebugProbeInfo);

impl Found {
    /// Its vendor, product and serial number.
    #[must_use]
    pub fn name(&self) -> String {
        let Self(info) = self;
        let serial = info.serial_number.as_deref().unwrap_or_default();
        format!(
            "probe-{:04x}-{:04x}-{serial}",
            info.vendor_id, info.product_id
        )
    }

    /// Opens it.
    fn attach(&self) -> Result<Session> {
        let wanted = "debug probe: wanted one that no other program has open";
        let probe = self.0.open().context(wanted)?;
        probe
            .attach(CHIP, Permissions::default())
            .with_context(|| format!("no {CHIP} behind the probe"))
    }
}

/// Opens the probe that `selector` names (VID:PID or VID:PID:serial, hexadecimal), or the only one there is.
///
/// # Errors
/// As [`find`], or the chip does not answer.
pub fn attach(selector: Option<&str>) -> Result<Session> {
    find(selector)?.attach()
}

/// Finds the probe that `selector` names, or the only one there is.
///
/// # Errors
/// No such probe, more than one, or one that may not be opened.
pub fn find(selector: Option<&str>) -> Result<Found> {
    let wanted = selector.map(parsed).transpose()?;
    let found = Lister::new().list_with_access(wanted.as_ref());
    match found.as_slice() {
        [] => bail!(
            "no debug probe {}found: connect one to the board's SWD header and to this machine",
            selector.map_or(String::new(), |text| format!("{text} "))
        ),
        [one] if one.accessibility == Accessibility::PermissionDenied => bail!(
            "{}: found no permission to open it, wanted a udev rule for this user",
            one.info
        ),
        [one] => Ok(Found(one.info.clone())),
        several => {
            let names: Vec<String> = several.iter().map(|probe| probe.info.to_string()).collect();
            bail!(
                "found {} debug probes, wanted a selector for one of: {}",
                several.len(),
                names.join("; ")
            )
        }
    }
}

fn parsed(text: &str) -> Result<DebugProbeSelector> {
    let selector = text.parse().ok();
    selector.with_context(|| {
        format!("probe: found {text:?}, wanted `any` or VENDOR:PRODUCT[:SERIAL] in hexadecimal")
    })
}

/// A running board. The processor is not halted.
pub struct Probed {
    session: Session,
    /// Where the rings were found last.
    at: u32,
    rtt: Rtt,
}

impl Probed {
    /// Finds the running image's rings.
    ///
    /// # Errors
    /// The probe cannot be opened, the chip does not answer, or no image with this project's debug link runs.
    pub fn open(probe: &Found) -> Result<Self> {
        let mut session = probe.attach()?;
        let mut core = session.core(0).context("processor")?;
        let mut memory = ProbeMemory(&mut core);
        let found = Rtt::find(&mut memory, None, RAM)?;
        drop(core);
        let (at, rtt) = found
            .context("the board runs no firmware with a debug link: write it with `cargo flash`")?;
        Ok(Self { session, at, rtt })
    }
}

/// Memory through a probe.
pub struct ProbeMemory<'a, 'p>(pub &'a mut Core<'p>);

impl TargetMemory for ProbeMemory<'_, '_> {
    fn read(&mut self, address: u32, bytes: &mut [u8]) -> Result<()> {
        self.0
            .read(u64::from(address), bytes)
            .with_context(|| format!("{address:#x}"))
    }

    fn write(&mut self, address: u32, bytes: &[u8]) -> Result<()> {
        self.0
            .write(u64::from(address), bytes)
            .with_context(|| format!("{address:#x}"))
    }

    fn read_word(&mut self, address: u32) -> Result<u32> {
        self.0
            .read_word_32(u64::from(address))
            .with_context(|| format!("{address:#x}"))
    }

    fn write_word(&mut self, address: u32, word: u32) -> Result<()> {
        self.0
            .write_word_32(u64::from(address), word)
            .with_context(|| format!("{address:#x}"))
    }
}

impl Wire for Probed {
    fn receive(&mut self, channel: usize, bytes: &mut [u8]) -> Result<usize> {
        let mut core = self.session.core(0).context("processor")?;
        self.rtt.read(&mut ProbeMemory(&mut core), channel, bytes)
    }

    fn send(&mut self, bytes: &[u8]) -> Result<usize> {
        let mut core = self.session.core(0).context("processor")?;
        let mut memory = ProbeMemory(&mut core);
        // After a restart another image may run.
        let Some((at, rtt)) = Rtt::find(&mut memory, Some(self.at), RAM)? else {
            return Ok(0);
        };
        (self.at, self.rtt) = (at, rtt);
        self.rtt.write(&mut memory, COMMAND_CHANNEL, bytes)
    }

    fn pass(&mut self, time: Duration) -> Result<()> {
        std::thread::sleep(time);
        Ok(())
    }
}
