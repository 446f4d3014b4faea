//! What is supposed of a recording before it is fitted: which effects act, in which forms, and how loud the readings are.
//!
//! A hypothesis is a value. Whoever supposes something else makes another one; [`crate::linearization::relinearized::fit`] takes
//! the data and a hypothesis, and gives the same fit each time.

use crate::linearization::recording::LinearizedRecording;
use effects::effect::Acts;
use effects::sensor::{BasisInputs, READINGS};

/// A set of effects with their forms, hyperparameters and the noise.
#[derive(Clone, Debug, PartialEq)]
pub struct Hypothesis {
    /// Names of the effects, in the order in which the fit has their columns.
    pub effects: Vec<String>,
    /// What the recording offers, the forms of the effects, and hyperparameters: lines, clips, meshes.
    pub inputs: BasisInputs,
    /// Noise of each reading over the stated one.
    pub noise: [f64; READINGS],
}

impl Hypothesis {
    /// These effects in the forms and with the noise that a linearized recording has.
    pub fn new(effects: &[String], linearized: &LinearizedRecording) -> Self {
        let inputs = BasisInputs {
            skew_moves: false,
            ..linearized.inputs.clone()
        };
        Self {
            effects: effects.to_vec(),
            inputs,
            noise: linearized.noise,
        }
    }

    /// The same effects in the forms of another hypothesis.
    #[must_use]
    pub fn in_forms_of(self, other: &Self) -> Self {
        let known = &other.inputs;
        self.with(&|inputs| {
            inputs.skew_moves = known.skew_moves;
            inputs.growth_told = known.growth_told;
            inputs.gap_told = known.gap_told;
            inputs.forms = known.forms;
        })
    }

    /// The same with changed forms or hyperparameters.
    #[must_use]
    pub fn with(mut self, change: &dyn Fn(&mut BasisInputs)) -> Self {
        change(&mut self.inputs);
        self
    }

    /// Where rulings are skewed, what is periodic beside that may go with the teeth, as their readings tell, or with the place: the same
    /// hypothesis with the place. None where nothing is periodic beside skewed rulings.
    #[must_use]
    pub fn by_place(&self) -> Option<Self> {
        let moves_teeth = |name: &String| effects::has(name, |card| card.acts == Acts::Teeth);
        let applies = self.effects.len() > 1 && self.effects.iter().any(moves_teeth);
        applies.then(|| self.clone().with(&|inputs| inputs.skew_moves = true))
    }
}
