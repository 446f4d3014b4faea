//! `cargo xtask chip --mutate`: brings each mended fault in again and wants the model to find it.
//!
//! The sources are copied; all mutations share one folder of what is built, which begins as a copy of what the image itself was built
//! from: only the project's own packages are built anew. What is not found where several were brought in together is tried alone.

use super::batches::{self, Batch};
use super::copy::{self, Files};
use super::mutations::{MUTATIONS, Mutation};
use super::score::{self, Score};
use crate::arm::{Arm, TARGET, root, target_dir};
use crate::firmware;
use crate::processor_time;
use anyhow::{Context, Result, bail, ensure};
use std::path::Path;
use std::process::Command;
use std::time::Duration;

/// The model's program, and the compiler of what it runs.
#[derive(Clone, Copy)]
pub struct Tools<'a> {
    /// The compiler.
    pub arm: &'a Arm,
    /// The model.
    pub model: &'a Path,
}

/// Tries all mutations; the image itself has been built.
///
/// # Errors
/// A mutation no longer fits the sources, or one of the builds fails. One that is not found is told and not counted as caught.
pub fn all(tools: Tools<'_>) -> Result<Score> {
    let files = copy::read(&root())?;
    let every: Vec<&Mutation> = MUTATIONS.iter().collect();
    let score = run(tools, &files, batches::of(&every, &files))?;
    score::keep(&files, score)?;
    Ok(score)
}

/// Tries the mutations of these names, each by itself.
///
/// # Errors
/// As [`all`]; or a name is none.
pub fn alone(tools: Tools<'_>, names: &[String]) -> Result<Score> {
    let batches = chosen(names)?.into_iter().map(|one| vec![one]).collect();
    run(tools, &copy::read(&root())?, batches)
}

/// Tries the mutations of these names, which have nothing to do with one another, in one image.
///
/// # Errors
/// As [`alone`].
pub fn together(tools: Tools<'_>, names: &[String]) -> Result<Score> {
    run(tools, &copy::read(&root())?, vec![chosen(names)?])
}

/// What all mutations came to: as it was kept, if it is of these very sources; else they are tried now.
///
/// # Errors
/// As [`all`].
pub fn score(tools: Tools<'_>) -> Result<Score> {
    match score::kept(&copy::read(&root())?) {
        Some(score) => Ok(score),
        None => all(tools),
    }
}

fn run(tools: Tools<'_>, files: &Files, batches: Vec<Batch>) -> Result<Score> {
    let folder = root().join("target").join("mutations");
    let (copied, output) = (folder.join("source"), folder.join("build"));
    if !output.is_dir() {
        for inside in ["firmware".into(), Path::new(TARGET).join("firmware")] {
            copy::built(&target_dir().join(&inside), &output.join(&inside))?;
        }
    }
    let mut batches = std::collections::VecDeque::from(batches);
    let mut score = Score::default();
    let (mut builds, mut building, mut running) = (0, Duration::ZERO, Duration::ZERO);
    while let Some(batch) = batches.pop_front() {
        copy::write(&copy::mutate(files, &batch)?, &copied)?;
        let (image, built) =
            processor_time::of(|| firmware::build_in(tools.arm, "g474", &copied, &output));
        let image = image.with_context(|| format!("{} does not build", named(&batch)))?;
        (builds, building) = (builds + 1, building + built);
        for mutation in &batch {
            let (outcome, ran) = processor_time::of(|| try_on(tools.model, &image, mutation));
            running += ran;
            match outcome {
                Err(_) if batch.len() > 1 => batches.push_back(vec![mutation]),
                outcome => {
                    score.tried += 1;
                    score.caught += usize::from(outcome.is_ok());
                    tell(mutation, outcome);
                }
            }
        }
    }
    let Score { tried, caught } = score;
    eprintln!(
        "mutate: {caught} of {tried} found; processor time: {:.0} s for {builds} images, {:.0} s for the checks",
        building.as_secs_f64(),
        running.as_secs_f64()
    );
    Ok(score)
}

fn named(batch: &Batch) -> String {
    let names: Vec<&str> = batch.iter().map(|mutation| mutation.name).collect();
    names.join(" with ")
}

fn tell(mutation: &Mutation, outcome: Result<String>) {
    let Mutation { name, what, .. } = mutation;
    match outcome {
        Ok(line) => eprintln!("mutate: {name}: {what}: found: {line}"),
        Err(error) => eprintln!("mutate: {name}: {what}: NOT FOUND: {error:#}"),
    }
}

fn chosen(names: &[String]) -> Result<Vec<&'static Mutation>> {
    let find = |name: &String| MUTATIONS.iter().find(|known| known.name == *name);
    let mut found = vec![];
    for name in names {
        match find(name) {
            Some(mutation) => found.push(mutation),
            None => {
                let known: Vec<&str> = MUTATIONS.iter().map(|known| known.name).collect();
                bail!("found {name:?}, wanted one of {}", known.join(", "));
            }
        }
    }
    Ok(found)
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

#[cfg(test)]
mod tests {
    use super::*;

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
