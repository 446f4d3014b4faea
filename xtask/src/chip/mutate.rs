//! `cargo xtask chip --mutate`: brings each mended fault in again, one by one, and wants the model to find it.
//!
//! The sources are copied; all mutations share one folder of what is built, which begins as a copy of what the image itself was built
//! from: only the project's own package is built anew.

use super::copy::{self, Files};
use super::mutations::{MUTATIONS, Mutation};
use crate::arm::{Arm, TARGET, root, target_dir};
use crate::firmware;
use anyhow::{Context, Result, bail, ensure};
use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};
use std::process::Command;
use std::time::{Duration, Instant};

/// How many mutations were tried, and how many of them were found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Score {
    /// Tried.
    pub tried: usize,
    /// Found by the check and with the words that were to be seen.
    pub caught: usize,
}

/// Tries the mutations of these names, none: all, with the model that lies at `model`; the image itself has been built.
///
/// # Errors
/// A name is none, or one of the builds fails. A mutation that no longer fits, or that is not found, is told and not counted as caught.
pub fn run(arm: &Arm, model: &Path, names: &[String]) -> Result<Score> {
    let files = copy::read(&root())?;
    let score = run_on(&files, arm, model, names)?;
    if names.is_empty() {
        keep(&files, score)?;
    }
    Ok(score)
}

/// What all mutations came to: as it was kept, if it is of these very sources; else they are tried now.
///
/// # Errors
/// As [`run`].
pub fn score(arm: &Arm, model: &Path) -> Result<Score> {
    let kept = fs::read_to_string(score_file()).unwrap_or_default();
    match parse(&kept, digest(&copy::read(&root())?)) {
        Some(score) => Ok(score),
        None => run(arm, model, &[]),
    }
}

fn score_file() -> PathBuf {
    root().join("target").join("mutations").join("score")
}

/// Keeps what all mutations came to, with the digest of the sources that they were tried on.
fn keep(files: &Files, score: Score) -> Result<()> {
    let Score { tried, caught } = score;
    let text = format!("{:016x} {tried} {caught}\n", digest(files));
    fs::write(score_file(), text).context("target/mutations/score")
}

fn parse(kept: &str, digest: u64) -> Option<Score> {
    let mut words = kept.split_whitespace();
    let of = u64::from_str_radix(words.next()?, 16).ok()?;
    let mut number = || words.next()?.parse().ok();
    let (tried, caught) = (number()?, number()?);
    (of == digest).then_some(Score { tried, caught })
}

/// A number that is another one as soon as something changes that an image or the model is built from.
fn digest(files: &Files) -> u64 {
    let mut hasher = DefaultHasher::new();
    let is_source = |name: &Path| {
        let ending = name.extension().and_then(|ending| ending.to_str());
        matches!(ending, Some("rs" | "toml" | "lock" | "x"))
    };
    files
        .iter()
        .filter(|(name, _)| is_source(name))
        .for_each(|file| file.hash(&mut hasher));
    hasher.finish()
}

fn run_on(files: &Files, arm: &Arm, model: &Path, names: &[String]) -> Result<Score> {
    let chosen = chosen(names)?;
    let folder = root().join("target").join("mutations");
    let (copied, output) = (folder.join("source"), folder.join("build"));
    if !output.is_dir() {
        for inside in ["firmware".into(), Path::new(TARGET).join("firmware")] {
            copy::built(&target_dir().join(&inside), &output.join(&inside))?;
        }
    }
    let mut score = Score::default();
    let (mut building, mut running) = (Duration::ZERO, Duration::ZERO);
    for mutation in chosen {
        score.tried += 1;
        let begin = Instant::now();
        let image = build(arm, files, mutation, &copied, &output);
        let (built, begin) = (begin.elapsed(), Instant::now());
        let outcome = image.and_then(|image| try_on(model, &image, mutation));
        let ran = begin.elapsed();
        (building, running) = (building + built, running + ran);
        let (name, what) = (mutation.name, mutation.what);
        let seconds = format!("{:.0} + {:.0} s", built.as_secs_f64(), ran.as_secs_f64());
        match outcome {
            Ok(line) => {
                score.caught += 1;
                println!("mutate: {name}: {what}: found ({seconds}): {line}");
            }
            Err(error) => eprintln!("mutate: {name}: {what}: NOT FOUND ({seconds}): {error:#}"),
        }
    }
    let Score { tried, caught } = score;
    println!(
        "mutate: {caught} of {tried} found; {:.0} s of building, {:.0} s of running",
        building.as_secs_f64(),
        running.as_secs_f64()
    );
    Ok(score)
}

