//! Samples that are looked at together, and the regressors that may act at any of them: single teeth, and what is there for a while,
//! act at few, and are not asked at each sample of a recording.

use crate::linearization::recording::{LinearizedRecording, SampleRows};
use effects::over::Extent;
use effects::sensor::{Covariates, Regressor};

/// Samples whose regressors are looked for together: few enough to lie near each other. Cost alone: a group asks for the
/// regressors of all its places, and the sums are the same.
pub const GROUP_SAMPLES: usize = 64;

/// A sample.
pub struct Sample {
    /// Its number.
    pub number: usize,
    /// Its rows; there is at least one.
    pub rows: SampleRows,
    /// What the sensor knows there.
    pub covariates: Covariates,
}

/// Some samples, and what may act there.
pub struct Group {
    /// Those of them that have rows.
    pub samples: Vec<Sample>,
    /// Numbers of the regressors that may act at one of them, ascending.
    pub acting: Vec<usize>,
}

impl Group {
    /// Of these samples and these of all regressors. Cost: one look at each of either.
    pub fn new(
        linearized: &LinearizedRecording,
        regressors: &[Regressor],
        asked: impl IntoIterator<Item = usize>,
        samples: impl IntoIterator<Item = usize>,
    ) -> Self {
        let asked_samples = samples.into_iter();
        // A loop, and no iterator: a sample has some thousand bytes, and `filter_map` copies each more than once on its way into the list.
        let mut samples = Vec::with_capacity(asked_samples.size_hint().0);
        for number in asked_samples {
            let rows = linearized.rows(number);
            if rows.count > 0 {
                samples.push(Sample {
                    number,
                    rows,
                    covariates: linearized.covariates(number),
                });
            }
        }
        let extent = Extent::of(samples.iter().map(|s: &Sample| &s.covariates));
        let may = |c: &usize| regressors[*c].may_act(&extent);
        Self {
            acting: asked.into_iter().filter(may).collect(),
            samples,
        }
    }
}
