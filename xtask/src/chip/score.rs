//! What all mutations came to, kept for `cargo xtask bench --json` as long as the sources are the same.

use super::copy::Files;
use crate::arm::root;
use anyhow::{Context, Result, ensure};
use std::fs;
use std::hash::{DefaultHasher, Hash, Hasher};
use std::path::{Path, PathBuf};

/// How many mutations were tried, and how many of them were found.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Score {
    /// Tried.
    pub tried: usize,
    /// Found by the check and with the words that were to be seen.
    pub caught: usize,
}

impl Score {
    /// Fails unless all were found.
    ///
    /// # Errors
    /// How many were not.
    pub fn judge(self) -> Result<()> {
        let Self { tried, caught } = self;
        ensure!(
            caught == tried,
            "the model found {caught} of {tried} faults that were brought in again"
        );
        Ok(())
    }
}

fn file() -> PathBuf {
    root().join("target").join("mutations").join("score")
}

/// The score that was kept of these very sources.
pub fn kept(files: &Files) -> Option<Score> {
    parse(
        &fs::read_to_string(file()).unwrap_or_default(),
        digest(files),
    )
}

/// Keeps a score, with the digest of the sources that it is of.
///
/// # Errors
/// It cannot be written.
pub fn keep(files: &Files, score: Score) -> Result<()> {
    let Score { tried, caught } = score;
    let text = format!("{:016x} {tried} {caught}\n", digest(files));
    fs::write(file(), text).context("target/mutations/score")
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
        assert!(score.judge().is_err() && Score { tried: 17, ..score }.judge().is_ok());
    }
}
