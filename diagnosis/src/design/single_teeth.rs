//! Teeth of a platen, or pole pairs of a ring, that a sensor reads one at a time.

use crate::data::turn::periods_of_turn;
use crate::design::assembly::Design;
use crate::trace::log;
use effects::sensor::SingleTeeth;

/// The ways in which a field of single teeth may be asked for: where the same ones come round again, those of a turn, and then each as another.
/// A courier's segments read several teeth at once: none is asked for but of one segment alone, beside its reference.
pub fn single_teeth(design: &Design) -> Vec<SingleTeeth> {
    let inputs = &design.linearized.inputs;
    let mut segments = (0..4).filter(|s| inputs.segments[*s]);
    let (Some(segment), None, true) = (segments.next(), segments.next(), inputs.reference) else {
        return Vec::new();
    };
    let of_turn = turn(design, segment);
    log(&format!("teeth of a turn: {of_turn:?}"));
    let within_a_turn = of_turn.map(Some).into_iter();
    let ways = within_a_turn.chain([None]);
    ways.map(|a_turn| SingleTeeth { a_turn }).collect()
}

/// Periods after which what the baseline leaves of a segment comes again.
fn turn(design: &Design, segment: usize) -> Option<u32> {
    let linearized = &design.linearized;
    let residuals = design.residuals(&[]);
    let place = residuals
        .sample
        .iter()
        .map(|i| linearized.covariates(*i).place_m[segment][0] / linearized.observations.pitch_m);
    periods_of_turn(&place.collect::<Vec<f64>>(), &residuals.value_m)
}
