//! What is diagnosed.

use recording::Recording;
use serde::{Deserialize, Serialize};
use specimens::rig;
use specimens::{Case, Drawn};
use std::path::{Path, PathBuf};

/// A recording and, where there is one, another of the same courier. Everything follows from what stands here.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
pub enum Specimen {
    /// A courier of the project's own simulator, with effects of its catalogue.
    Drawn(Case),
    /// A courier of the independent simulator.
    Rig(Rigged),
    /// A real recording, by the name of its folder in `data` of the shared folder, which is no part of the project.
    Real(String),
}

/// A courier of [`specimens::rig`].
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Rigged {
    /// Seed of courier and effects.
    pub seed: u64,
    /// Effects with their sizes, rms m.
    pub effects: Vec<Drawn>,
    /// Samples of the usual runs; runs are never shorter than 40 samples.
    pub samples: usize,
    /// Whether the coordination sensor is recorded.
    pub beacon: bool,
    /// Whether raw counts are recorded.
    pub counts: bool,
    /// Whether a reference is recorded.
    pub reference: bool,
    /// How many segments are recorded, from the first.
    pub segments: usize,
}

impl Rigged {
    fn record(&self, motion: u64) -> Recording {
        let options = rig::Options {
            beacon: self.beacon,
            counts: self.counts,
            samples: self.samples,
            reference: self.reference,
            segments: self.segments,
            ..rig::Options::default()
        };
        let effects: Vec<(&str, f64)> = self
            .effects
            .iter()
            .map(|e| (e.name.as_str(), e.size_m))
            .collect();
        rig::record_as(self.seed, motion, &effects, &options).0
    }
}

/// Where recordings lie that are no part of the project: `COURIER_SHARED`, or `shared` beside the checkout.
fn shared() -> PathBuf {
    std::env::var_os("COURIER_SHARED").map_or_else(
        || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared"),
        PathBuf::from,
    )
}

impl Specimen {
    /// A short name: unlike that of every other specimen of the set.
    #[must_use]
    pub fn name(&self) -> String {
        let told = |effects: &[Drawn]| {
            let one = |e: &Drawn| format!(" {} {:.2}", e.name, 1.0e6 * e.size_m);
            effects.iter().map(one).collect::<String>()
        };
        match self {
            Self::Drawn(case) => format!("drawn {}{}", case.seed, told(&case.effects)),
            Self::Rig(rig) => {
                let mut name = format!("rig {} of {}", rig.seed, rig.samples);
                for (lacks, word) in [(!rig.beacon, "no beacon"), (!rig.counts, "no counts")] {
                    name += &if lacks {
                        format!(", {word}")
                    } else {
                        String::new()
                    };
                }
                name += if rig.reference { ", reference" } else { "" };
                name + &told(&rig.effects)
            }
            Self::Real(folder) => format!("real {folder}"),
        }
    }

    /// The recording to diagnose; none where a real one is absent.
    ///
    /// # Errors
    /// A real recording cannot be read.
    pub fn first(&self) -> Result<Option<Recording>, recording::Error> {
        match self {
            Self::Drawn(case) => Ok(Some(case.recorded(0))),
            Self::Rig(rig) => Ok(Some(rig.record(rig.seed))),
            Self::Real(folder) => {
                let path = shared().join("data").join(folder);
                path.exists().then(|| Recording::read(path)).transpose()
            }
        }
    }

    /// Another recording of the same courier, to check the model on.
    #[must_use]
    pub fn second(&self) -> Option<Recording> {
        match self {
            Self::Drawn(case) => Some(case.recorded(1)),
            Self::Rig(rig) => Some(rig.record(rig.seed + 1000)),
            Self::Real(_) => None,
        }
    }
}
