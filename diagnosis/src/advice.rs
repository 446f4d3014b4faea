//! The answers in words: one sentence for the verdict, and what to measure next.

use crate::report::{Diagnosis, Named, Verdict};

/// What an effect is, in one sentence.
#[must_use]
pub fn sentence(effect: &str) -> &'static str {
    effects::entry(effect).map_or("", |entry| entry.summary)
}

/// The motion that tells an effect from others, where its sensor side states one.
#[must_use]
pub fn telling_motion(effect: &str) -> Option<&'static str> {
    effects::sensor_sides()
        .iter()
        .find(|side| side.name() == effect)
        .map(|side| side.telling_motion())
}

/// The verdict in a sentence or two, beside the usual resolution.
#[must_use]
pub fn headline(diagnosis: &Diagnosis) -> String {
    crate::headline::headline(diagnosis, crate::headline::RESOLUTION_M).text
}

/// Where the gap lies, as the end of a sentence.
pub(crate) fn located(diagnosis: &Diagnosis) -> String {
    let place = diagnosis
        .unexplained
        .place
        .first()
        .or(diagnosis.place.first());
    place.map_or(String::new(), |p| {
        format!("; it lies over {} ({})", p.coordinate, p.channel)
    })
}

/// Each alias set, likeliest first.
pub(crate) fn alias_sets(diagnosis: &Diagnosis) -> String {
    let sets = diagnosis.effects.iter().map(|effect| {
        let all: Vec<&str> = std::iter::once(&effect.name)
            .chain(&effect.aliases)
            .map(String::as_str)
            .collect();
        all.join(" or ")
    });
    sets.collect::<Vec<_>>().join("; ")
}

/// Names in a row.
pub(crate) fn joined(names: &[&str]) -> String {
    match names {
        [] => "Nothing".into(),
        [one] => (*one).into(),
        [most @ .., last] => format!("{} and {last}", most.join(", ")),
    }
}

/// What to record or do next, most useful first. Never empty.
#[must_use]
pub fn next_measurements(diagnosis: &Diagnosis) -> Vec<String> {
    let mut list: Vec<String> = diagnosis
        .notes
        .iter()
        .filter(|_| diagnosis.verdict == Verdict::InsufficientData)
        .cloned()
        .collect();
    for effect in &diagnosis.effects {
        list.extend(part_aliases(effect));
    }
    match diagnosis.verdict {
        Verdict::NoGap => list.push(
            "Nothing is missing. Repeat after a change of platen, mount or temperature.".into(),
        ),
        Verdict::Named | Verdict::Alias => {
            list.push(
                "Confirm on another recording of the same courier: courier check MODEL RECORDING."
                    .into(),
            );
            for effect in diagnosis
                .effects
                .iter()
                .filter(|effect| effect.aliases.is_empty() && effect.probability < 0.9)
            {
                if let Some(motion) = telling_motion(&effect.name) {
                    list.push(format!("To be surer of {}: {motion}.", effect.name));
                }
            }
        }
        Verdict::Unknown => {
            if let Some(place) = diagnosis.unexplained.place.first() {
                list.push(format!(
                    "Vary {} and nothing else: that is where {} of the rest lies.",
                    place.coordinate,
                    percent(place.share)
                ));
            }
            list.push("Record against an independent reference (ref_x_m, ref_y_m): it parts the segments from each other.".into());
        }
        Verdict::InsufficientData => list.push(
            "Record the usual runs: scatter, fly-bys both ways, and those under a beacon.".into(),
        ),
    }
    list
}

fn part_aliases(effect: &Named) -> Option<String> {
    if effect.aliases.is_empty() {
        return None;
    }
    let others: Vec<&str> = effect.aliases.iter().map(String::as_str).collect();
    let motion = effect
        .break_alias
        .as_deref()
        .or(telling_motion(&effect.name))?;
    Some(format!(
        "To part {} from {}: {motion}.",
        effect.name,
        joined(&others)
    ))
}

/// A share as a percentage.
#[must_use]
pub fn percent(share: f64) -> String {
    format!("{:.0} %", 100.0 * share)
}
