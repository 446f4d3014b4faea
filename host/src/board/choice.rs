//! The options by which a user names a board.

use super::ageing::{Ageing, ageing};
use super::claim::Claim;
use super::{chip, emulated};
use crate::demo::Preset;
use crate::output::{Files, check_folder_of, replace_file};
use anyhow::{Context, Result, ensure};
use board_link::session::Linked;
use board_link::{Link, SimWire, Wire};
use clap::ValueEnum;
use courier_sensor::drivers::motion::Target;
use courier_sensor::update::layout::{LOG_END, MAPS_END, MAPS_START, PAGE_BYTES, SLOTS_START};
use effects::motion::Pose;
use effects::plant::{Geometry, PlantEffect, Scene};
use effects::random::{ChaCha8Rng, SeedableRng};
use embedded_storage::nor_flash::NorFlash;
use hal_sim::beacon_fault::{BeaconFault, FaultyBeacon};
use hal_sim::board::SharedFlash;
use hal_sim::presets::{DEFAULT_RMS_M, of_the_make};
use hal_sim::spec::CourierSpec;
use hal_sim::wire::motion::ControllerConfig;
use hal_sim::wire_fault::ExchangedSegments;
use hal_sim::world::{Mark, World};
use std::ops::Range;
use std::path::{Path, PathBuf};

/// Which board to talk to; the simulated one if none is named.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "Board")]
pub struct Choice {
    /// The simulated board, switched on for this command (the default).
    #[arg(long, global = true, group = "board")]
    sim: bool,
    /// The firmware's image on an emulated Cortex-M4F, its courier simulated.
    #[arg(long, global = true, group = "board")]
    emulated: bool,
    /// The image as it ships on a model of its chip, its courier simulated; a second takes 3 to 5.
    #[arg(long, global = true, group = "board")]
    chip: bool,
    /// A board on a debug probe: `any`, or VENDOR:PRODUCT[:SERIAL] in hexadecimal.
    #[arg(long, global = true, group = "board", value_name = "SELECTOR")]
    probe: Option<String>,
    /// Simulated courier [default: paper].
    #[arg(long, global = true, value_enum, value_name = "PRESET")]
    sim_preset: Option<Preset>,
    /// Its seed [default: 1].
    #[arg(long, global = true, value_name = "N")]
    sim_seed: Option<u64>,
    /// Another courier of the paper's make, drawn by this number: its own waves, diode, mounts and place to be switched on.
    #[arg(long, global = true, value_name = "N")]
    sim_courier: Option<u64>,
    /// Another platen of that make under it, drawn by this number.
    #[arg(long, global = true, value_name = "N")]
    sim_platen: Option<u64>,
    /// Give it a catalogued effect of that size, µm rms: `velocity_lag=2`; may be repeated. `stray_field:logged=2` is the drive's own field,
    /// by µm an ampere of a current that `record` logs as aux_motor_a; without the word it is a magnet's beside the platen.
    #[arg(long, global = true, value_name = "EFFECT[:logged]=UM", value_parser = flaw)]
    sim_effect: Vec<Flaw>,
    /// What changes of it in service, at a second since it was switched on or between two: `wave:2:4=0.6@30` (segment, order, µm rms),
    /// `weak-magnets:3=10@0..600` (segment, percent lost), `knock:1=2@30` (segment, µm), `platen=2@30` (another one, teeth of so many µm),
    /// `days=3@600` (temperature, K either way, a day lasting so many seconds); may be repeated.
    #[arg(long, global = true, value_name = "CHANGE@SECONDS", value_parser = ageing)]
    sim_age: Vec<Ageing>,
    /// Something wrong with its beacon, the light around it or its wires; may be repeated.
    #[arg(long, global = true, value_enum, value_name = "FAULT")]
    sim_fault: Vec<Fault>,
    /// Put an end stop on the simulated board's input for a reference mark: on from so many mm on along x or y, as `x=3`.
    #[arg(long, global = true, value_name = "AXIS=MM", value_parser = end_stop)]
    sim_mark: Option<Mark>,
    /// Keep the simulated board's flash in this file, so that what one command stores the next one finds.
    #[arg(long, global = true, value_name = "FILE")]
    sim_flash: Option<PathBuf>,
}

