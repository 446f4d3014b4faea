//! What is told of the recalibration while working.

use super::candidate::Proposal;
use super::config::Mode;
use serde::{Deserialize, Serialize};

/// Why no candidate is looked for.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Idle {
    /// It is off.
    Off,
    /// There is no stored calibration in force that a candidate could be compared with.
    NotStored,
    /// A tooth map is in force, which was made with this very calibration.
    ToothMap,
    /// The last candidate was rejected: another is looked for when another calibration comes in force, or by order.
    Rejected,
    /// The last candidate could not be stored.
    NotKept,
    /// What the calibration left is not known yet: it takes motion that turns, and a window that agrees with what was learned by it.
    NoReference,
    /// The sensor changed before what the calibration left was known. A candidate must surely help without that, and none does so far.
    ChangedBefore,
}

/// How it stands.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub enum State {
    /// No candidate is looked for.
    Idle(Idle),
    /// Nothing that would be sure to help has been found.
    Watching,
    /// A candidate is being tested.
    Testing(Proposal),
    /// A candidate beats the calibration in force.
    Proposed(Proposal),
}

impl State {
    /// The candidate that is proposed.
    #[must_use]
    pub const fn proposed(self) -> Option<Proposal> {
        match self {
            Self::Proposed(proposal) => Some(proposal),
            _ => None,
        }
    }
}

/// What is told of it.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Recalibration {
    /// What becomes of a candidate.
    pub mode: Mode,
    /// How it stands.
    pub state: State,
    /// Candidates that came in force since the board's start.
    pub adopted: u16,
    /// When the last did, seconds since the board's start.
    pub adopted_s: Option<u32>,
}

impl Default for Recalibration {
    fn default() -> Self {
        Self {
            mode: Mode::default(),
            state: State::Idle(Idle::NotStored),
            adopted: 0,
            adopted_s: None,
        }
    }
}

/// What a host can say of it.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize)]
pub enum Order {
    /// What is to become of candidates from now on, over restarts.
    Set(Mode),
    /// The candidate that is proposed is to be stored and come in force.
    Accept,
    /// It is not: none is looked for until another calibration comes in force, or a mode is set.
    Reject,
}

impl core::fmt::Display for Mode {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Off => "off",
            Self::Propose => "propose",
            Self::Automatic => "automatic",
        })
    }
}

impl core::fmt::Display for Idle {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        f.write_str(match self {
            Self::Off => "nothing is looked for",
            Self::NotStored => "waits for a stored calibration in force",
            Self::ToothMap => "rests: the tooth map belongs to this very calibration",
            Self::Rejected => "rests: the last candidate was rejected",
            Self::NotKept => "rests: the last candidate could not be stored",
            Self::NoReference => {
                "waits until motion that turns has shown what the calibration left, and has shown it again"
            }
            Self::ChangedBefore => {
                "the sensor changed before it was known what the calibration left: nothing found that would surely help without that"
            }
        })
    }
}

/// In words, for people.
impl core::fmt::Display for Recalibration {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}: ", self.mode)?;
        match &self.state {
            State::Idle(why) => write!(f, "{why}")?,
            State::Watching => f.write_str("nothing found that would surely help")?,
            State::Testing(candidate) => write!(f, "candidate being tested, {candidate}")?,
            State::Proposed(candidate) => write!(f, "candidate proposed, {candidate}")?,
        }
        match self.adopted_s {
            Some(at_s) => write!(
                f,
                "; {} in force since start, the last at {at_s} s",
                self.adopted
            ),
            None => Ok(()),
        }
    }
}

impl core::fmt::Display for Proposal {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let um = |metres: f32| 1.0e6 * f64::from(metres);
        write!(
            f,
            "moves the position by {:.2} ± {:.2} µm rms, most by segment {}'s order {} ({:.2} µm rms); sure by {:.1} deviations, on unseen rows \
             {:.0} % of what is wanted",
            um(self.moves_m),
            um(self.deviation_m),
            self.segment + 1,
            self.order,
            um(self.size_m),
            self.gain,
            100.0 * self.evidence
        )
    }
}
