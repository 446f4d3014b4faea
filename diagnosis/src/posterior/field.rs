//! A field over the platen: when it is looked for, and in which of its ways it is the likeliest.

use super::look::{Look, compared, look};
use super::prior;
use super::trial::Trial;
use crate::data::one_way::is_one_way;
use crate::data::prepare::Prepared;
use crate::design::assembly::{Design, DesignOptions, Options};
use crate::design::single_teeth::single_teeth;
use crate::figures::limits::FIELD_COORDINATES;
use crate::figures::measured::Measured;
use crate::linearization::point::LinearizationPoint;
use crate::trace::log;
use effects::sensor::SingleTeeth;

/// True where what the best set leaves lies over coordinates in which a field over the platen shows. Such a field is looked for before the
/// rounds begin: as long as it is not among the effects, others stand in for it.
pub(super) fn lies_over_the_platen(here: &Look, seen: &Measured) -> bool {
    let decision = here.weighing.decide(seen.white);
    let places = here.weighing.places(&decision);
    places
        .iter()
        .any(|(name, _)| FIELD_COORDINATES.contains(&name.as_str()))
}

/// The same with a field over the platen, where the likeliest set holds it: of teeth of which the sensor reads several at once, or, where that
/// may be, one at a time. None is looked for where one effect explains all, nor where no tooth is passed twice. That a
/// sensor reads single teeth has the prior odds of a cause.
pub(super) fn by_field<'a>(
    prepared: &'a Prepared,
    options: &Options,
    point: &LinearizationPoint,
    mut here: Look<'a>,
) -> Look<'a> {
    if here.weighing.one_explains_all() {
        return here;
    }
    let inputs = here.design.linearized.inputs.clone();
    let comes_back = comes_back(&here.design);
    let one_at_a_time = single_teeth(&here.design).into_iter().map(Some);
    let ways = [None].into_iter().chain(one_at_a_time);
    let within_a_turn = |way: &Option<SingleTeeth>| way.is_some_and(|s| s.a_turn.is_some());
    for single_teeth in ways.filter(|way| comes_back || within_a_turn(way)) {
        let told = DesignOptions {
            previous_inputs: Some(&inputs),
            field: true,
            like: Some(&here.design.linearized),
            single_teeth,
            ..DesignOptions::default()
        };
        let log_odds = single_teeth.map_or(0.0, |_| prior::log_odds());
        let by_field = |look: &Look<'a>| {
            let odds = if look.holds_a_field() { log_odds } else { 0.0 };
            look.log_evidence() + odds
        };
        let trial = Trial::of(prepared, options, point, &here);
        if !trial.is_likelier(point, told, by_field) {
            continue;
        }
        let with = look(prepared, options, point, told);
        log(&compared(&here, &with));
        if with.holds_a_field() && with.log_evidence() + log_odds > here.log_evidence() {
            here = with;
        }
    }
    here
}

/// True unless each segment went one way along its teeth: their place is a clock then, and nothing tells what is theirs from what goes with
/// the time.
fn comes_back(design: &Design) -> bool {
    let linearized = &design.linearized;
    let segments = (0..4).filter(|s| linearized.scope.segments[*s]);
    let mut places = segments.map(|s| {
        let used = (0..linearized.len()).filter(|i| linearized.mask[*i]);
        let place = used.map(|i| linearized.covariates(i).place_m[s][0]);
        place.collect::<Vec<f64>>()
    });
    places.any(|place| !is_one_way(&place))
}
