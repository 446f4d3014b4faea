//! What is supposed of an effect before the data.

use super::problem::Prior;
use crate::data::one_way::is_one_way;
use crate::design::coordinate_basis::{logged_columns, with_own_phase};
use crate::design::unlisted::is_unlisted;
use crate::linearization::recording::LinearizedRecording;
use effects::sensor::BasisInputs;
use effects::{Card, Detection};

/// Probability that any one cause acts. A prior: of about twenty effects and as many coordinates that may hold an effect without
/// a name, a courier whose gap is looked into is expected to have one or two.
const ACTS: f64 = 0.05;
/// A shape describes a gap and is no cause. A prior: nine gaps in ten that it describes have a cause in the catalogue
/// (`docs/effects.md`: it is named only where no cause explains the gap better).
const SHAPE: f64 = 0.1;

/// Logarithm of the odds that a cause acts.
pub fn log_odds() -> f64 {
    (ACTS / (1.0 - ACTS)).ln()
}

/// Logarithm of the odds by which the counts speak for a clip that they show: readings pile up at its rails, or it bends the figure that a pair
/// draws. A prior: as good as certain. An amplifier that saturates softly takes a hundred thousand squares off what a whole figure leaves.
const IN_THE_COUNTS: f64 = 2.0e3;

/// An effect before the rows, whose columns are a block.
pub fn prior(name: &str, block: usize, linearized: &LinearizedRecording) -> Prior {
    let shape = effects::has(name, Card::is_shape);
    let seen = is_in_the_counts(name, linearized);
    Prior {
        block,
        log_odds: log_odds()
            + if shape { SHAPE.ln() } else { 0.0 }
            + if seen { IN_THE_COUNTS } else { 0.0 },
        inexactness: effects::inexactness(name),
        shape,
        listed: !is_unlisted(name),
    }
}

/// Shapes of lines in the spectrum (`design/coordinate_basis.rs`).
const FREQUENCY: &str = "frequency";

/// True if a block is of lines in the spectrum, by its name. They follow the clock: what follows the motion does the same whenever it comes
/// by, and what its form lacks does so too.
pub fn is_of_lines(name: &str) -> bool {
    name == FREQUENCY || effects::is(name, Detection::ByLines)
}

/// True if an effect follows a course of its own. That this is the course of a quantity which the recording has would be a coincidence; not so
/// of a temperature that only rises or only falls, which is a clock.
pub fn is_of_own_course(name: &str, linearized: &LinearizedRecording) -> bool {
    effects::has(name, Card::keeps_its_own_time)
        && !is_one_way(&linearized.observations.temperature_c)
}

/// True if a block is of an effect that the counts show by themselves, whatever the rows say.
pub fn is_in_the_counts(name: &str, linearized: &LinearizedRecording) -> bool {
    let shown = |s: usize| {
        let counted = !linearized.observations.pair_counts[s].is_empty();
        counted && linearized.inputs.clip[s].is_some()
    };
    effects::is(name, Detection::ByRails) && (0..4).any(shown)
}

/// Shapes over what the motion has again and again (`design/coordinate_basis.rs`).
const OF_THE_MOTION: [&str; 3] = [
    "speed",
    "speed and own tooth phase",
    "direction and own tooth phase",
];

/// True if a block is of shapes over a quantity that takes the same values at other times, by its name: a logged column, the speed, the direction.
pub fn is_recurring(name: &str, inputs: &BasisInputs) -> bool {
    let mut columns = logged_columns(inputs);
    OF_THE_MOTION.contains(&name)
        || columns.any(|(_, column)| name == column || name == with_own_phase(column))
}
