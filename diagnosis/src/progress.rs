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
    Fuller,
    /// All is compared anew about what was found.
    LookAgain,
    /// A field over the platen is tried.
    Field,
    /// Effects beside those found are tried.
    Beside,
    /// What is not needed is taken out.
    Prune,
    /// What another recording will show is foretold.
    Foretell,
    /// The verdict is made.
    Judge,
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
    Stage::Fuller,
    Stage::LookAgain,
    Stage::Field,
    Stage::Beside,
    Stage::Prune,
    Stage::Foretell,
    Stage::Judge,
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
            Self::Fuller => "fitting what was found",
            Self::LookAgain => "looking again beside it",
            Self::Field => "trying a field of teeth",
            Self::Beside => "trying further effects",
            Self::Prune => "taking out what is not needed",
            Self::Foretell => "foretelling other recordings",
            Self::Judge => "making the verdict",
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
            Self::Fuller => 0.40,
            Self::LookAgain => 0.45,
            Self::Field => 0.70,
            Self::Beside => 0.75,
            Self::Prune => 0.85,
            Self::Foretell => 0.93,
            Self::Judge => 0.95,
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