/// What `--sim-fault` names.
#[derive(Clone, Copy, Debug, PartialEq, Eq, ValueEnum)]
enum Fault {
    /// The beacon comes and goes.
    BeaconBlinks,
    /// A second beacon is switched on.
    SecondBeacon,
    /// A second, weaker beacon is there from the start.
    SecondBeaconFromStart,
    /// Stray light drives an electrode to the converter's end.
    StrayLight,
    /// Segments 1 and 2 are wired to each other's inputs.
    SegmentsExchanged,
    /// Segments 1 and 3 are wired to the inputs of 2 and 4, and the other way round.
    AxesExchanged,
}

impl Fault {
    fn effect(self) -> Box<dyn PlantEffect> {
        let beacon = |fault: BeaconFault| Box::new(FaultyBeacon::new(fault));
        match self {
            Self::BeaconBlinks => beacon(BeaconFault::Blinks),
            Self::SecondBeacon => beacon(BeaconFault::Second),
            Self::SecondBeaconFromStart => beacon(BeaconFault::SecondFromStart),
            Self::StrayLight => beacon(BeaconFault::StrayLight),
            Self::SegmentsExchanged => Box::new(ExchangedSegments(&[[0, 1]])),
            Self::AxesExchanged => Box::new(ExchangedSegments(&[[0, 1], [2, 3]])),
        }
    }
}

/// What `--sim-effect` names.
#[derive(Clone)]
struct Flaw {
    effect: &'static dyn effects::Effect,
    /// It follows a quantity that is logged.
    logged: bool,
    rms_m: f64,
}

impl Flaw {
    fn draw(&self, scene: &Scene, rng: &mut ChaCha8Rng) -> Option<Box<dyn PlantEffect>> {
        if self.logged {
            self.effect.draw_logged(scene, rng, self.rms_m)
        } else {
            Some(self.effect.draw(scene, rng, self.rms_m))
        }
    }
}

impl std::fmt::Debug for Flaw {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}={} m", self.effect.name(), self.rms_m)
    }
}

/// What of a simulated board's flash is kept in a file: the slots with two pages behind them, then the tooth maps, then the rest of the log.
/// Files of earlier versions end before one of these.
const KEPT: [Range<usize>; 3] = [
    SLOTS_START as usize..SLOTS_START as usize + 4 * PAGE_BYTES as usize,
    MAPS_START as usize..MAPS_END as usize,
    SLOTS_START as usize + 4 * PAGE_BYTES as usize..LOG_END as usize,
];

/// Streams of random numbers from here on are those of changes in service: far behind the effects' own.
const AGEING_STREAM: u64 = 1 << 32;

/// Time over which effects of a simulated courier drift and slip, s: a survey's.
const SIM_DURATION_S: f64 = 40.0;

fn flaw(text: &str) -> Result<Flaw, String> {
    let (name, size) = text.split_once('=').ok_or_else(|| {
        let first = effects::CATALOGUE.first().map_or("EFFECT", |e| e.name);
        format!("wanted EFFECT=UM, such as {first}=2")
    })?;
    let (name, logged) = match name.split_once(':') {
        Some((name, LOGGED)) => (name, true),
        Some((_, other)) => return Err(format!("{other}: wanted {LOGGED} behind the colon")),
        None => (name, false),
    };
    let effect = effects::effect(name).ok_or_else(|| {
        let names: Vec<&str> = effects::CATALOGUE.iter().map(|entry| entry.name).collect();
        format!("{name}: no effect, wanted one of {}", names.join(", "))
    })?;
    let rms_m = match size.parse::<f64>() {
        Ok(size_um) if size_um > 0.0 && size_um <= 100.0 => 1.0e-6 * size_um,
        _ => return Err(format!("{size}: wanted a size above 0 and up to 100 µm")),
    };
    let flaw = Flaw {
        effect,
        logged,
        rms_m,
    };
    let scene = Scene {
        geometry: Geometry::PAPER,
        duration_s: SIM_DURATION_S,
        amplitude_counts: 1.0,
    };
    match flaw.draw(&scene, &mut ChaCha8Rng::seed_from_u64(0)) {
        Some(_) => Ok(flaw),
        None => Err(format!(
            "{name}: follows nothing that is logged, wanted {name}={size}"
        )),
    }
}

