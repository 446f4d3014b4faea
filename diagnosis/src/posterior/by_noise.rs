//! A comparison by another noise than the one in force, where that makes it likelier.

use super::look::{Look, compared, look};
use super::quieter_noise::quieter_noise;
use super::trial::Trial;
use crate::data::prepare::Prepared;
use crate::design::assembly::{DesignOptions, Options};
use crate::figures::measured::{Measured, Noise, noise_beneath_nothing};
use crate::linearization::point::LinearizationPoint;
use crate::linearization::relinearized::RelinearizedFit;
use crate::trace::log;
use crate::verdict::answer::Verdict;

/// The same by noise below the stated one, where less is left than the stated noise would leave, and where that is likelier: what a cause does
/// beneath noise that is stated too loud is hidden by it.
pub(super) fn by_quieter_noise<'a>(
    prepared: &'a Prepared,
    options: &'a Options,
    here: Look<'a>,
    seen: Measured,
) -> (Look<'a>, Measured) {
    let left = here.fitted.as_ref().map(RelinearizedFit::residuals);
    let Some(quieter) = left.and_then(|left| quieter_noise(&here.design, left)) else {
        return (here, seen);
    };
    let point = LinearizationPoint {
        noise: Some(quieter),
        ..here.point()
    };
    let by_it = look(prepared, options, &point, here.told());
    log(&format!(
        "by quieter noise {quieter:.3?}: {}",
        compared(&here, &by_it)
    ));
    if by_it.log_evidence() > here.log_evidence() {
        by_it.measured(prepared, options)
    } else {
        (here, seen)
    }
}

/// The same by another noise of each reading, where that makes the whole comparison likelier: as it is measured of what the best set
/// leaves, of what nothing but the baseline does, or, where it was found to be louder, as it is stated. Lines that were found meanwhile may
/// be what was taken for noise. Where a pattern is left beside the noise, amounts stray by the stated noise; such noise stays only where by it
/// nothing is left that shows, or what is left is shown to be noise. Both are compared as if no form lacked anything: (7a) takes noise for what
/// lacks.
pub(super) fn by_noise<'a>(
    prepared: &'a Prepared,
    options: &'a Options,
    mut here: Look<'a>,
    seen: Measured,
) -> (Look<'a>, Measured) {
    if here.weighing.decide(seen.white).verdict == Verdict::NoGap {
        return (here, seen);
    }
    let around = here.point();
    let by = |point: &LinearizationPoint, noise: Noise| {
        let point = LinearizationPoint {
            noise: Some(noise.over_stated),
            ..point.clone()
        };
        (point, noise.shown)
    };
    let mut points = Vec::new();
    points.extend(seen.noise.map(|noise| by(&around, noise)));
    if here.noise().is_some() {
        let stated = LinearizationPoint {
            noise: None,
            ..around.clone()
        };
        points.push((stated, true));
    } else {
        let beneath_nothing;
        (beneath_nothing, here.design) = noise_beneath_nothing(prepared, options, here.design);
        points.extend(beneath_nothing.map(|noise| by(&prepared.point(), noise)));
    }
    let told = here.told();
    let with_field = DesignOptions {
        field: true,
        ..told
    };
    // A pattern that is left beside the noise may be one of displaced teeth.
    let besides = |shown: bool| (!shown && !told.field).then_some(with_field);
    let each = points.iter().flat_map(|(point, shown)| {
        let told = std::iter::once(told).chain(besides(*shown));
        told.map(move |told| (point, *shown, told))
    });
    let mut ways: Vec<_> = each.collect();
    if !ways.is_empty() {
        let trial = Trial::of(prepared, options, &around, &here);
        ways.retain(|(point, _, told)| {
            trial.is_likelier(point, *told, Look::log_evidence_of_forms)
        });
    }
    let likelihood = Look::log_evidence_of_forms;
    let best = ways
        .into_iter()
        .map(|(point, shown, told)| (look(prepared, options, point, told), shown))
        .max_by(|a, b| likelihood(&a.0).total_cmp(&likelihood(&b.0)));
    if let Some((best, _)) = &best {
        log(&format!("by noise {}", compared(&here, best)));
    }
    match best {
        Some((best, shown)) if likelihood(&best) > likelihood(&here) => {
            let (best, seen_by_it) = best.measured(prepared, options);
            if shown || seen_by_it.white || seen_by_it.nothing_shows {
                (best, seen_by_it)
            } else {
                (here, seen)
            }
        }
        _ => (here, seen),
    }
}
