//! What a long computation is at, told as it goes: the library prints nothing.

/// A stage of a diagnosis or of a check, in the order of the work.
#[derive(Clone, Copy, Debug, PartialEq, Eq, PartialOrd, Ord)]
pub enum Stage {
    /// The recording is repaired and the baseline calibrated.
    Prepare,
    /// The catalogue is compared on held-out data.
    Compare,
    /// The phase that harmonics run over is chosen.
    Phase,
    /// What was found is told more fully.
    NestedForms,
    /// All is compared anew about what was found.
    Relinearize,
    /// A field over the platen is tried.
    Field,
    /// Effects beside those found are tried.
    SecondEffect,
    /// What is not needed is taken out.
    Prune,
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
pub const DIAGNOSIS: [Stage; 10] = [
    Stage::Prepare,
    Stage::Compare,
    Stage::Phase,
    Stage::NestedForms,
    Stage::Relinearize,
    Stage::Field,
    Stage::SecondEffect,
    Stage::Prune,
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
            Self::Phase => "choosing the phase",
            Self::NestedForms => "fitting what was found",
            Self::Relinearize => "looking again beside it",
            Self::Field => "trying a field of teeth",
            Self::SecondEffect => "trying further effects",
            Self::Prune => "taking out what is not needed",
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
            Self::Phase => 0.30,
            Self::NestedForms => 0.40,
            Self::Relinearize => 0.45,
            Self::Field => 0.70,
            Self::SecondEffect => 0.75,
            Self::Prune => 0.85,
            Self::Predict => 0.93,
            Self::Decide => 0.95,
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
