//! What a recording is to answer.

use serde::{Serialize, Serializer};

/// A question.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Question {
    /// Equation (3) of each segment.
    Platen,
    /// The same, the terms across a segment, and the coordination sensor's geometry.
    Joint,
    /// Whether a catalogued effect is there.
    Effect(&'static str),
    /// Every effect of the catalogue.
    All,
}

/// [`Question::Platen`] by name.
const PLATEN: &str = "platen";
/// [`Question::Joint`] by name.
const JOINT: &str = "joint";
/// [`Question::All`] by name.
const ALL: &str = "all";

impl Question {
    /// Of a name.
    ///
    /// # Errors
    /// There is no such question; the text says which there are.
    pub fn of(name: &str) -> Result<Self, String> {
        match name {
            PLATEN => Ok(Self::Platen),
            JOINT => Ok(Self::Joint),
            ALL => Ok(Self::All),
            _ => effects::card(name)
                .map(|card| Self::Effect(card.name))
                .ok_or_else(|| {
                    let names: Vec<&str> = effects::cards().map(|card| card.name).collect();
                    format!(
                        "wanted {PLATEN}, {JOINT}, {ALL} or an effect: {}",
                        names.join(", ")
                    )
                }),
        }
    }

    /// Its name.
    #[must_use]
    pub fn name(self) -> &'static str {
        match self {
            Self::Platen => PLATEN,
            Self::Joint => JOINT,
            Self::Effect(name) => name,
            Self::All => ALL,
        }
    }

    /// True where a diagnosis answers it: whether effects are there, and not how large coefficients are.
    #[must_use]
    pub fn is_of_effects(self) -> bool {
        matches!(self, Self::Effect(_) | Self::All)
    }
}

impl Serialize for Question {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        serializer.serialize_str(self.name())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_question_has_a_name_and_a_wrong_one_is_told_all() {
        for name in effects::cards()
            .map(|card| card.name)
            .chain(["platen", "joint", "all"])
        {
            assert_eq!(Question::of(name).unwrap().name(), name);
        }
        let told = Question::of("tooth_resonance").unwrap_err();
        assert!(
            told.contains("platen") && told.contains("velocity_lag"),
            "{told}"
        );
    }
}