/// An end stop that begins at a place along one axis.
fn end_stop(text: &str) -> Result<Mark, String> {
    let wanted = || format!("{text}: wanted an axis and mm from -1000 to 1000, such as x=3");
    let (axis, from_mm) = text.split_once('=').ok_or_else(wanted)?;
    let from_m = from_mm.parse::<f64>().map_err(|_| wanted())? * 1.0e-3;
    if !(-1.0..=1.0).contains(&from_m) {
        return Err(wanted());
    }
    let (stop, all) = ([from_m, f64::INFINITY], [f64::NEG_INFINITY, f64::INFINITY]);
    match axis {
        "x" => Ok(Mark {
            x_m: stop,
            y_m: all,
        }),
        "y" => Ok(Mark {
            x_m: all,
            y_m: stop,
        }),
        _ => Err(wanted()),
    }
}

/// Behind an effect's name: it follows a quantity that is logged.
const LOGGED: &str = "logged";

/// A board that was opened. [`Opened::close`] keeps a simulated one's flash.
pub struct Opened {
    /// The board.
    pub link: Link,
    /// Where a simulated courier stands under its beacon.
    pub beacon: Option<Target>,
    /// Everything around a simulated board.
    pub world: Option<World>,
    flash: Option<Kept>,
    /// What no other command may have meanwhile.
    _claim: Option<Claim>,
}

/// A simulated board's flash and the file that it is kept in.
struct Kept {
    flash: SharedFlash,
    path: PathBuf,
}

/// What kind of board was named.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Kind {
    /// Simulated in this process.
    Sim,
    /// The image in QEMU.
    Emulated,
    /// The image on a model of its chip.
    Chip,
    /// Behind a debug probe.
    Probe,
}

impl Choice {
    /// The kind of board.
    pub fn kind(&self) -> Kind {
        match () {
            () if self.probe.is_some() => Kind::Probe,
            () if self.emulated => Kind::Emulated,
            () if self.chip => Kind::Chip,
            () => Kind::Sim,
        }
    }

    /// Seed of the simulated courier.
    pub fn seed(&self) -> u64 {
        self.sim_seed.unwrap_or(1)
    }

    /// True if the user named a board.
    pub fn is_given(&self) -> bool {
        self.sim || self.emulated || self.chip || self.probe.is_some() || self.simulated_options()
    }

    fn simulated_options(&self) -> bool {
        self.sim_preset.is_some()
            || self.sim_seed.is_some()
            || self.sim_courier.is_some()
            || self.sim_platen.is_some()
            || self.sim_flash.is_some()
            || self.sim_mark.is_some()
            || !self.sim_effect.is_empty()
            || !self.sim_age.is_empty()
            || !self.sim_fault.is_empty()
    }

    /// `files` of a command, with those of the board.
    #[must_use]
    pub fn files(&self, files: Files) -> Files {
        match &self.sim_flash {
            Some(path) => files.reads(path),
            None => files,
        }
    }

    /// Connects.
    ///
    /// # Errors
    /// There is no such board, or it does not answer.
    pub fn open(&self) -> Result<Opened> {
        if let Some(selector) = &self.probe {
            ensure!(
                !self.simulated_options(),
                "--sim-…: found --probe, wanted a simulated board"
            );
            return probe(selector);
        }
        self.simulated()
    }

    fn courier(&self) -> Result<(CourierSpec, u64)> {
        let seed = self.seed();
        let preset = self.sim_preset.unwrap_or(Preset::Paper);
        let mut spec = if self.sim_courier.is_some() || self.sim_platen.is_some() {
            ensure!(
                preset == Preset::Paper,
                "--sim-courier, --sim-platen: found another --sim-preset, wanted paper: they are of its make"
            );
            of_the_make(self.sim_courier, self.sim_platen)
        } else {
            preset.courier(seed, None, DEFAULT_RMS_M)?
        };
        let scene = Scene {
            geometry: spec.geometry,
            duration_s: SIM_DURATION_S,
            amplitude_counts: spec.electronics.amplitude_counts,
        };
        for (stream, flaw) in self.sim_effect.iter().enumerate() {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(1 + stream as u64);
            spec.effects.extend(flaw.draw(&scene, &mut rng));
        }
        for (stream, change) in self.sim_age.iter().enumerate() {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            rng.set_stream(AGEING_STREAM + stream as u64);
            change.give(&mut spec, &mut rng);
        }
        for fault in &self.sim_fault {
            spec.effects.push(fault.effect());
        }
        Ok((spec, seed))
    }

