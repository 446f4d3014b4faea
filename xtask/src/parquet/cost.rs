//! What a million samples cost to and from a Parquet file: processor time beside the folder's, in turns in one run.

use crate::arm;
use crate::cargo::cargo;
use crate::processor_time;
use anyhow::{Context, Result, ensure};
use std::path::Path;
use std::process::{Command, Stdio};

/// A million samples, at the rate of the board.
const RECORD: &str = "--sim-preset ideal record million --seconds 50";
/// What the file may take of the folder's time. Derived from docs/formats.md: one second is asked for both ways, where the folder takes 2.1.
const MOST: f64 = 0.5;
/// Turns of both. The least of some is what the work takes: other programs on the machine only add to it. Derived from that: one in three is
/// hardly disturbed.
const TURNS: usize = 3;

/// Copies the recording from file to file and from folder to folder by a program that does nothing else, built for speed: the tests'
/// profile leaves what others wrote as it is.
///
/// # Errors
/// It does not compile, a copy fails, or the file takes too long.
pub fn check(command: &Path, folder: &Path) -> Result<()> {
    let words = "build --quiet --release --package columnar --example copy";
    arm::run(&mut cargo(&words.split(' ').collect::<Vec<_>>()))?;
    ran(command, folder, &RECORD.split(' ').collect::<Vec<_>>())?;
    let copy = arm::root().join("target/release/examples/copy");
    ran(&copy, folder, &["million", "million.parquet"])?;
    let mut least_s = [f64::INFINITY; 2];
    for turn in 0..TURNS {
        let [file, text] = [format!("copy-{turn}.parquet"), format!("copy-{turn}")];
        let ways = [["million.parquet", &file], ["million", &text]];
        for (least_s, way) in least_s.iter_mut().zip(ways) {
            let (done, took) = processor_time::of(|| ran(&copy, folder, &way));
            done?;
            *least_s = least_s.min(took.as_secs_f64());
        }
    }
    let [file_s, text_s] = least_s;
    println!(
        "a million samples, read and written: {file_s:.2} s of processor time as Parquet, {text_s:.2} s as a folder"
    );
    ensure!(
        file_s <= MOST * text_s,
        "Parquet: found {file_s:.2} s where the folder takes {text_s:.2} s, wanted at most {MOST} of that"
    );
    Ok(())
}

fn ran(program: &Path, folder: &Path, words: &[&str]) -> Result<()> {
    let mut command = Command::new(program);
    command
        .args(words)
        .stdout(Stdio::null())
        .current_dir(folder);
    arm::run(&mut command).with_context(|| format!("{} {}", program.display(), words.join(" ")))
}
