//! What to demonstrate.

use super::preset::Preset;
use board_link::Starter;
use clap::ValueEnum;
use command_line::destination::Destination;
use std::path::PathBuf;

/// How poses are chosen.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, ValueEnum)]
pub enum Plan {
    /// Uniformly, as in the paper: 1000 poses within ±0.5°.
    #[default]
    Random,
    /// Each to shrink the predicted deviation most: a third of the poses, within ±1.5°.
    Optimal,
}

/// What to demonstrate.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// What the firmware runs on.
    pub board: Starter,
    /// Which courier.
    pub preset: Preset,
    /// Seed of the courier, its noise and its poses.
    pub seed: u64,
    /// Poses to fit; none: the plan's own number.
    pub poses: Option<u32>,
    /// How poses are chosen.
    pub plan: Plan,
    /// Table of measured waveforms for [`Preset::Measured`]; none: the project's shared data.
    pub waveforms: Option<PathBuf>,
    /// Rms of each measured waveform, m.
    pub rms_m: f64,
    /// Folder for a recording of the poses and of the fly-by.
    pub record: Option<Destination>,
}
