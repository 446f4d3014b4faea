//! `cargo xtask examples`: makes the data in `examples/` anew, and says which differ from what was there.
//!
//! The encoder log is written here, from the simulator's plant alone; the others by `courier`, with the command that stands beside them
//! in `examples/README.md`.

use crate::arm;
use crate::cargo::cargo;
use anyhow::{Context, Result, ensure};
use effects::motion::Pose;
use effects::plant::Scene;
use effects::random::{ChaCha8Rng, SeedableRng};
use hal_sim::courier::Courier;
use hal_sim::presets::ideal;
use hal_sim::trajectory::{OpenLoop, Path as Way, Schedule};
use std::fmt::Write as _;
use std::path::{Path, PathBuf};

/// Arguments of `courier` that make an example, and the folder in which they do.
const RECORDED: &[(&str, &str)] = &[(
    "survey-lateral",
    "--sim-preset ideal --sim-seed 3 --sim-effect lateral_dependence=3 record survey-lateral --survey 0,0,0 --decimation 50 --force",
)];

/// Makes all examples.
///
/// # Errors
/// A file cannot be written, or `courier` does not build or fails.
pub fn run() -> Result<()> {
    let examples = arm::root().join("examples");
    let log = examples.join("encoder-log/log.csv");
    let mut changed = Vec::new();
    write(&log, encoder_log()?.as_bytes(), &mut changed)?;
    for (name, words) in RECORDED {
        let files = ["recording.toml", "samples.csv"].map(|file| examples.join(name).join(file));
        let before = files.each_ref().map(|file| std::fs::read(file).ok());
        let mut command = cargo(&[
            "run",
            "--quiet",
            "--release",
            "--package",
            "courier",
            "--manifest-path",
        ]);
        command
            .arg(arm::root().join("Cargo.toml"))
            .arg("--")
            .args(words.split(' '))
            .current_dir(&examples);
        let done = command.status().context("cargo run")?;
        ensure!(done.success(), "courier {words}: failed");
        for (file, before) in files.iter().zip(before) {
            if std::fs::read(file).ok() != before {
                changed.push(file.clone());
            }
        }
    }
    match changed[..] {
        [] => println!("all examples are as they were"),
        _ => changed
            .iter()
            .for_each(|file| println!("changed: {}", file.display())),
    }
    Ok(())
}

fn write(file: &Path, bytes: &[u8], changed: &mut Vec<PathBuf>) -> Result<()> {
    if std::fs::read(file).ok().as_deref() != Some(bytes) {
        changed.push(file.to_owned());
    }
    let folder = file.parent().context("a file in a folder")?;
    std::fs::create_dir_all(folder).with_context(|| folder.display().to_string())?;
    std::fs::write(file, bytes).with_context(|| file.display().to_string())
}

/// Seed of the encoder, and of what is wrong with it.
const SEED: u64 = 5;
/// Its lag at 50 mm/s, rms: some thirty microseconds of a filter.
const LAG_M: f64 = 2.5e-6;
/// Rows a second of the log.
const RATE_HZ: f64 = 500.0;
/// Legs there and back about the middle: half a length and a speed, m and m/s.
const LEGS: [(f64, f64); 3] = [(2.0e-3, 2.0e-3), (10.0e-3, 10.0e-3), (15.0e-3, 40.0e-3)];
/// Rest before each leg, seconds.
const REST_S: f64 = 0.3;

/// A log as a bench writes it: one sine and cosine encoder on a stage, in counts, milliseconds, millimetres and degrees Celsius.
///
/// The encoder is segment 1 of an `ideal` courier: its waveform is equation (3)'s, and its readings lag with the speed.
///
/// # Errors
/// The waveform has no inverse: never with this seed.
pub fn encoder_log() -> Result<String> {
    let mut spec = ideal(SEED);
    let scene = Scene {
        geometry: spec.geometry,
        duration_s: 20.0,
        amplitude_counts: spec.electronics.amplitude_counts,
    };
    let lag = effects::entry("velocity_lag").context("the catalogue's velocity_lag")?;
    spec.effects.push((lag.draw)(
        &scene,
        &mut ChaCha8Rng::seed_from_u64(SEED),
        LAG_M,
    ));
    let pitch_m = spec.geometry.pitch_m;
    let mut courier = Courier::new(spec, SEED).context("the encoder's waveform")?;
    let start = Pose::new(-LEGS[0].0, 0.0, 0.0);
    let mut schedule = Schedule::new(start, OpenLoop::EXACT, pitch_m, SEED);
    let mut end_s = REST_S;
    for (half_m, speed_m_s) in LEGS {
        for to_m in [-half_m, half_m, -half_m] {
            end_s =
                schedule.go_to(end_s, Pose::new(to_m, 0.0, 0.0), speed_m_s, Way::Straight) + REST_S;
        }
    }
    let mut text = String::from("time;sin;cos;stage;board\n");
    for row in 0..(end_s * RATE_HZ) as u32 {
        let time_s = f64::from(row) / RATE_HZ;
        let sample = courier.counts_at(&schedule, time_s);
        let [sine, cosine] = sample.quadrature[0];
        let stage_mm = 1.0e3 * courier.reference(&schedule).x_m;
        writeln!(
            text,
            "{:.0};{sine};{cosine};{stage_mm:.5};{:.2}",
            1.0e3 * time_s,
            sample.temperature_c
        )?;
    }
    Ok(text)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// What is in the folder is what the plant writes today.
    #[test]
    fn the_encoder_log_is_as_it_is_made() {
        let there =
            std::fs::read_to_string(arm::root().join("examples/encoder-log/log.csv")).unwrap();
        let made = encoder_log().unwrap();
        let differs = there
            .lines()
            .zip(made.lines())
            .position(|(there, made)| there != made);
        assert_eq!(differs, None, "`cargo xtask examples` makes it anew");
        assert_eq!(there.len(), made.len());
    }
}
