//! Which courier is simulated.

use anyhow::Result;
use clap::ValueEnum;
use hal_sim::presets;
use hal_sim::spec::CourierSpec;
use serde::Serialize;
use std::path::Path;

/// Which courier is simulated.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, ValueEnum)]
#[serde(rename_all = "lowercase")]
pub enum Preset {
    /// Lateral terms and an error of each tooth, sized so that the paper's table comes out; `diagnose` answers `unknown`.
    #[default]
    Paper,
    /// Equation (3) and noise only; with an effect beside it, `diagnose` names that.
    Ideal,
    /// Waveforms of real encoders; `diagnose` answers `unknown`.
    Measured,
}

impl Preset {
    /// As it is given on the command line.
    fn name(self) -> &'static str {
        match self {
            Self::Paper => "paper",
            Self::Ideal => "ideal",
            Self::Measured => "measured",
        }
    }

    /// The courier; `waveforms` and `rms_m` are for [`Preset::Measured`].
    ///
    /// # Errors
    /// A table of waveforms that cannot be used.
    pub fn courier(self, seed: u64, waveforms: Option<&Path>, rms_m: f64) -> Result<CourierSpec> {
        let spec = match self {
            Self::Paper => presets::paper(),
            Self::Ideal => presets::ideal(seed),
            Self::Measured => presets::measured(waveforms, rms_m, seed)?,
        };
        Ok(CourierSpec {
            number: presets::device_number(self.name(), seed),
            ..spec
        })
    }
}
