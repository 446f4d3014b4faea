//! The images, what each needs, and what must be so of each.

use super::sizes::{CCM, CCM_LIMIT, CCM_START, FLASH_LIMIT, RAM_LIMIT, RAM_START, Sizes};
use crate::arm::root;
use crate::stack::{CallGraph, readable};
use anyhow::{Context, Result, bail, ensure};
use object::{Object, ObjectSection, SectionFlags, SectionKind};
use std::path::Path;

/// The worst stack, times this, must fit beside the data: 30 % to spare.
const STACK_SPARE: f64 = 1.3;
/// What an exception pushes with the floating-point registers, and the alignment it may add.
const EXCEPTION_FRAME: u32 = 26 * 4 + 4;

/// The intake of frames, in every image: the lowest interrupt.
const INTAKE: &str = "PendSV";

/// An image: its name (feature and binary) and its interrupts, by priority: those of sampling, the looks for a hang, then those that critical
/// sections hold back, above [`INTAKE`].
pub struct Image {
    /// Feature and binary.
    pub name: &'static str,
    sampling: &'static [&'static str],
    looks: &'static [&'static str],
    below: &'static [&'static str],
    /// RAM that it may use, bytes. The emulated board has no CCM RAM: what lies there on the sensor board lies with the rest.
    ram_limit: u32,
    /// What the sampling interrupts call outside the CCM RAM, where the flash makes them wait: only what is rare, each with the reason.
    rare: &'static [&'static str],
}

/// What the sensor board's sampling interrupts call in flash, and with it all that these call.
const RARE: &[&str] = &[
    // Once for each chip that has been set anew.
    "courier_sensor::drivers::converter::Converter<A,B,Convst,Reset,Busy>::set_chip",
];

/// Both images. A further board is a line here.
pub const IMAGES: [Image; 2] = [
    Image {
        name: "g474",
        sampling: &["EXTI9_5", "DMA1_CHANNEL2"],
        looks: &["SysTick", "WWDG"],
        below: &["USART1"],
        ram_limit: RAM_LIMIT,
        rare: RARE,
    },
    Image {
        name: "emulated",
        sampling: &["isr_sampling"],
        looks: &["SysTick"],
        below: &[],
        ram_limit: RAM_LIMIT + CCM_LIMIT,
        rare: &[],
    },
];

impl Image {
    /// Reads an image's needs.
    ///
    /// # Errors
    /// The file cannot be read.
    pub fn measure(&self, file: &Path) -> Result<Sizes> {
        let bytes = std::fs::read(file).with_context(|| file.display().to_string())?;
        let elf = object::File::parse(&*bytes).with_context(|| file.display().to_string())?;
        let (mut flash, mut ram, mut ccm) = (vec![], vec![], vec![]);
        for section in elf
            .sections()
            .filter(|section| section.size() > 0 && is_loaded(section))
        {
            let (name, size) = (
                section.name().unwrap_or_default().to_owned(),
                section.size() as u32,
            );
            match section.address() {
                RAM_START.. => ram.push((name.clone(), size)),
                CCM_START.. => ccm.push((name.clone(), size)),
                _ => flash.push((name.clone(), size)),
            }
            // What start-up copies into RAM lies in flash too.
            if section.address() >= CCM_START && section.kind() != SectionKind::UninitializedData {
                flash.push((name, size));
            }
        }
        let graph = CallGraph::of(file)?;
        let mut contexts = vec![];
        for root in ["main"]
            .iter()
            .chain(self.looks)
            .chain(self.sampling)
            .chain(self.below)
            .chain(&[INTAKE, "HardFault", "NonMaskableInt"])
        {
            contexts.push((
                (*root).to_owned(),
                graph.worst(&self.symbol(&graph, root)?)?,
            ));
        }
        let worst = |names: &[&str]| {
            let of = contexts
                .iter()
                .filter(|(name, _)| names.contains(&name.as_str()));
            of.map(|(_, worst)| worst.bytes + EXCEPTION_FRAME)
                .max()
                .unwrap_or(0)
        };
        // One priority runs one interrupt at a time; each may lie on top of the one below.
        let stack_bytes = worst(&["main"]) - EXCEPTION_FRAME
            + worst(&[INTAKE])
            + worst(self.below)
            + self.looks.iter().map(|look| worst(&[look])).sum::<u32>()
            + worst(self.sampling)
            + worst(&["NonMaskableInt"])
            + worst(&["HardFault"]);
        Ok(Sizes {
            flash,
            ram,
            ccm,
            contexts,
            stack_bytes,
            ram_limit: self.ram_limit,
        })
    }

    /// The mangled name of a root.
    fn symbol(&self, graph: &CallGraph, root: &str) -> Result<String> {
        graph
            .named(root)
            .with_context(|| format!("{}: no function {root}", self.name))
    }