    fn simulated(&self) -> Result<Opened> {
        let (spec, seed) = self.courier()?;
        let beacon = Some(target(spec.places.beacon));
        let flash = SharedFlash::erased(seed);
        let claim = match &self.sim_flash {
            Some(path) => Some(claim_and_restore(&flash, path)?),
            None => None,
        };
        let home = spec.places.scatter_corner;
        let world = World::new(spec, ControllerConfig::TYPICAL, home, seed)?;
        world.set_mark(self.sim_mark);
        let outside = Some(world.clone());
        let wire: Box<dyn Wire> = match self.kind() {
            Kind::Emulated => Box::new(emulated::start(world, flash.clone())?),
            Kind::Chip => Box::new(chip::start(world, flash.clone())?),
            _ => Box::new(SimWire::around(world, flash.clone())?),
        };
        let link = Link::connect(wire)?;
        let flash = self.sim_flash.clone().map(|path| Kept { flash, path });
        Ok(Opened {
            link,
            beacon,
            world: outside,
            flash,
            _claim: claim,
        })
    }
}

impl Linked for Opened {
    fn link(&mut self) -> &mut Link {
        &mut self.link
    }
}

impl Opened {
    /// Ends the connection and keeps the simulated flash, if the user named a file for it.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn close(self) -> Result<()> {
        match self.flash {
            Some(kept) => keep(&kept.flash, &kept.path),
            None => Ok(()),
        }
    }
}

/// A pose as the motion controller is told it.
pub fn target(pose: Pose) -> Target {
    Target {
        x_m: pose.x_m as f32,
        y_m: pose.y_m as f32,
        theta_rad: pose.theta_rad as f32,
    }
}

/// Makes sure that nobody else changes the file until this command has ended, then reads it.
fn claim_and_restore(flash: &SharedFlash, path: &Path) -> Result<Claim> {
    check_folder_of(path).context("--sim-flash")?;
    let claim = Claim::of_file(path, &format!("--sim-flash: {}", path.display()))?;
    restore(flash, path)?;
    Ok(claim)
}

/// Fills erased flash with a file's bytes; no file: it stays erased.
fn restore(flash: &SharedFlash, path: &Path) -> Result<()> {
    let bytes = match std::fs::read(path) {
        Ok(bytes) => bytes,
        Err(error) if error.kind() == std::io::ErrorKind::NotFound => {
            return Ok(());
        }
        Err(error) => {
            return Err(error).with_context(|| format!("--sim-flash: {}", path.display()));
        }
    };
    let mut inner = flash.0.borrow_mut();
    let lengths = [1, 2, 3].map(|parts| KEPT[..parts].iter().map(Range::len).sum::<usize>());
    let wanted = lengths[2];
    ensure!(
        lengths.contains(&bytes.len()),
        "--sim-flash: {}: found {} bytes, wanted {wanted}: the flash of a simulated board",
        path.display(),
        bytes.len()
    );
    // A double word that was never programmed must stay programmable.
    let places = KEPT.into_iter().flatten().step_by(SharedFlash::WRITE_SIZE);
    for (place, word) in places.zip(bytes.chunks(SharedFlash::WRITE_SIZE)) {
        if word.iter().any(|byte| *byte != 0xFF) {
            inner.force(place, word);
        }
    }
    Ok(())
}

fn keep(flash: &SharedFlash, path: &Path) -> Result<()> {
    let inner = flash.0.borrow();
    let kept = KEPT.map(|places| &inner.bytes()[places]).concat();
    if std::fs::read(path).is_ok_and(|bytes| bytes == kept) {
        return Ok(());
    }
    replace_file(path, &kept).context("--sim-flash")
}

#[cfg(feature = "probe-code")]
fn probe(selector: &str) -> Result<Opened> {
    let found = link_host::probe::find((selector != "any").then_some(selector))?;
    let claim = Claim::of_name(&found.name(), "--probe")?;
    let wire = link_host::probe::Probed::open(&found)?;
    Ok(Opened {
        link: Link::connect(Box::new(wire))?,
        beacon: None,
        world: None,
        flash: None,
        _claim: Some(claim),
    })
}

#[cfg(not(feature = "probe-code"))]
fn probe(_: &str) -> Result<Opened> {
    anyhow::bail!(
        "--probe: this courier was built without debug probes; wanted: cargo run -p courier --release --features probe"
    )
}
