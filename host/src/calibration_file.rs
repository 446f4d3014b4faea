//! A calibration as a file on the host: JSON, so that it can be read, compared and kept.

use anyhow::{Context, Result, ensure};
use courier_sensor::calibration::record::{Calibration, VERSION};
use courier_sensor::settings::{ConfigError, Settings};
use serde::{Deserialize, Serialize};
use std::io::Read as _;
use std::path::Path;

/// Longest file that is read, bytes: a calibration is a few thousand.
const LIMIT_BYTES: u64 = 1 << 20;

/// The file's one object.
#[derive(Debug, Serialize, Deserialize)]
pub struct CalibrationFile {
    /// Version of the record that it holds.
    courier_calibration: u16,
    /// What is in it.
    calibration: Calibration,
}

impl CalibrationFile {
    /// For writing.
    pub fn new(calibration: Calibration) -> Self {
        Self {
            courier_calibration: VERSION,
            calibration,
        }
    }

    /// The file's text.
    ///
    /// # Errors
    /// None in practice: every field can be written.
    pub fn to_json(&self) -> Result<String> {
        Ok(serde_json::to_string_pretty(self)?)
    }

    /// Reads and checks a file.
    ///
    /// # Errors
    /// It cannot be read, is no calibration of a known version, or holds numbers that cannot be used.
    pub fn read(path: &Path) -> Result<Calibration> {
        let place = || path.display().to_string();
        let mut text = String::new();
        let wanted = || format!("{}: a readable calibration was wanted", path.display());
        let file = std::fs::File::open(path).with_context(wanted)?;
        file.take(LIMIT_BYTES)
            .read_to_string(&mut text)
            .with_context(wanted)?;
        let value: serde_json::Value = serde_json::from_str(&text)
            .with_context(|| format!("{}: wanted JSON", path.display()))?;
        let version = value
            .get("courier_calibration")
            .and_then(serde_json::Value::as_u64);
        ensure!(
            version == Some(u64::from(VERSION)),
            "{}: key courier_calibration, found {}, wanted {VERSION}",
            path.display(),
            version.map_or("none".to_owned(), |version| version.to_string())
        );
        let file: Self = serde_json::from_value(value)
            .with_context(|| format!("{}: wanted a calibration", path.display()))?;
        file.calibration.validate().with_context(place)?;
        usable(&file.calibration)
            .with_context(|| format!("{}: lengths in metres", path.display()))?;
        Ok(file.calibration)
    }
}

/// What a board would check before it takes a calibration, so that the number and its range can be named.
fn usable(calibration: &Calibration) -> Result<(), ConfigError> {
    let settings = Settings {
        geometry: calibration.geometry,
        pairs: calibration.pairs,
        model: Some(calibration.model.clone()),
        ..Settings::default()
    };
    settings.validate()
}
