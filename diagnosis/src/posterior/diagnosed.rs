//! A recording, decided by the posterior: decide, linearise about what was found, decide again.

use super::by_noise::{by_noise, by_quieter_noise};
use super::decision::{Decision, Inclusion, Masses, Reason};
use super::explained::Row;
use super::field::{by_field, lies_over_the_platen};
use super::fuller::{self, Fuller};
use super::look::{Look, compared, design, likelier, look};
use super::trial::{SAMPLES, Trial, has_knots};
use super::unlogged::with_unlogged_causes;
use super::weighing::Effect;
use crate::data::prepare::Prepared;
use crate::design::assembly::{Design, DesignOptions, Options};
use crate::design::thinned::thinned;
use crate::figures::far_forms::far_forms;
use crate::figures::measured::Measured;
use crate::linearization::point::LinearizationPoint;
use crate::linearization::relinearized::RelinearizedFit;
use crate::progress::{Stage, Watch};
use crate::trace::log;
use crate::verdict::answer::Verdict;
use effects::Detection;
use effects::sensor::BasisInputs;

/// Times that all is compared about what was found, as long as that finds something else. A bound on the work: the likeliest
/// comparison is told where it has not come to the same twice.
const ROUNDS: usize = 3;
/// What leaves more than this share of the gap may be wrong, and nothing is moved by it. A derivation: at half, the wrong places
/// would be as far off as those of the baseline alone.
const TRUSTED_BELOW: f64 = 0.5;
/// Likeliest other sets that are fitted about themselves, beside the best set without each of its effects. A bound on the work: a fourth is
/// known to first order alone.
const MODES: usize = 3;

/// The answer.
#[derive(Clone, Debug)]
pub struct Answer {
    /// Verdict.
    pub verdict: Verdict,
    /// What is named, the largest first.
    pub effects: Vec<Effect>,
    /// Where what is left lies, most of it first, with shares of it.
    pub places: Vec<(String, f64)>,
    /// Whitened squares over the noise that the best set's effects do.
    pub explained: f64,
    /// Whitened squares over the noise that it leaves, and nothing named explains.
    pub left: f64,
    /// The same as a share of both.
    pub left_share: f64,
    /// Whitened squares over the noise that the best set leaves, what its effects' forms may lack among them.
    pub excess: f64,
    /// Steps of the decision.
    pub reasons: Vec<Reason>,
    /// How the probability is shared.
    pub masses: Masses,
    /// The likeliest sets, where they were asked for.
    pub sets: Vec<Row>,
    /// Times that all was compared.
    pub rounds: usize,
}

/// A recording that was decided on: all columns, linearised about what was found, and the answer.
pub(crate) struct Decided<'a> {
    /// All columns, linearised about what was found.
    pub(crate) design: Design<'a>,
    /// The best set, fitted about itself.
    pub(crate) fitted: Option<RelinearizedFit<'a>>,
    /// The answer.
    pub(crate) answer: Answer,
}

/// Decides on a prepared recording, and gives what `then` makes of it.
pub(crate) fn decided<T>(
    mut prepared: Prepared,
    options: &Options,
    watch: Watch,
    then: impl FnOnce(&Prepared, Decided) -> T,
) -> T {
    watch(Stage::Compare);
    let (mut first, mut seen) = first_look(&prepared, options);
    if let Some(mask) = seen.mask.take() {
        drop(first);
        prepared.use_only(mask);
        (first, seen) = first_look(&prepared, options);
    }
    watch(Stage::Noise);
    (first, seen) = by_quieter_noise(&prepared, options, first, seen);
    (first, seen) = by_noise(&prepared, options, first, seen);
    let (here, seen, rounds) = settled(&prepared, options, watch, first, seen);
    let sets = if options.explain {
        here.weighing.explained(&here.design)
    } else {
        Vec::new()
    };
    if crate::trace::tracing() {
        here.weighing
            .explained(&here.design)
            .iter()
            .for_each(|row| log(&row.cells().join("  ")));
    }
    let answer = answer(&prepared, options, &here, &seen, rounds);
    let answer = Answer { sets, ..answer };
    let Look { design, fitted, .. } = here;
    let decided = Decided {
        design,
        fitted,
        answer,
    };
    then(&prepared, decided)
}

/// About the baseline, with the forms of effects that do more than amounts of their usual sizes could.
fn first_look<'a>(prepared: &'a Prepared, options: &'a Options) -> (Look<'a>, Measured) {
    let point = prepared.point();
    let of = |design_options| design(prepared, options, &point, design_options);
    let usual = of(DesignOptions::default());
    let first = match far_forms(&usual, &usual.residuals(&[])) {
        Some(forms) => {
            let inputs = BasisInputs {
                forms,
                ..usual.linearized.inputs.clone()
            };
            of(DesignOptions {
                previous_inputs: Some(&inputs),
                ..DesignOptions::default()
            })
        }
        None => usual,
    };
    Look::of(first).measured(prepared, options)
}

