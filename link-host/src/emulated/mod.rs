//! An emulated board: QEMU runs the image, this process is the courier around it.
//!
//! In lockstep: whenever the board asks for something outside the processor, it stands still, its time too, until
//! [`Emulated::pass`] answers. `pass` returns at a question that it has not answered, so that between two calls the board is
//! frozen and a run repeats exactly.

mod ahead;
mod server;
#[cfg(not(target_os = "linux"))]
#[path = "elsewhere.rs"]
mod shared;
#[cfg(target_os = "linux")]
mod shared;

pub use server::Parts;
pub use shared::SharedRam;

use crate::image;
use crate::memory::TargetMemory;
use crate::rtt::Rtt;
use anyhow::{Context, Result, bail, ensure};
use board_link::Wire;
use courier_sensor::emulation::{POST_BASE, QEMU, QEMU_ARGUMENTS, RAM_BASE, RAM_OBJECT};
use std::path::{Path, PathBuf};
use std::process::{Child, Command, Stdio};
use std::sync::atomic::Ordering::SeqCst;
use std::time::{Duration, Instant};

/// The ring of commands.
const COMMAND_CHANNEL: usize = 0;
/// Looks at the bell before sleeping: the next question mostly comes some instants later.
const LOOKS: u32 = 100;
/// How long the board may think between two questions, wall clock: ten times what starting takes on a busy machine.
const PATIENCE: Duration = Duration::from_secs(60);
/// Virtual time in which an image sets its link up, and how often it is looked for.
const START_UP: Duration = Duration::from_millis(500);
const START_LOOK: Duration = Duration::from_millis(2);

/// Whether this operating system has what the emulated board needs: memory shared with QEMU, and sleeping on a word in it.
///
/// # Errors
/// It is not Linux.
pub fn supported() -> Result<()> {
    ensure!(
        cfg!(target_os = "linux"),
        "the emulated board: found {}, wanted Linux, whose shared memory and futexes it runs on",
        std::env::consts::OS
    );
    Ok(())
}

/// What to run.
#[derive(Clone, Debug)]
pub struct Images {
    /// The firmware, built for the emulated board.
    pub firmware: PathBuf,
    /// The plugin.
    pub plugin: PathBuf,
}

/// A running emulated board.
pub struct Emulated {
    qemu: Child,
    ram: SharedRam,
    /// The courier around it.
    pub parts: Parts,
    control_block: u32,
    rtt: Option<Rtt>,
    answered: u32,
    starts: u32,
}

impl Emulated {
    /// Switches it on and lets it set its link up.
    ///
    /// # Errors
    /// QEMU or an image is missing, or the image does not come up.
    pub fn start(images: &Images, parts: Parts) -> Result<Self> {
        supported()?;
        let ram = SharedRam::create()?;
        let bell = image::symbol(&images.firmware, "courier_bell")?;
        let control_block = image::symbol(&images.firmware, "_SEGGER_RTT")?;
        let qemu = spawn(images, ram.path(), bell)?;
        let mut board = Self {
            qemu,
            ram,
            parts,
            control_block,
            rtt: None,
            answered: 0,
            starts: 0,
        };
        // Everybody has opened it by the first question: nothing is left behind if this process is killed.
        board.wait()?;
        board.ram.unlink();
        for _ in 0..START_UP.as_micros() / START_LOOK.as_micros() {
            board.pass(START_LOOK)?;
            if board.rings()?.is_some() {
                break;
            }
        }
        Ok(board)
    }

    /// Times that the image has started: 1, and 1 more for each reset.
    pub fn starts(&self) -> u32 {
        self.starts
    }

    /// Waits until the board has rung and stands still, and takes note of what it asks.
    fn wait(&mut self) -> Result<()> {
        let begin = Instant::now();
        let mut looks = 0;
        loop {
            let asked = self.ram.word(POST_BASE)?;
            let seen = asked.load(SeqCst);
            if seen != self.answered {
                break;
            }
            looks += 1;
            if looks < LOOKS {
                std::hint::spin_loop();
                continue;
            }
            SharedRam::sleep(asked, seen, Duration::from_millis(50));
            if let Some(status) = self.qemu.try_wait()? {
                bail!("the emulated board has ended: {status}");
            }
            if begin.elapsed() > PATIENCE {
                bail!(
                    "the emulated board has not asked for anything for {} s",
                    PATIENCE.as_secs()
                );
            }
        }
        if self.parts.arrive(&mut self.ram)? {
            self.starts += 1;
            self.rtt = None;
        }
        Ok(())
    }

    /// Answers what it asks and lets it go on.
    fn answer(&mut self) -> Result<()> {
        self.parts.answer(&mut self.ram)?;
        self.answered = self.answered.wrapping_add(1);
        let answered = self.ram.word(POST_BASE + 4)?;
        answered.store(self.answered, SeqCst);
        SharedRam::wake(answered);
        Ok(())
    }

    /// The rings, once the image has set them up.
    fn rings(&mut self) -> Result<Option<&Rtt>> {
        if self.rtt.is_none() {
            self.rtt = Rtt::attach(&mut self.ram, self.control_block)?;
        }
        Ok(self.rtt.as_ref())
    }
}

impl Wire for Emulated {
    fn receive(&mut self, channel: usize, bytes: &mut [u8]) -> Result<usize> {
        let Some(rtt) = self.rings()?.cloned() else {
            return Ok(0);
        };
        rtt.read(&mut self.ram, channel, bytes)
    }

    fn send(&mut self, bytes: &[u8]) -> Result<usize> {
        let Some(rtt) = self.rings()?.cloned() else {
            return Ok(0);
        };
        rtt.write(&mut self.ram, COMMAND_CHANNEL, bytes)
    }

    fn pass(&mut self, time: Duration) -> Result<()> {
        self.wait()?;
        let end = self.parts.board_ns() + time.as_nanos() as u64;
        while self.parts.board_ns() < end {
            self.answer()?;
            self.wait()?;
        }
        Ok(())
    }
}

impl TargetMemory for Emulated {
    fn read(&mut self, address: u32, bytes: &mut [u8]) -> Result<()> {
        self.ram.read(address, bytes)
    }

    fn write(&mut self, address: u32, bytes: &[u8]) -> Result<()> {
        self.ram.write(address, bytes)
    }
}

impl Drop for Emulated {
    fn drop(&mut self) {
        // Nothing may wait for answers any more.
        if let Ok(gone) = self.ram.word(POST_BASE + 8) {
            gone.store(1, SeqCst);
        }
        let _ = self.qemu.kill();
        let _ = self.qemu.wait();
    }
}

fn spawn(images: &Images, ram: &Path, bell: u32) -> Result<Child> {
    let post = POST_BASE - RAM_BASE;
    let [before, after] = RAM_OBJECT;
    let mut command = Command::new(QEMU);
    #[cfg(target_os = "linux")]
    crate::child::tie(&mut command);
    command
        .args(QEMU_ARGUMENTS)
        .arg("-object")
        .arg(format!("{before}{}{after}", ram.display()))
        // 8 ns of virtual time an instruction, and no waiting for the wall clock.
        .args(["-icount", "shift=3,sleep=off", "-plugin"])
        .arg(format!(
            "{},ram={},bell={bell:#x},post={post:#x}",
            images.plugin.display(),
            ram.display()
        ))
        .arg("-kernel")
        .arg(&images.firmware)
        .stdin(Stdio::null())
        .stdout(Stdio::null())
        .spawn()
        .context("qemu-system-arm: wanted QEMU's emulator of ARM systems on the PATH")
}
