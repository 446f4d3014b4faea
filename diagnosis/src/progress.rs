//! What a long computation is at, told as it goes: the library prints nothing.

/// A stage of a diagnosis or of a check, in the order of the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// The recording is repaired and the baseline calibrated.
    Prepare,
    /// The catalogue is compared on held-out data.
    Compare,
    /// The noise is measured, where it is not the stated one.
    Noise,
    /// All is compared anew about what was found.
    Relinearize,
    /// More is told of what was found, and a field over the platen is tried.
    Fuller,
    /// All is compared about the places that other sets lead to.
    Modes,
    /// What another recording will show is foretold.
    Predict,
    /// The verdict is made.
    Decide,
    /// A check: the recording is read as the model's was.
    Read,
    /// A check: samples that the model knows are told from those that it does not.
    Split,
    /// A check: the model is applied.
    Apply,
}

/// Who is told.
pub type Watch<'w> = &'w dyn Fn(Stage);

/// For those who do not ask.
pub fn unwatched(_: Stage) {}

/// Stages of a diagnosis.
pub const DIAGNOSIS: [Stage; 8] = [
    Stage::Prepare,
    Stage::Compare,
    Stage::Noise,
    Stage::Relinearize,
    Stage::Fuller,
    Stage::Modes,
    Stage::Predict,
    Stage::Decide,
];
/// Stages of a check.
pub const CHECK: [Stage; 3] = [Stage::Read, Stage::Split, Stage::Apply];

impl Stage {
    /// What is done, in a few words.
    #[must_use]
    pub fn what(self) -> &'static str {
        match self {
            Self::Prepare => "calibrating the baseline",
            Self::Compare => "comparing the catalogue",
            Self::Noise => "measuring the noise",
            Self::Relinearize => "comparing about what is found",
            Self::Fuller => "telling more of it",
            Self::Modes => "comparing about its rivals",
            Self::Predict => "foretelling other recordings",
            Self::Decide => "making the verdict",
            Self::Read => "reading as the model's was",
            Self::Split => "finding what the model knows",
            Self::Apply => "applying the model",
        }
    }

    /// Share of the whole time that has passed when it begins: rough, of recordings of 3000 to 30000 samples on two cores.
    #[must_use]
    pub fn begins_at(self) -> f64 {
        match self {
            Self::Prepare | Self::Read => 0.0,
            Self::Compare => 0.05,
            Self::Noise => 0.15,
            Self::Relinearize => 0.20,
            Self::Fuller => 0.50,
            Self::Modes => 0.80,
            Self::Predict => 0.95,
            Self::Decide => 0.97,
            Self::Split => 0.3,
            Self::Apply => 0.6,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn stages_follow_each_other_and_have_names_that_fit_a_line() {
        for stages in [&DIAGNOSIS[..], &CHECK] {
            assert_eq!(stages[0].begins_at(), 0.0);
            assert!(stages.windows(2).all(|two| two[0] < two[1]));
            assert!(
                stages
                    .windows(2)
                    .all(|two| two[0].begins_at() < two[1].begins_at())
            );
            assert!(
                stages
                    .iter()
                    .all(|stage| stage.what().chars().count() <= 29 && stage.begins_at() < 1.0)
            );
        }
    }
}
