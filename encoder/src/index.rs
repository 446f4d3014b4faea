//! The index: a pulse once a turn of the shaft. It says how many periods a turn has, and at which of them it begins.

use crate::asked::{Question, Refusal};
use crate::input::Input;
use serde::Serialize;
use std::collections::BTreeMap;

/// From so far on, periods, an index is at another period than before. Derived from the nearest: half of one either way.
const OTHER_PERIOD: f64 = 0.5;

/// Where turns begin, by the index.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Index {
    /// Place in the recording's count, whole periods, at which a turn begins: the phase zero next to the index.
    pub zero_periods: i64,
    /// The index' place from there, periods, -0.5 to 0.5: the median of all passes.
    pub after_periods: f64,
    /// Largest distance of a pass from it, periods.
    pub spread_periods: f64,
    /// How often it was passed.
    pub passes: usize,
}

/// The index of a recording, and the periods of a turn; none without an index, or where it was passed in one place and nobody says how many
/// periods a turn has.
pub(crate) fn index(input: &Input, question: &Question) -> Result<Option<(Index, u32)>, Refusal> {
    if input.index.is_empty() {
        return Ok(None);
    }
    let passes = passes(input)?;
    let Some(periods) = question.periods_per_turn.or_else(|| between(&passes)) else {
        return Ok(None);
    };
    let turn = f64::from(periods);
    let first = passes[0].place;
    // Within half a turn of the first.
    let within = |place: f64| (place - first) - turn * ((place - first) / turn).round();
    let mut places: Vec<f64> = passes.iter().map(|pass| within(pass.place)).collect();
    let middle = places.len() / 2;
    let median = *places.select_nth_unstable_by(middle, f64::total_cmp).1;
    let off = |pass: &Pass| (within(pass.place) - median).abs();
    if let Some(other) = passes.iter().find(|pass| off(pass) >= OTHER_PERIOD) {
        return Err(Refusal::OtherPeriod {
            at_s: other.t_s,
            off: within(other.place) - median,
            periods,
        });
    }
    let place = first + median;
    let index = Index {
        zero_periods: place.round() as i64,
        after_periods: place - place.round(),
        spread_periods: passes.iter().map(off).fold(0.0, f64::max),
        passes: passes.len(),
    };
    Ok(Some((index, periods)))
}

/// The edge of the pulse that is passed first going forwards.
#[derive(Clone, Copy, Debug)]
struct Pass {
    t_s: f64,
    /// Periods.
    place: f64,
}

/// Every pass of that edge: up going forwards, down going backwards, so that it is one place of the shaft.
fn passes(input: &Input) -> Result<Vec<Pass>, Refusal> {
    let levels = || input.index.iter().copied().filter(|level| !level.is_nan());
    let low = levels().fold(f64::INFINITY, f64::min);
    let high = levels().fold(f64::NEG_INFINITY, f64::max);
    let rows = || (0..input.index.len()).filter(|row| !input.index[*row].is_nan());
    let is_up = |row: usize| input.index[row] > 0.5 * (low + high);
    let passes: Vec<Pass> = rows()
        .zip(rows().skip(1))
        .filter(|(before, after)| {
            let forwards = input.place[*after] > input.place[*before];
            is_up(*before) != is_up(*after) && is_up(*after) == forwards
        })
        .map(|(before, after)| Pass {
            t_s: input.t_s[after],
            place: 0.5 * (input.place[before] + input.place[after]),
        })
        .collect();
    if passes.is_empty() {
        return Err(Refusal::NoPass);
    }
    Ok(passes)
}

/// Periods of a turn: the way from one pass to the next that comes most often, but for a way back over the same edge.
fn between(passes: &[Pass]) -> Option<u32> {
    let ways = passes
        .windows(2)
        .map(|pair| (pair[1].place - pair[0].place).abs())
        .filter(|way| *way >= OTHER_PERIOD)
        .map(|way| way.round() as u32);
    let mut often: BTreeMap<u32, usize> = BTreeMap::new();
    ways.for_each(|way| *often.entry(way).or_default() += 1);
    let most = often.values().copied().max()?;
    often
        .into_iter()
        .find_map(|(way, times)| (times == most).then_some(way))
}
