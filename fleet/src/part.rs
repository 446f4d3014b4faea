//! What one computer forms and another adds: a part of the problem, as a file.

use crate::begin::{Beginning, begin};
use crate::key::{Name, Platen};
use crate::member::Member;
use crate::register::register;
use crate::shown::Shown;
use crate::solve::solve;
use crate::state::State;
use crate::step::{advanced, is_settled};
use crate::sums::{Sums, sums_of};
use anyhow::{Context, Result, bail, ensure};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Version of the file. By definition of its layout.
const VERSION: u64 = 6;

/// What some recordings give: what each says by itself, before there is a state; their sums at a state, once there is one.
#[derive(Clone, Debug, Serialize, Deserialize)]
pub struct Part {
    courier_fleet_part: u64,
    /// Steps of the state that the sums are taken at.
    steps: Option<u32>,
    beginnings: Vec<Beginning>,
    sums: Vec<(Platen, Sums)>,
    shown: BTreeMap<Name, Shown>,
}

/// How far a fit is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Progress {
    /// Steps taken.
    pub steps: u32,

    /// By how much the squares of what is left fall with the last one; none where only the start was found.
    pub decrement: Option<f64>,
    /// No further step counts.
    pub is_settled: bool,
}

impl Part {
    /// Of one recording, at a state if there is one.
    ///
    /// # Errors
    /// A reading is no number; the state does not know the recording.
    pub fn of(member: &Member, state: Option<&State>) -> Result<Self> {
        let mut part = Self {
            courier_fleet_part: VERSION,
            steps: None,
            beginnings: Vec::new(),
            sums: Vec::new(),
            shown: BTreeMap::new(),
        };
        let Some(state) = state else {
            part.beginnings.push(begin(member)?);
            return Ok(part);
        };
        ensure!(
            state.recordings.contains_key(&member.recording),
            "{}: found it in no recording of the state, wanted one from whose parts the state was made",
            member.recording
        );
        let (sums, shown) = sums_of(member, state);
        part.steps = Some(state.steps);
        part.sums.push((member.platen.clone(), sums));
        part.shown.insert(member.recording.clone(), shown);
        Ok(part)
    }

    /// Several as one: in any order and in any grouping, but for the last digits.
    ///
    /// # Errors
    /// They are of several states, or of other versions, or hold one recording twice; there is none.
    pub fn join(parts: impl IntoIterator<Item = Self>) -> Result<Self> {
        let mut parts = parts.into_iter();
        let mut whole = parts.next().context("found no part, wanted one or more")?;
        whole.check()?;
        for part in parts {
            part.check()?;
            ensure!(
                part.steps == whole.steps,
                "found parts at states of {} and {} steps, wanted all at one",
                words(whole.steps),
                words(part.steps)
            );
            for name in part.shown.keys() {
                ensure!(
                    !whole.shown.contains_key(name),
                    "{name}: found it in two parts, wanted it in one"
                );
            }
            whole.shown.extend(part.shown);
            whole.beginnings.extend(part.beginnings);
            for (platen, sums) in part.sums {
                match whole.sums.iter_mut().find(|(name, _)| *name == platen) {
                    Some((_, sum)) => *sum = sum.clone().plus(&sums),
                    None => whole.sums.push((platen, sums)),
                }
            }
        }
        Ok(whole)
    }

    /// The next state, from the one that the part was taken at.
    ///
    /// # Errors
    /// The recordings do not go together, a reading is no number, or the state is not that of the part.
    pub fn next(&self, state: Option<&State>) -> Result<(State, Progress)> {
        self.check()?;
        match (self.steps, state) {
            (None, None) => {
                let progress = Progress {
                    steps: 0,
                    decrement: None,
                    is_settled: false,
                };
                Ok((register(&self.beginnings)?, progress))
            }
            (Some(steps), Some(state)) if steps == state.steps => {
                if let Some(name) = state
                    .recordings
                    .keys()
                    .find(|name| !self.shown.contains_key(*name))
                {
                    bail!("{name}: found it in no part, wanted all recordings of the state");
                }
                let sums = self.sums.iter().cloned().collect();
                let solution = solve(&sums, state, 0.0)?;
                let progress = Progress {
                    steps: state.steps + 1,
                    decrement: Some(solution.decrement),
                    is_settled: is_settled(state, &solution),
                };
                Ok((
                    advanced(&sums, state, &solution, self.shown.clone())?,
                    progress,
                ))
            }
            (steps, state) => bail!(
                "found a part at a state of {} steps and a state of {}, wanted them alike",
                words(steps),
                words(state.map(|state| state.steps))
            ),
        }
    }

    fn check(&self) -> Result<()> {
        let found = self.courier_fleet_part;
        ensure!(
            found == VERSION,
            "courier_fleet_part: found {found}, wanted {VERSION}: made by another version of this command"
        );
        let of_beginnings = self.beginnings.iter().map(|beginning| &beginning.sums);
        let mut all = of_beginnings.chain(self.sums.iter().map(|(_, sums)| sums));
        all.try_for_each(Sums::check)
    }
}

fn words(steps: Option<u32>) -> String {
    steps.map_or("no".to_owned(), |steps| steps.to_string())
}
