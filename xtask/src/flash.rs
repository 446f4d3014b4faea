//! `cargo flash`: writes the g474 image to the board behind a debug probe.
//!
//! Whether there is a probe is asked of the kernel first, so that nobody waits for a build only to hear that there is none.

use crate::arm::{self, say};
use crate::firmware;
use anyhow::{Result, ensure};
use std::fmt;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Vendors of debug probes: STMicroelectronics, SEGGER, Arm, Raspberry Pi.
const VENDORS: [&str; 4] = ["0483", "1366", "0d28", "2e8a"];
/// What a probe of any vendor says of itself.
const PRODUCTS: [&str; 4] = ["cmsis-dap", "st-link", "stlink", "j-link"];

/// Where the kernel lists what is on USB.
const DEVICES: &str = "/sys/bus/usb/devices";

/// There is nothing to write with: the user's to mend, so that the process ends with code 2.
#[derive(Debug)]
pub struct NoProbe;

impl fmt::Display for NoProbe {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        f.write_str(
            "no debug probe found, wanted one on the board's SWD header and on this machine's USB",
        )
    }
}

impl std::error::Error for NoProbe {}

/// The command. One word: the probe's selector, as `courier --probe` takes it.
///
/// # Errors
/// [`NoProbe`], or the image cannot be built or written.
pub fn run(arguments: &[String]) -> Result<()> {
    ensure!(
        arguments.len() <= 1,
        "found {arguments:?}, wanted at most a probe's selector"
    );
    ensure!(is_there_a_probe(), NoProbe);
    let image = firmware::build(&arm::ensure()?, "g474")?;
    say("building the writer (probe-rs: some minutes, once)");
    let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
    let mut command = Command::new(cargo);
    command.current_dir(arm::root());
    command.args([
        "run",
        "--quiet",
        "--release",
        "--package",
        "link-host",
        "--features",
        "probe,chips",
        "--bin",
        "write",
        "--",
    ]);
    arm::run(command.arg(image).args(arguments))
}

/// Whether a debug probe is on this machine's USB.
pub fn is_there_a_probe() -> bool {
    !probes(Path::new(DEVICES)).is_empty()
}

/// Names of the debug probes among the USB devices that have a folder each.
fn probes(devices: &Path) -> Vec<String> {
    let Ok(devices) = fs::read_dir(devices) else {
        return vec![];
    };
    let probe = |folder: &Path| {
        let read = |name: &str| {
            fs::read_to_string(folder.join(name))
                .unwrap_or_default()
                .trim()
                .to_lowercase()
        };
        let (vendor, product) = (read("idVendor"), read("product"));
        let named = PRODUCTS.iter().any(|known| product.contains(known));
        (named || (VENDORS.contains(&vendor.as_str()) && product.contains("debug")))
            .then_some(product)
    };
    devices
        .flatten()
        .filter_map(|device| probe(&device.path()))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use std::process::Command;

    #[test]
    fn probes_are_told_from_what_else_is_on_usb() {
        let folder = std::env::temp_dir().join(format!("courier-usb-{}", std::process::id()));
        let mut wanted = vec![];
        for (vendor, product, is_probe) in [
            ("0483", "STLINK-V3", true),
            ("1d50", "Some CMSIS-DAP", true),
            ("2e8a", "Debug Probe", true),
            ("2e8a", "Pico", false),
            ("046d", "USB Keyboard", false),
        ] {
            let device = folder.join(product);
            fs::create_dir_all(&device).unwrap();
            fs::write(device.join("idVendor"), format!("{vendor}\n")).unwrap();
            fs::write(device.join("product"), format!("{product}\n")).unwrap();
            wanted.extend(is_probe.then(|| product.to_lowercase()));
        }
        let mut found = probes(&folder);
        fs::remove_dir_all(&folder).unwrap();
        found.sort();
        wanted.sort();
        assert_eq!(found, wanted);
        assert!(probes(&folder).is_empty(), "no such folder");
    }

    /// As the user runs it; with a probe on this machine it would write what is behind it, so that it is left out.
    #[test]
    fn without_a_probe_it_is_one_line_and_code_2() {
        if is_there_a_probe() {
            eprintln!("skipped: there is a debug probe on this machine");
            return;
        }
        let cargo = std::env::var_os("CARGO").unwrap_or_else(|| "cargo".into());
        for (words, name) in [
            (&["flash"][..], "flash"),
            (&["xtask", "option-bytes", "--yes"], "option-bytes"),
        ] {
            let mut command = Command::new(&cargo);
            command.current_dir(arm::root()).args(words);
            let output = command.output().unwrap();
            let told = String::from_utf8_lossy(&output.stderr);
            assert_eq!(output.status.code(), Some(2), "{told}");
            assert_eq!(told.trim_end(), format!("xtask {name}: {NoProbe}"));
            assert!(output.stdout.is_empty());
        }
    }
}