/// Decides about what was found, until that stays, with the times that it took.
fn settled<'a>(
    prepared: &'a Prepared,
    options: &'a Options,
    watch: Watch,
    mut here: Look<'a>,
    mut seen: Measured,
) -> (Look<'a>, Measured, usize) {
    watch(Stage::Relinearize);
    let mut point = prepared.point();
    point.noise = here.noise();
    if lies_over_the_platen(&here, &seen) {
        (here, seen) = by_field(prepared, options, &point, here).measured(prepared, options);
    }
    let mut count = 1;
    // Where the rounds come to no end, the likeliest comparison is told: all are of the same rows.
    let mut likeliest: Option<(Look, Measured)> = None;
    loop {
        let decision = here.weighing.decide(seen.white);
        let known = here.weighing.found();
        let by_noise_alone = decision.verdict == Verdict::Named && known.is_empty();
        let told = by_noise_alone || here.codes_explain_it(&seen).is_some();
        // Lines are looked for in what a fit leaves, and may be what was taken for noise before.
        let before_lines = count == 1 && here.is_louder();
        // To first order nothing is left: about the effect's own places there would be no more to find.
        let first_order_is_enough = count == 1 && here.weighing.one_leaves_nothing();
        let done = told || first_order_is_enough;
        if decision.verdict == Verdict::NoGap && !before_lines || done {
            break;
        }
        if count > ROUNDS {
            if let Some(before) = likeliest.take() {
                (here, seen) = likelier((here, seen), before);
                point = here.point();
            }
            break;
        }
        let before = here.noise();
        let next = about_what_was_found(prepared, options, &mut point, &here, &decision);
        count += 1;
        let before_it = (
            std::mem::replace(&mut here, next.0),
            std::mem::replace(&mut seen, next.1),
        );
        if here.weighing.found() == known && point.noise == before {
            break;
        }
        likeliest = Some(match likeliest {
            Some(kept) => likelier(kept, before_it),
            None => before_it,
        });
    }
    let known = here.weighing.found();
    let found = !known.is_empty();
    if here.codes_explain_it(&seen).is_some() {
        return (here, seen, count);
    }
    let verdict = here.weighing.decide(seen.white).verdict;
    watch(Stage::Fuller);
    // Of what is not worth a name no more is asked.
    if verdict == Verdict::Unknown || found && verdict != Verdict::NoGap {
        if !here.holds_a_field() {
            here = by_field(prepared, options, &point, here);
        }
        here = told_more(prepared, options, here);
        (here, seen) = here.measured(prepared, options);
        if !here.weighing.one_leaves_nothing() {
            watch(Stage::Modes);
            (here, seen) = about_another_mode(prepared, options, here, seen);
        }
        // About places that are off by an effect of which more was told, that effect leaves a part of itself.
        let decision = here.weighing.decide(seen.white);
        if here.weighing.found() != known && decision.verdict != Verdict::NoGap {
            let next = about_what_was_found(prepared, options, &mut point, &here, &decision);
            (here, seen) = likelier((here, seen), next);
            count += 1;
        }
    }
    (here, seen, count)
}

/// All compared anew about what was found; `point` becomes what it is compared about.
fn about_what_was_found<'a>(
    prepared: &'a Prepared,
    options: &'a Options,
    point: &mut LinearizationPoint,
    here: &Look<'a>,
    decision: &Decision,
) -> (Look<'a>, Measured) {
    let next = here.next_point();
    let trusted = decision.left_share < TRUSTED_BELOW;
    *point = if trusted {
        next.point
    } else {
        prepared.point()
    };
    point.noise = here.noise();
    let again = DesignOptions {
        line_residuals: Some(&next.residuals),
        search_deflection_waves: decision.verdict == Verdict::Unknown,
        ..here.told()
    };
    let next = look(prepared, options, point, again);
    let (next, seen) = next.measured(prepared, options);
    let (next, seen) = by_noise(prepared, options, next, seen);
    point.noise = next.noise();
    (next, seen)
}

/// All compared about the places that another set leads to when it is fitted about itself, where another set is then the best and the whole
/// comparison is the likelier; the same as before where that is not so. Asked are the best set without each of its effects, and the likeliest of
/// the others: about the best set's places what they say is known to first order alone. Not asked of one effect that leaves nothing but noise. Cost: a fit and a trial for each, and a whole
/// comparison where a trial is likelier.
fn about_another_mode<'a>(
    prepared: &'a Prepared,
    options: &'a Options,
    here: Look<'a>,
    seen: Measured,
) -> (Look<'a>, Measured) {
    let told = here.told();
    let Some(point) = likeliest_mode(prepared, options, &here, &told) else {
        return (here, seen);
    };
    let next = look(prepared, options, &point, told);
    log(&compared(&here, &next));
    // Where the best set stays the best, its own places are the better ones to tell it by.
    let another = next.weighing.found() != here.weighing.found();
    if another && next.log_evidence() > here.log_evidence() {
        next.measured(prepared, options)
    } else {
        (here, seen)
    }
}