    /// Fails if an image does not fit, holds a path of this machine, or if the sampling interrupt can reach a panic.
    ///
    /// # Errors
    /// What it is, with both numbers.
    pub fn check(&self, file: &Path, sizes: &Sizes) -> Result<()> {
        let name = self.name;
        for (kind, bytes, limit) in [
            ("flash", sizes.flash_bytes(), FLASH_LIMIT),
            ("RAM", sizes.ram_bytes(), sizes.ram_limit),
            ("CCM RAM", sizes.ccm_bytes(), CCM_LIMIT),
        ] {
            ensure!(
                bytes <= limit,
                "{name}: {bytes} bytes of {kind}, limit {limit}"
            );
        }
        let wanted = (f64::from(sizes.stack_bytes) * STACK_SPARE) as u32;
        ensure!(
            wanted <= sizes.stack_room(),
            "{name}: worst stack {} bytes, {wanted} with 30 % to spare; data leave {} of {}",
            sizes.stack_bytes,
            sizes.stack_room(),
            sizes.ram_limit
        );
        no_path_of_this_machine(name, file)?;
        let graph = CallGraph::of(file)?;
        for root in self.sampling {
            let (reach, register) = graph.reach(&self.symbol(&graph, root)?)?;
            let panics = reach
                .iter()
                .map(|name| readable(name))
                .find(|name| is_panic(name));
            ensure!(
                panics.is_none(),
                "{name}: the sampling interrupt {root} can reach {}",
                panics.unwrap_or_default()
            );
            ensure!(
                !register,
                "{name}: the sampling interrupt {root} calls through a register"
            );
        }
        if sizes.ccm_bytes() > 0 {
            self.check_places(&graph)?;
        }
        self.check_masks(&graph)
    }

    /// Fails if a sampling interrupt reaches a function in flash that is not known to be rare (`memory.x` says what lies where).
    fn check_places(&self, graph: &CallGraph) -> Result<()> {
        for root in self.sampling {
            let outside = graph.reach_outside(&self.symbol(graph, root)?, &CCM)?;
            let is_rare = |name: &&String| self.rare.contains(&name.as_str());
            let unknown: Vec<&String> = outside.iter().filter(|name| !is_rare(name)).collect();
            ensure!(
                unknown.is_empty(),
                "{}: {root} reaches {unknown:?} outside the CCM RAM, wanted there only {:?}",
                self.name,
                self.rare
            );
        }
        Ok(())
    }

    /// Fails if an interrupt that no critical section holds back can itself hold interrupts back: the sections are sound only without that
    /// (`src/board/critical.rs`). The main loop does, in each log line: a check that did not see that would be blind.
    fn check_masks(&self, graph: &CallGraph) -> Result<()> {
        let name = self.name;
        let masks = |root: &str| graph.masks(&self.symbol(graph, root)?);
        for root in self.sampling.iter().chain(self.looks) {
            if let Some(chain) = masks(root)? {
                bail!(
                    "{name}: {root} can hold interrupts back: {}",
                    chain.join(" > ")
                );
            }
        }
        ensure!(
            masks("main")?.is_some(),
            "{name}: found no critical section in reach of main, wanted those of its log lines"
        );
        Ok(())
    }
}

/// Fails if a folder of this machine got into an image, its debug information included: two builds of the same source
/// would differ.
fn no_path_of_this_machine(name: &str, file: &Path) -> Result<()> {
    let bytes = std::fs::read(file).with_context(|| file.display().to_string())?;
    for folder in [Some(root()), std::env::home_dir()].into_iter().flatten() {
        let folder = folder.display();
        ensure!(
            !holds_folder(&bytes, &folder.to_string()),
            "{name}: found {folder} in the image"
        );
    }
    Ok(())
}

/// Whether a path that begins with `folder` is among the bytes: not `./src/a.rs` for `/src`.
fn holds_folder(bytes: &[u8], folder: &str) -> bool {
    let of_path = |byte: u8| byte.is_ascii_alphanumeric() || b"._-".contains(&byte);
    bytes.windows(folder.len() + 2).any(|window| {
        let (before, path, behind) = (
            window[0],
            &window[1..=folder.len()],
            window[folder.len() + 1],
        );
        folder.len() > 1
            && path == folder.as_bytes()
            && !of_path(before)
            && b"/\0".contains(&behind)
    })
}

fn is_loaded(section: &object::Section<'_, '_>) -> bool {
    const ALLOCATED: u64 = 2;
    matches!(section.flags(), SectionFlags::Elf { sh_flags } if sh_flags & ALLOCATED != 0)
}

fn is_panic(name: &str) -> bool {
    name.contains("panic") || name.contains("unwrap_failed") || name.contains("expect_failed")
}

#[cfg(test)]
mod tests {
    use super::holds_folder;

    #[test]
    fn a_folder_of_this_machine_is_told_from_a_part_of_another_path() {
        assert!(holds_folder(b"\0/home/me/src/lib.rs\0", "/home/me"));
        assert!(holds_folder(b"\0/home/me\0", "/home/me"));
        assert!(!holds_folder(b"\0./src/lib.rs\0", "/src"));
        assert!(!holds_folder(b"\0/home/men/lib.rs\0", "/home/me"));
        assert!(!holds_folder(b"\0/a/b\0", "/"));
    }
}
