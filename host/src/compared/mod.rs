//! What `courier compare` compares: an exported calibration, a diagnosed model or a recording, each as an estimate.

mod model;
pub mod page;
mod recording;
mod same_courier;
mod source;
pub mod text;
mod words;

pub use same_courier::check;
pub use source::{Compared, Device};

use crate::calibration_file::CalibrationFile;
use crate::recordings;
use ::recording::Recording;
use anyhow::{Context, Result, bail};
use diagnosis::Model;
use serde_json::Value;
use std::io::Read as _;
use std::path::Path;

/// Longest file that is read, bytes: a diagnosed model of a field is some 10 MB.
const LIMIT_BYTES: u64 = 1 << 28;

/// Reads a calibration by `courier export`, a model by `courier diagnose --model`, or a recording's folder, whose readings `check` may refuse.
///
/// # Errors
/// It is none of these, or cannot be used.
pub fn read(path: &Path, check: &dyn Fn(&Recording) -> Result<()>) -> Result<Compared> {
    let name = path.display().to_string();
    if recordings::is_recording(path) {
        let recording = recordings::read(path)?;
        check(&recording)?;
        return recording::estimate(&name, &recording).context(name);
    }
    let wanted = "wanted a calibration by `courier export`, a model by `courier diagnose --model`, or a recording's folder";
    let mut text = String::new();
    std::fs::File::open(path)
        .and_then(|file| file.take(LIMIT_BYTES).read_to_string(&mut text))
        .with_context(|| format!("{name}: {wanted}"))?;
    let value: Value = serde_json::from_str(&text).with_context(|| format!("{name}: {wanted}"))?;
    if value.get("courier_calibration").is_some() {
        return of_calibration(&name, path);
    }
    if value.get("survey").is_some() && value.get("claimed").is_some() {
        let model: Model =
            serde_json::from_value(value).with_context(|| format!("{name}: {wanted}"))?;
        return model::estimate(&name, &model).context(name);
    }
    bail!("{name}: found another file, {wanted}")
}

fn of_calibration(name: &str, path: &Path) -> Result<Compared> {
    let calibration = CalibrationFile::read(path)?;
    let geometry = &calibration.geometry;
    Ok(Compared {
        estimate: comparison::record::estimate(name, &calibration),
        device: Some(Device::Board(calibration.device.to_string())),
        stated: [geometry.span_m, geometry.lateral_m].map(|length_m| Some(f64::from(length_m))),
    })
}