fn chosen(names: &[String]) -> Result<Vec<&'static Mutation>> {
    let known = |name: &String| MUTATIONS.iter().any(|known| known.name == *name);
    if let Some(unknown) = names.iter().find(|name| !known(name)) {
        let known: Vec<&str> = MUTATIONS.iter().map(|known| known.name).collect();
        bail!("found {unknown:?}, wanted one of {}", known.join(", "));
    }
    let wanted = |name: &str| names.is_empty() || names.iter().any(|wanted| wanted == name);
    Ok(MUTATIONS
        .iter()
        .filter(|mutation| wanted(mutation.name))
        .collect())
}

fn build(
    arm: &Arm,
    files: &Files,
    mutation: &Mutation,
    copied: &Path,
    output: &Path,
) -> Result<PathBuf> {
    copy::write(&copy::mutate(files, mutation)?, copied)?;
    firmware::build_in(arm, "g474", copied, output)
        .with_context(|| format!("{} does not build", mutation.name))
}

/// Runs the check that must fail; the line that shows the fault.
fn try_on(model: &Path, image: &Path, mutation: &Mutation) -> Result<String> {
    let done = Command::new(model)
        .arg(image)
        .arg(mutation.check)
        .output()
        .with_context(|| model.display().to_string())?;
    let said = String::from_utf8_lossy(&done.stderr);
    ensure!(
        !done.status.success(),
        "found the check {} passed, wanted {:?}",
        mutation.check,
        mutation.shows
    );
    shown(&said, mutation).map(ToOwned::to_owned)
}

/// The line of what a check said that shows the fault.
fn shown<'a>(said: &'a str, mutation: &Mutation) -> Result<&'a str> {
    let mut lines = said.lines();
    let line = lines.find(|line| line.contains(mutation.shows));
    line.map(str::trim).with_context(|| {
        format!(
            "found {:?} of the check {}, wanted {:?}",
            said.trim(),
            mutation.check,
            mutation.shows
        )
    })
}

/// Fails unless all were found.
///
/// # Errors
/// How many were not.
pub fn judge(score: Score) -> Result<()> {
    let Score { tried, caught } = score;
    ensure!(
        caught == tried,
        "the model found {caught} of {tried} faults that were brought in again"
    );
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_kept_score_is_of_its_own_sources_alone() {
        let files = |text: &str| Files::from([("src/lib.rs".into(), text.into())]);
        let (old, new) = (digest(&files("a")), digest(&files("b")));
        let kept = format!("{old:016x} 18 17\n");
        let score = Score {
            tried: 18,
            caught: 17,
        };
        assert_eq!(parse(&kept, old), Some(score));
        assert_eq!(parse(&kept, new), None);
        assert_eq!(parse("", old), None);
    }

    #[test]
    fn a_fault_is_shown_by_its_own_words_alone() {
        let mutation = &MUTATIONS[0];
        let said = format!("chip: flags: 1 rules broken:\n  {} twice", mutation.shows);
        assert!(shown(&said, mutation).is_ok_and(|line| line.ends_with("twice")));
        let other = shown("chip: flags: 1 rules broken:\n  fault: other", mutation);
        assert!(other.unwrap_err().to_string().contains("fault: other"));
    }

    #[test]
    fn names_are_told_apart_and_an_unknown_one_is_refused() {
        let mut names: Vec<&str> = MUTATIONS.iter().map(|known| known.name).collect();
        names.sort_unstable();
        names.dedup();
        assert_eq!(names.len(), MUTATIONS.len());
        assert!(chosen(&["no-such".into()]).is_err());
        assert_eq!(
            chosen(&[names[0].into()]).map(|one| one.len()).ok(),
            Some(1)
        );
    }
}
