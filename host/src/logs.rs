//! Logs of other programs: texts and the files that `convert` knows, and Parquet and MCAP files where this build has their features.

use crate::output::Files;
use crate::recordings::{self, Form};
use anyhow::{Context, Result, ensure};
use convert::{Asked, Beside, Log};
use std::path::{Path, PathBuf};

/// What some logs need to be read.
#[derive(Clone, Debug, Default, clap::Args)]
#[command(next_help_heading = "How the log is read")]
pub struct Reading {
    /// DBC file of a bus: which bits of which frame of a candump log are which signal.
    #[arg(long, value_name = "FILE")]
    pub dbc: Option<PathBuf>,
    /// Of a log with several kinds of messages the one that makes the rows; values of the others are interpolated to its times
    /// [default: that of the sensor's output, or the most frequent].
    #[arg(long, value_name = "NAME")]
    pub rows_of: Option<String>,
}

impl Reading {
    /// True if something is stated, which makes sense beside a log alone.
    #[must_use]
    pub fn is_stated(&self) -> bool {
        self.dbc.is_some() || self.rows_of.is_some()
    }

    /// The files that it reads, added to others.
    #[must_use]
    pub fn files(&self, files: Files) -> Files {
        match &self.dbc {
            Some(dbc) => files.reads(dbc),
            None => files,
        }
    }

    fn beside(&self, asked: &[Asked]) -> Result<Beside> {
        let text = |path: &PathBuf| {
            let bytes = std::fs::read(path)
                .with_context(|| format!("{}: wanted a readable DBC file", path.display()))?;
            Ok::<_, anyhow::Error>((path.clone(), String::from_utf8_lossy(&bytes).into_owned()))
        };
        Ok(Beside {
            dbc: self.dbc.as_ref().map(text).transpose()?,
            rows_of: self.rows_of.clone(),
            sensor: Beside::sensor_of(asked),
        })
    }
}

/// Reads a log, of which these columns were asked for.
///
/// # Errors
/// It cannot be read, or is no table, or needs something that is not stated.
pub fn read(path: &Path, reading: &Reading, asked: &[Asked]) -> Result<Log> {
    let beside = reading.beside(asked)?;
    match recordings::form(path) {
        Some(Form::Parquet) => {
            ensure!(
                !reading.is_stated(),
                "{}: found --dbc or --rows-of beside a Parquet file, wanted neither",
                path.display()
            );
            return parquet(path);
        }
        Some(Form::Mcap) => {
            ensure!(
                reading.dbc.is_none(),
                "{}: found --dbc beside an MCAP file, wanted none",
                path.display()
            );
            return mcap(path, &beside);
        }
        None => {}
    }
    let bytes = std::fs::read(path)
        .with_context(|| format!("{}: wanted a readable log, or a recording", path.display()))?;
    Ok(convert::read_with(path, &bytes, &beside)?)
}

#[cfg(feature = "parquet")]
fn parquet(path: &Path) -> Result<Log> {
    Ok(columnar::log(path)?)
}

#[cfg(not(feature = "parquet"))]
fn parquet(path: &Path) -> Result<Log> {
    unread(path)
}

#[cfg(feature = "mcap")]
fn mcap(path: &Path, beside: &Beside) -> Result<Log> {
    Ok(bag::log(path, beside)?)
}

#[cfg(not(feature = "mcap"))]
fn mcap(path: &Path, _: &Beside) -> Result<Log> {
    unread(path)
}

/// Such a file is taken for a recording, which this build does not read either.
#[cfg(not(all(feature = "parquet", feature = "mcap")))]
fn unread(path: &Path) -> Result<Log> {
    Err(recordings::read(path).err().map_or_else(
        || anyhow::anyhow!("{}: wanted a log", path.display()),
        Into::into,
    ))
}
