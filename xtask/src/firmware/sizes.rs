//! What an image needs, beside what it may use.

use crate::arm::root;
use crate::stack::Worst;
use serde_json::{Value, json};
use std::ops::Range;
use std::path::Path;

/// Limits of both images, bytes. Flash: bank 1 of the STM32G474RE without 16 KiB, since an image that is to lie in bank 2
/// lies there beside the calibration slots. RAM: SRAM1 and SRAM2 (80 and 16 KiB), and the CCM RAM by itself (data sheet DS12288).
pub const FLASH_LIMIT: u32 = 224 << 10;
pub const RAM_LIMIT: u32 = 96 << 10;
pub const CCM_LIMIT: u32 = 32 << 10;
/// Where the CCM RAM and the others begin (RM0440, memory map).
pub const CCM_START: u64 = 0x1000_0000;
pub const RAM_START: u64 = 0x2000_0000;
pub const CCM: Range<u64> = CCM_START..CCM_START + CCM_LIMIT as u64;

/// What an image needs.
pub struct Sizes {
    /// Sections that take flash.
    pub flash: Vec<(String, u32)>,
    /// Sections that take RAM, the stack not among them.
    pub ram: Vec<(String, u32)>,
    /// Sections that take CCM RAM.
    pub ccm: Vec<(String, u32)>,
    /// Worst stack of each context.
    pub contexts: Vec<(String, Worst)>,
    /// All contexts on top of one another, exception frames included.
    pub stack_bytes: u32,
    /// RAM that the image may use.
    pub ram_limit: u32,
}

impl Sizes {
    /// All flash.
    pub fn flash_bytes(&self) -> u32 {
        together(&self.flash)
    }

    /// All CCM RAM.
    pub fn ccm_bytes(&self) -> u32 {
        together(&self.ccm)
    }

    /// RAM without the stack.
    fn data_bytes(&self) -> u32 {
        together(&self.ram)
    }

    /// All RAM: data and worst stack.
    pub fn ram_bytes(&self) -> u32 {
        self.data_bytes() + self.stack_bytes
    }

    /// What the limit leaves to the stack.
    pub fn stack_room(&self) -> u32 {
        self.ram_limit.saturating_sub(self.data_bytes())
    }

    /// As the bench's JSON has it.
    pub fn json(&self) -> Value {
        json!({
            "flash_bytes": self.flash_bytes(),
            "ram_bytes": self.ram_bytes(),
            "ccm_bytes": self.ccm_bytes(),
            "stack_worst_bytes": self.stack_bytes,
        })
    }
}

fn together(sections: &[(String, u32)]) -> u32 {
    sections.iter().map(|(_, bytes)| bytes).sum()
}

/// Prints it all; `name` is the image's.
pub fn print(name: &str, file: &Path, sizes: &Sizes) {
    println!(
        "{} ({})",
        name,
        file.strip_prefix(root()).unwrap_or(file).display()
    );
    for (kind, sections, total, limit) in [
        ("flash", &sizes.flash, sizes.flash_bytes(), FLASH_LIMIT),
        ("CCM", &sizes.ccm, sizes.ccm_bytes(), CCM_LIMIT),
        ("RAM", &sizes.ram, sizes.ram_bytes(), sizes.ram_limit),
    ] {
        for (section, bytes) in sections {
            println!("  {kind:<6} {section:<16} {bytes:>8} B");
        }
        if kind == "RAM" {
            println!(
                "  {kind:<6} {:<16} {:>8} B",
                "worst stack", sizes.stack_bytes
            );
        }
        println!(
            "  {kind:<6} {:<16} {total:>8} B of {limit}, {} B left",
            "together",
            limit.saturating_sub(total)
        );
    }
    for (context, worst) in &sizes.contexts {
        let link = |(name, bytes): &(String, u32)| format!("{} {bytes}", short(name));
        let chain: Vec<String> = worst.chain.iter().map(link).collect();
        println!(
            "  stack  {context:<16} {:>8} B  {}",
            worst.bytes,
            chain.join(" > ")
        );
        if worst.through_register {
            println!(
                "         calls through a register are bounded by the worst function whose address is taken"
            );
        }
        if !worst.recursive.is_empty() {
            println!(
                "         not bounded here, counted once: {}",
                worst.recursive.join(", ")
            );
        }
    }
    let room = sizes.stack_room();
    let spare = 100.0 * (f64::from(room) / f64::from(sizes.stack_bytes.max(1)) - 1.0);
    println!(
        "  stack  {:<16} {:>8} B  of {room} B left of {}, {spare:.0} % to spare",
        "all together", sizes.stack_bytes, sizes.ram_limit
    );
}

/// The last part of a path, without what stands in angle brackets.
fn short(name: &str) -> &str {
    let mut depth = 0_usize;
    let outside = |c: char| {
        depth = match c {
            '<' => depth + 1,
            '>' => depth.saturating_sub(1),
            _ => depth,
        };
        depth == 0 && c == ':'
    };
    let parts = name
        .split(outside)
        .map(|part| part.split('<').next().unwrap_or(part));
    parts.filter(|part| !part.is_empty()).last().unwrap_or(name)
}
