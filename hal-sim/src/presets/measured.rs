//! `measured`: each segment's error is a real encoder's measured waveform. No model of ours made those shapes.
//!
//! File layout: a header row; the first column a code, every other one an encoder's error over one turn at equally spaced
//! codes, any unit (each is scaled to the stated rms).

use crate::spec::CourierSpec;
use crate::waveform::Waveform;
use effects::random::{ChaCha8Rng, SeedableRng, index};
use std::path::{Path, PathBuf};

/// Default rms of each segment's error, metres.
pub const DEFAULT_RMS_M: f64 = 10.0e-6;

/// Fewest codes a turn: below, orders up to six would not be resolved.
const FEWEST_CODES: usize = 16;

/// What is wrong with a file of waveforms.
#[derive(Debug, thiserror::Error)]
pub enum WaveformFileError {
    /// It cannot be read.
    #[error("{}: {cause}; wanted a table of measured waveforms (preset `measured`)", path.display())]
    Unreadable {
        /// The file.
        path: PathBuf,
        /// Why.
        cause: csv::Error,
    },
    /// A field is not a finite number.
    #[error("{}: row {row}, column `{column}`: found `{found}`, wanted a finite number", path.display())]
    NotANumber {
        /// The file.
        path: PathBuf,
        /// Row, the header being 1.
        row: usize,
        /// Column's name.
        column: String,
        /// What is there.
        found: String,
    },
    /// A column does not vary, so it has no shape to scale.
    #[error("{}: column `{column}`: all values are equal, wanted a waveform", path.display())]
    Constant {
        /// The file.
        path: PathBuf,
        /// Column's name.
        column: String,
    },
    /// Too few rows or columns.
    #[error("{}: {rows} rows of {columns} waveforms, wanted at least {FEWEST_CODES} rows and one waveform", path.display())]
    TooSmall {
        /// The file.
        path: PathBuf,
        /// Rows below the header.
        rows: usize,
        /// Columns after the first.
        columns: usize,
    },
    /// The stated rms is not a positive length.
    #[error("rms {rms_m} m: wanted above 0 and below 1e-4 m")]
    Rms {
        /// What was stated.
        rms_m: f64,
    },
}

/// Measured waveforms, mean removed, rms 1.
#[derive(Clone, Debug, PartialEq)]
pub struct MeasuredWaveforms {
    /// Name and values over one turn of each.
    pub waveforms: Vec<(String, Vec<f64>)>,
}

impl MeasuredWaveforms {
    /// Where the measured waveforms that come with the project's data lie: below the environment variable
    /// `COURIER_SHARED`, else below `../shared` seen from the checkout.
    #[must_use]
    pub fn default_path() -> PathBuf {
        let beside_checkout = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared");
        let shared = std::env::var_os("COURIER_SHARED").map_or_else(beside_checkout, PathBuf::from);
        shared.join("data/encoder-waveforms/waveforms_millideg.csv")
    }

    /// Reads a file.
    ///
    /// # Errors
    /// [`WaveformFileError`], naming file, row and column.
    pub fn read(path: &Path) -> Result<Self, WaveformFileError> {
        let unreadable = |cause| WaveformFileError::Unreadable {
            path: path.into(),
            cause,
        };
        let mut reader = csv::ReaderBuilder::new()
            .trim(csv::Trim::All)
            .from_path(path)
            .map_err(unreadable)?;
        let names: Vec<String> = reader
            .headers()
            .map_err(unreadable)?
            .iter()
            .skip(1)
            .map(Into::into)
            .collect();
        let mut columns = vec![Vec::new(); names.len()];
        for (row, record) in reader.records().enumerate() {
            let record = record.map_err(unreadable)?;
            for (column, found) in record.iter().skip(1).enumerate() {
                let value = found.parse::<f64>().ok().filter(|v| v.is_finite());
                let wrong = || WaveformFileError::NotANumber {
                    path: path.into(),
                    row: row + 2,
                    column: names[column].clone(),
                    found: found.chars().take(24).collect(),
                };
                columns[column].push(value.ok_or_else(wrong)?);
            }
        }
        let rows = columns.first().map_or(0, Vec::len);
        if rows < FEWEST_CODES {
            return Err(WaveformFileError::TooSmall {
                path: path.into(),
                rows,
                columns: names.len(),
            });
        }
        let named = names.into_iter().zip(columns);
        let waveform = |(name, values): (String, Vec<f64>)| match normalised(values) {
            Some(values) => Ok((name, values)),
            None => Err(WaveformFileError::Constant {
                path: path.into(),
                column: name,
            }),
        };
        Ok(Self {
            waveforms: named.map(waveform).collect::<Result<_, _>>()?,
        })
    }

    /// A courier with four of the waveforms, chosen by `seed` (different ones if there are four), at an rms in metres.
    ///
    /// # Errors
    /// [`WaveformFileError::Rms`].
    pub fn courier(&self, rms_m: f64, seed: u64) -> Result<CourierSpec, WaveformFileError> {
        if !(rms_m > 0.0 && rms_m < 1.0e-4) {
            return Err(WaveformFileError::Rms { rms_m });
        }
        let chosen = self.choose(seed);
        let names = chosen.map(|i| self.waveforms[i].0.as_str());
        let waveforms = chosen.map(|i| {
            let values = &self.waveforms[i].1;
            // The interpolated curve's rms, which high orders make less than that of its points.
            let factor = rms_m / Waveform::Table(values.clone()).rms_m();
            Waveform::Table(values.iter().map(|v| v * factor).collect())
        });
        let device = format!(
            "simulated courier, measured waveforms {}, seed {seed}",
            names.join(", ")
        );
        Ok(CourierSpec {
            device,
            waveforms,
            ..CourierSpec::flawless()
        })
    }

    fn choose(&self, seed: u64) -> [usize; 4] {
        let mut rng = ChaCha8Rng::seed_from_u64(seed ^ 0x4d65_6173);
        let mut left: Vec<usize> = Vec::new();
        core::array::from_fn(|_| {
            if left.is_empty() {
                left = (0..self.waveforms.len()).collect();
            }
            left.swap_remove(index(&mut rng, left.len()))
        })
    }
}

/// Mean removed and divided by the rms; `None` for a constant.
fn normalised(values: Vec<f64>) -> Option<Vec<f64>> {
    let mean = values.iter().sum::<f64>() / values.len() as f64;
    let centred: Vec<f64> = values.iter().map(|v| v - mean).collect();
    let rms = effects::shape::root_mean_square(&centred);
    (rms > 1.0e-12 * (1.0 + mean.abs())).then(|| centred.iter().map(|v| v / rms).collect())
}

/// `measured` in one call: `file` or the project's own waveforms, rms in metres.
///
/// # Errors
/// [`WaveformFileError`].
pub fn measured(
    file: Option<&Path>,
    rms_m: f64,
    seed: u64,
) -> Result<CourierSpec, WaveformFileError> {
    let path = file.map_or_else(MeasuredWaveforms::default_path, Path::to_path_buf);
    MeasuredWaveforms::read(&path)?.courier(rms_m, seed)
}
