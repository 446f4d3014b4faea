//! The pages that are looked at: every verdict, from small recordings that are made here.

use crate::arm::root;
use crate::cargo::cargo;
use anyhow::{Context, Result, ensure};
use effects::random::{ChaCha8Rng, SeedableRng, normal};
use recording::{Electronics, Existing, Geometry, Meta, Recording, Row, Samples};
use std::f64::consts::TAU;
use std::path::{Path, PathBuf};
use std::process::Stdio;

/// The recording whose report is the README's picture: one that a reader has.
const PICTURED: &str = "examples/survey-lateral";
/// Couriers of the blind check, and a seed that gives one with two causes.
const BLIND: [&str; 4] = ["--cases", "1", "--seed", "9"];
/// Samples of an encoder's recording, enough for the two runs there and back that a diagnosis wants, and its noise, m.
const SAMPLES: u32 = 4000;
const NOISE_M: f64 = 0.1e-6;
/// Delay of the encoder that has one, s.
const DELAY_S: f64 = 50.0e-6;

/// Makes all of them in a folder. Their names are what they show.
///
/// # Errors
/// A command fails.
pub fn make(folder: &Path) -> Result<Vec<PathBuf>> {
    let blind = [
        "blind",
        "--quick",
        "--folder",
        "cases",
        "--report",
        "blind.html",
    ];
    courier(folder, &[&blind[..], &BLIND].concat())?;
    let late = encoder(DELAY_S, SAMPLES);
    let even = encoder(0.0, SAMPLES);
    let short = encoder(0.0, 20);
    for (name, recording) in [("late", &late), ("even", &even), ("short", &short)] {
        let path = folder.join(name);
        recording
            .write(&path, Existing::Refuse)
            .with_context(|| path.display().to_string())?;
    }
    let diagnoses: [&[&str]; 5] = [
        &[
            "cases/recordings/case_000",
            "--model",
            "model.json",
            "--report",
            "courier.html",
        ],
        &["late", "--report", "named.html"],
        &[
            "late",
            "--without",
            "velocity_lag",
            "--report",
            "unknown.html",
        ],
        &["even", "--report", "no-gap.html"],
        &["short", "--report", "insufficient.html"],
    ];
    let mut list = vec![folder.join("blind.html")];
    for arguments in diagnoses {
        courier(folder, &[&["diagnose"], arguments].concat())?;
        list.extend(arguments.last().map(|page| folder.join(page)));
    }
    let compared = [
        "compare",
        "late",
        "even",
        "--budget",
        "--report",
        "compared.html",
    ];
    courier(folder, &compared)?;
    list.push(folder.join("compared.html"));
    Ok(list)
}

/// Makes the page whose top is the picture.
///
/// # Errors
/// The command fails.
pub fn pictured(folder: &Path) -> Result<PathBuf> {
    let page = folder.join("pictured.html");
    let report = page.to_string_lossy();
    courier(&root(), &["diagnose", PICTURED, "--report", &report])?;
    Ok(page)
}

/// Runs the command of this project.
fn courier(folder: &Path, arguments: &[&str]) -> Result<()> {
    let mut command = cargo(&["run", "--quiet", "--profile", "checked"]);
    command
        .args([
            "--package",
            "courier",
            "--bin",
            "courier",
            "--manifest-path",
        ])
        .arg(root().join("Cargo.toml"))
        .arg("--")
        .args(arguments)
        .current_dir(folder)
        .stdout(Stdio::null());
    let done = command.status().context("courier")?;
    ensure!(done.success(), "courier {}", arguments.join(" "));
    Ok(())
}

/// One encoder beside a reference, to and fro over some ten pitches: an error within equation (3), noise, and a delay.
fn encoder(delay_s: f64, count: u32) -> Recording {
    let pitch_m = 1.0e-3;
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut samples = Samples::default();
    for k in 0..count {
        let t_s = f64::from(k) * 1.0e-3;
        let reference_m = 5.0 * pitch_m * (1.0 - (1.3 * t_s).cos());
        let speed_m_s = 6.5 * pitch_m * (1.3 * t_s).sin();
        let eccentric_m = 3.0e-6 * (TAU * reference_m / pitch_m).sin();
        let read_m = reference_m + eccentric_m - delay_s * speed_m_s + NOISE_M * normal(&mut rng);
        samples.push(&Row {
            t_s,
            run: "sweep",
            position_m: [Some(read_m), None, None, None],
            reference: [Some(reference_m), None, None],
            ..Row::default()
        });
    }
    Recording {
        meta: Meta {
            device: "simulated encoder".into(),
            source: "cargo xtask report".into(),
            geometry: Geometry {
                pitch_m,
                ..Geometry::default()
            },
            electronics: Electronics {
                position_noise_m: Some(NOISE_M),
                ..Electronics::default()
            },
            ..Meta::default()
        },
        samples,
        warnings: Vec::new(),
    }
}
