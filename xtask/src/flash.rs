//! `cargo flash`: writes the g474 image to the board behind a debug probe.
//!
//! Whether there is a probe is asked of the kernel first, so that nobody waits for a build only to hear that there is none.

use crate::arm::{self, say};
use crate::firmware;
use anyhow::Result;
use std::fs;
use std::path::Path;
use std::process::Command;

/// Vendors of debug probes: STMicroelectronics, SEGGER, Arm, Raspberry Pi.
const VENDORS: [&str; 4] = ["0483", "1366", "0d28", "2e8a"];
/// What a probe of any vendor says of itself.
const PRODUCTS: [&str; 4] = ["cmsis-dap", "st-link", "stlink", "j-link"];

/// The command. One word: the probe's selector, as `courier --probe` takes it.
///
/// # Errors
/// The image cannot be built or written. Without a probe the process ends with code 2.
pub fn run(arguments: &[String]) -> Result<()> {
    if probes().is_empty() {
        eprintln!(
            "flash: no debug probe found, wanted one on the board's SWD header and on this machine's USB"
        );
        std::process::exit(2);
    }
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
        "probe",
        "--bin",
        "write",
        "--",
    ]);
    arm::run(command.arg(image).args(arguments))
}

/// Names of the USB devices that are debug probes.
fn probes() -> Vec<String> {
    let Ok(devices) = fs::read_dir("/sys/bus/usb/devices") else {
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
