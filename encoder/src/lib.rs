//! The errors of one pair from its own recording: values in, values out; no files, no clock, no reference.
//!
//! [`learn`] goes this way: `input` (a recording's segment, cut where its motion is interrupted), `round` (the radius: offset, gain and
//! angle of the channels), `stretches` and `motion` (the angle's orders by the smoothness of the motion, told from a ripple of the
//! speed where there are several speeds, and from what reverses where there are both directions), `index` (where a turn begins, where
//! there is a pulse for it), `turn` (single poles and eccentricity over a turn), `remarks` (what cannot be told, and which motion would tell it). `combined` adds stretches up in f64 and
//! tells how well the sum is known by their scatter, `assembled` makes the [`Answer`]. `forms` writes the constants for other programs.
//!
//! Row by row everything is the device's own code: `courier_signal::encoder`, in f32.

mod answer;
mod asked;
mod assembled;
mod combined;
pub mod forms;
mod index;
mod input;
mod motion;
mod remarks;
mod round;
mod stretches;
mod turn;

pub use answer::{Answer, Channels, Harmonic, Remark, Turn};
pub use asked::{Question, Refusal};
pub use index::Index;
pub use input::{Input, LogUnit};

/// Learns all that the recording tells.
///
/// # Errors
/// Too little motion, or sine and cosine that are no pair.
pub fn learn(input: &Input, question: &Question) -> Result<Answer, Refusal> {
    let round = round::round(input)?;
    let phases = input.phases(round.as_ref().map(|round| &round.pair))?;
    let motion = motion::motion(&phases)?;
    let harmonics = motion.harmonics();
    let calibrated = phases.calibrated(&harmonics);
    let index = index::index(input, question)?;
    let stated = index.as_ref().map(|(_, periods)| *periods);
    let question = &Question {
        periods_per_turn: question.periods_per_turn.or(stated),
    };
    let turn = question
        .periods_per_turn
        .filter(|periods| *periods > 1)
        .and_then(|periods| turn::turn(&calibrated, periods))
        .map(|turn| turn.counted_from(index.map(|(index, _)| index)));
    Ok(assembled::answer(input, question, round, &motion, turn))
}
