//! The simulated board at the far end of the link: the firmware's own halves, in this process.

use crate::Wire;
use anyhow::{Context, Result};
use courier_sensor::link::message::{REPLY_CHANNEL, ResetCause, TELEMETRY_CHANNEL};
use courier_sensor::settings::Settings;
use hal_sim::banks::Banks;
use hal_sim::board::{SharedFlash, SimBoard};
use hal_sim::spec::CourierSpec;
use hal_sim::wire::link::COMMAND_BYTES;
use hal_sim::wire::motion::ControllerConfig;
use hal_sim::world::World;
use std::collections::VecDeque;
use std::io::Read as _;
use std::time::Duration;

/// A simulated board that restarts when it is asked to.
pub struct SimWire {
    board: Option<SimBoard>,
    banks: Banks,
    rate_hz: f64,
    /// Replies of the board before its restart that were not taken yet.
    replies: VecDeque<u8>,
    /// Part of a sample that was passed and not yet run, s.
    owed_s: f64,
}

impl SimWire {
    /// Switches a courier's board on.
    ///
    /// # Errors
    /// The courier's errors have no unique inverse, or the board does not start.
    pub fn start(spec: CourierSpec, seed: u64, flash: SharedFlash) -> Result<Self> {
        let home = spec.places.scatter_corner;
        Self::around(
            World::new(spec, ControllerConfig::TYPICAL, home, seed)?,
            flash,
        )
    }

    /// Switches the board in this world on.
    ///
    /// # Errors
    /// The board does not start.
    pub fn around(world: World, flash: SharedFlash) -> Result<Self> {
        let settings = Settings::default();
        let rate_hz = f64::from(settings.rate_hz);
        let mut banks = Banks::factory(flash);
        let board = start(ResetCause::PowerOn, world, &mut banks, settings)?;
        Ok(Self {
            board: Some(board),
            banks,
            rate_hz,
            replies: VecDeque::new(),
            owed_s: 0.0,
        })
    }

    /// A restart as it was ordered; what the board has said stays to be read.
    fn restart(&mut self) -> Result<()> {
        if let Some(board) = self.board.take() {
            let mut bytes = [0; COMMAND_BYTES];
            let taken = board.link.read_replies(&mut bytes);
            self.replies.extend(&bytes[..taken]);
            let cause = ResetCause::Requested;
            let settings = Settings::default();
            self.board = Some(start(cause, board.stop(), &mut self.banks, settings)?);
        }
        Ok(())
    }

    fn board(&mut self) -> Result<&mut SimBoard> {
        self.board
            .as_mut()
            .context("the simulated board did not start again")
    }
}

/// Reset: the first stage, then the image that it has chosen.
fn start(
    cause: ResetCause,
    world: World,
    banks: &mut Banks,
    settings: Settings,
) -> Result<SimBoard> {
    let started = banks.start().context("the simulated board has no image")?;
    let flash = banks.far();
    Ok(SimBoard::start_image(
        cause,
        world,
        flash,
        settings,
        Some(&started),
    )?)
}

impl Wire for SimWire {
    fn receive(&mut self, channel: usize, bytes: &mut [u8]) -> Result<usize> {
        if channel == REPLY_CHANNEL && !self.replies.is_empty() {
            return Ok(self.replies.read(bytes)?);
        }
        let link = &self.board()?.link;
        Ok(match channel {
            TELEMETRY_CHANNEL => link.read_telemetry(bytes),
            REPLY_CHANNEL => link.read_replies(bytes),
            _ => 0,
        })
    }

    fn send(&mut self, bytes: &[u8]) -> Result<usize> {
        Ok(self.board()?.link.write_commands(bytes))
    }

    fn pass(&mut self, time: Duration) -> Result<()> {
        self.owed_s += time.as_secs_f64();
        while self.owed_s * self.rate_hz >= 1.0 {
            self.owed_s -= 1.0 / self.rate_hz;
            let board = self.board()?;
            board.sample();
            if board.wants_restart() {
                self.restart()?;
            }
        }
        Ok(())
    }
}