/// The point, among those that other sets lead to when they are fitted about themselves, about which the blocks that count are the likeliest;
/// none where they are likelier about the best set's.
fn likeliest_mode<'a>(
    prepared: &'a Prepared,
    options: &Options,
    here: &Look<'a>,
    told: &DesignOptions<'_, 'a>,
) -> Option<LinearizationPoint> {
    let around = here.point();
    let trial = Trial::of(prepared, options, &around, here);
    // A point is where all is compared; fewer samples tell it well enough.
    let whole = &here.design.linearized;
    let mut fewer = whole.moved(whole.baseline.clone(), whole.displacement.clone());
    fewer.mask = thinned(&fewer.mask, SAMPLES);
    let modes = here.weighing.rivals(MODES).into_iter().map(|names| {
        let point = LinearizationPoint {
            noise: here.noise(),
            ..RelinearizedFit::new(&fewer, here.point(), &names).point
        };
        (trial.log_evidence(&point, *told), point)
    });
    modes
        .filter(|(evidence, _)| *evidence > trial.log_evidence_here())
        .max_by(|a, b| a.0.total_cmp(&b.0))
        .map(|(_, point)| point)
}

/// The same with more told of the effects of the best set, one after the other, where that is preferred ([`Look::is_preferred_to`]). Of one effect that leaves nothing but noise no more is asked.
fn told_more<'a>(prepared: &'a Prepared, options: &Options, mut here: Look<'a>) -> Look<'a> {
    let mut ways = fuller::ways().into_iter();
    while let Some((way, with)) = fuller_than(prepared, options, &here, &mut ways) {
        if way.may_be(|| here.fit(), || with.fit()) {
            here = with;
        }
    }
    here
}

/// The next of some ways to tell more by which the comparison is preferred, with that comparison; none where there is no such way, or no more is
/// asked.
fn fuller_than<'a>(
    prepared: &'a Prepared,
    options: &Options,
    here: &Look<'a>,
    ways: &mut impl Iterator<Item = Fuller>,
) -> Option<(Fuller, Look<'a>)> {
    if here.weighing.one_leaves_nothing() {
        return None;
    }
    let inputs = &here.design.linearized.inputs;
    let found = here.weighing.found();
    let mut more = ways.filter_map(|way| Some((way.of(&found, inputs)?, way)));
    let first = more.next()?;
    let point = here.point();
    let trial = Trial::of(prepared, options, &point, here);
    for (inputs, way) in std::iter::once(first).chain(more) {
        let told = DesignOptions {
            previous_inputs: Some(&inputs),
            field: has_knots(&inputs),
            like: Some(&here.design.linearized),
            ..DesignOptions::default()
        };
        log(&way.tells());
        if !trial.is_preferred(&point, told) {
            continue;
        }
        let with = look(prepared, options, &point, told);
        log(&compared(here, &with));
        if with.is_preferred_to(here) {
            return Some((way, with));
        }
    }
    None
}

fn answer(
    prepared: &Prepared,
    options: &Options,
    here: &Look,
    seen: &Measured,
    rounds: usize,
) -> Answer {
    let weighing = &here.weighing;
    let decision = weighing.decide(seen.white);
    let allowed = |name: &str| !options.without.iter().any(|w| w == name);
    let is_noise = |inclusion: &&Inclusion| inclusion.block.is_none();
    let told = decision.named.iter();
    let told = told.filter(|n| !(seen.small_bursts && is_noise(n)));
    let mut named: Vec<Effect> = told.map(|n| weighing.effect(n)).collect();
    let directly = [
        (Detection::AsNoise, here.is_louder()),
        (Detection::AsSlips, !prepared.slips.is_empty()),
        (Detection::AsBursts, seen.bursts),
    ];
    let mut verdict = decision.verdict;
    for (way, there) in directly {
        let name = effects::name_of(way);
        if named.iter().any(|effect| effect.name == name) {
            continue;
        }
        if there && allowed(name) && verdict != Verdict::Unknown {
            named.push(Effect::directly(name));
            verdict = if verdict == Verdict::NoGap {
                Verdict::Named
            } else {
                verdict
            };
        } else if there && !allowed(name) {
            verdict = Verdict::Unknown;
        }
    }
    if verdict == Verdict::Unknown || named.iter().any(|e| !allowed(&e.name)) {
        verdict = Verdict::Unknown;
        named.clear();
    }
    (verdict, named) = with_unlogged_causes(prepared, options, verdict, named);
    let mut places = weighing.places(&decision);
    if let Some((place, share)) = here.codes_explain_it(seen) {
        if verdict != Verdict::NoGap {
            verdict = Verdict::Unknown;
            named.clear();
        }
        places.insert(0, (place.clone(), share));
    }
    Answer {
        verdict,
        effects: named,
        places,
        reasons: decision.reasons,
        masses: decision.masses,
        explained: decision.explained,
        left: decision.left,
        left_share: decision.left_share,
        excess: decision.excess,
        sets: Vec::new(),
        rounds,
    }
}
