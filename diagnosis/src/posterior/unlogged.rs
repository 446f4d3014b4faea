//! Causes whose quantity a recording does not log: what keeps its own time may follow them.

use super::weighing::Effect;
use crate::data::prepare::Prepared;
use crate::design::assembly::Options;
use crate::verdict::answer::Verdict;
use effects::Card;

/// What an effect that keeps its own time may as well follow, and this recording does not log.
pub fn unlogged_causes(prepared: &Prepared, options: &Options, name: &str) -> Vec<&'static str> {
    let card = effects::card(name).filter(|card| card.keeps_its_own_time());
    let logged = &prepared.observations.temperature_c;
    let is_logged = logged.iter().any(|t| t.is_finite());
    let allowed = |name: &str| !options.without.iter().any(|w| w == name);
    let confusable = card.map_or(&[][..], |card| card.confusable).iter();
    let follows = |with: &&str| effects::has(with, Card::follows_temperature) && allowed(with);
    confusable
        .map(|other| other.with)
        .filter(|with| !is_logged && follows(with))
        .collect()
}

/// The motion that tells an effect from what it may follow, with the quantity logged beside it.
pub fn with_the_temperature(motion: &str) -> String {
    format!("{motion}, with the board's temperature logged beside it (temp_c)")
}

/// What is named, with what it may follow among its aliases, and the verdict that this makes.
pub fn with_unlogged_causes(
    prepared: &Prepared,
    options: &Options,
    verdict: Verdict,
    mut named: Vec<Effect>,
) -> (Verdict, Vec<Effect>) {
    for effect in &mut named {
        let more = unlogged_causes(prepared, options, &effect.name);
        let more: Vec<String> = more.into_iter().map(String::from).collect();
        let motion = effects::telling_motion(&effect.name);
        if !more.is_empty() {
            effect.break_alias = motion.map(with_the_temperature);
            effect.aliases.extend(more);
        }
    }
    let is_alias = verdict == Verdict::Named && named.iter().any(|e| !e.aliases.is_empty());
    let verdict = if is_alias { Verdict::Alias } else { verdict };
    (verdict, named)
}
