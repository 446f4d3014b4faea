//! Guided capture: a recording that is added to motion by motion until it answers what is asked.
//!
//! The loop is all that is here: what is known and which motion is next is `guided`'s, the verdict is the diagnosis', the samples are
//! the recorder's, and a `Mover` says how the courier is moved.

mod answer;
mod mover;

pub use answer::{Answer, Ending, Step};
pub use mover::{ByHand, Commanded, Mover, SimulatedHand};

use crate::board::Link;
use crate::interrupt::Interrupted;
use crate::recorder::Recorder;
use anyhow::Result;
use diagnosis::{Diagnosis, Options, Verdict};
use effects::motion::Pose;
use guided::choice::{Outlook, Recorded};
use guided::known::Known;
use guided::motion::{Area, Move, opening};
use guided::question::Question;
use indicatif::ProgressBar;
use std::collections::BTreeSet;

/// What is asked, and within what.
#[derive(Clone, Debug)]
pub struct Order {
    /// The question.
    pub question: Question,
    /// Where motions may go, in the frame of the mover.
    pub area: Area,
    /// Motions stop when this much time is recorded, s.
    pub most_seconds: f64,
}

/// A capture under way.
pub struct Capture<'a> {
    order: &'a Order,
    recorder: &'a mut Recorder,
    mover: &'a mut dyn Mover,
    made: Vec<Move>,
    steps: Vec<Step>,
    at: Pose,
    /// Diagnoses so far, and how many motions each was made of.
    diagnosed: Vec<(usize, Diagnosis)>,
}

/// Motions in a row that bring nothing nearer, after which no more are made for it: each way along each axis, and one turned.
const STALLED: usize = 5;
/// What counts as nearer: a prior, by more than a twentieth.
const NO_NEARER: f64 = 1.05;
/// Motions between two diagnoses: what the first says must stay on motions that it has not seen.
const MOTIONS_A_DIAGNOSIS: usize = 2;

impl<'a> Capture<'a> {
    /// Begins where the courier stands.
    pub fn new(order: &'a Order, recorder: &'a mut Recorder, mover: &'a mut dyn Mover) -> Self {
        Self {
            at: mover.start(&order.area),
            order,
            recorder,
            mover,
            made: Vec::new(),
            steps: Vec::new(),
            diagnosed: Vec::new(),
        }
    }

    /// Moves and records until the question is answered, cannot be, the time is over or the user interrupts; `tell` hears of each step.
    ///
    /// # Errors
    /// The board cannot be reached or refuses a motion.
    pub fn run(
        mut self,
        link: &mut Link,
        bar: &ProgressBar,
        tell: &mut dyn FnMut(&Step) -> Result<()>,
    ) -> Result<Answer> {
        let ending = match self.run_to_end(link, bar, tell) {
            Err(error) if error.is::<Interrupted>() => Ending::Interrupted,
            ending => ending?,
        };
        Ok(self.answer(ending))
    }

    fn run_to_end(
        &mut self,
        link: &mut Link,
        bar: &ProgressBar,
        tell: &mut dyn FnMut(&Step) -> Result<()>,
    ) -> Result<Ending> {
        for go in opening(self.at, &self.order.area) {
            self.make(link, bar, go)?;
        }
        loop {
            let recording = self.recorder.so_far();
            let outlook = Outlook::new(&Recorded {
                recording: &recording,
                made: &self.made,
                at: self.at,
                area: &self.order.area,
                question: self.order.question,
            });
            let outlook = match outlook {
                Ok(outlook) => outlook,
                Err(limit) => return Ok(Ending::Unreadable(limit.to_string())),
            };
            let decided = self.decide(&outlook, &recording);
            let seconds = self.seconds();
            tell(self.step(&outlook, seconds, decided.as_ref().err().copied()))?;
            match decided {
                Ok(ending) => return Ok(ending),
                Err(_) if seconds >= self.order.most_seconds => return Ok(Ending::TimeOver),
                Err(go) => self.make(link, bar, go)?,
            }
        }
    }

    /// How it ends, or the next motion.
    fn decide(
        &mut self,
        outlook: &Outlook,
        recording: &recording::Recording,
    ) -> Result<Ending, Move> {
        if let Some(go) = outlook.next().filter(|_| !self.is_stalled()) {
            return Err(go);
        }
        if outlook.known().iter().all(|known| known.is_beyond_reach) {
            return Ok(Ending::NoMotion);
        }
        let all = outlook.known().iter().all(Known::is_determined);
        let end = if all {
            Ending::Answered
        } else {
            Ending::Partly
        };
        if !self.order.question.is_of_effects() {
            return Ok(end);
        }
        let made = self.made.len();
        let last = self.diagnosed.last();
        if last.is_none_or(|(before, _)| made >= before + MOTIONS_A_DIAGNOSIS) {
            let diagnosis = diagnosis::diagnose(recording, "capture", &Options::default());
            self.diagnosed.push((made, diagnosis));
        }
        if let [.., (_, before), (_, now)] = &self.diagnosed[..]
            && is_same(before, now)
            && settles(now, outlook.known())
        {
            return Ok(end);
        }
        let last = self.diagnosed.last().map(|(_, diagnosis)| diagnosis);
        let named = last.iter().flat_map(|diagnosis| &diagnosis.effects);
        let rivals: Vec<String> = named
            .flat_map(|named| named.aliases.iter().chain([&named.name]).cloned())
            .collect();
        Err(outlook.more_about(&rivals))
    }

    /// True where the last motions have brought nothing nearer: it is as determined as motion makes it.
    fn is_stalled(&self) -> bool {
        let sum = |step: &Step| step.known.iter().map(|k| k.progress).sum::<f64>();
        let progress: Vec<f64> = self.steps.iter().map(sum).collect();
        let Some(before) = progress.len().checked_sub(STALLED) else {
            return false;
        };
        let best = |steps: &[f64]| steps.iter().copied().fold(0.0, f64::max);
        best(&progress[before..]) <= NO_NEARER * best(&progress[..before])
    }

    /// Makes one motion and records it.
    fn make(&mut self, link: &mut Link, bar: &ProgressBar, go: Move) -> Result<()> {
        let from = self.at;
        self.at = self.mover.make(link, self.recorder, bar, go)?;
        self.made.push(Move {
            from,
            to: self.at,
            ..go
        });
        Ok(())
    }

    /// Time from the first sample to the last, s.
    fn seconds(&self) -> f64 {
        self.recorder.seconds()
    }

    fn step(&mut self, outlook: &Outlook, seconds: f64, next: Option<Move>) -> &Step {
        let at = self.steps.len();
        self.steps.push(Step {
            seconds,
            known: outlook.known().to_vec(),
            next,
        });
        &self.steps[at]
    }

    fn answer(mut self, ending: Ending) -> Answer {
        Answer {
            question: self.order.question,
            ending,
            seconds: self.recorder.seconds(),
            motions: self.made,
            known: self.steps.last().map_or(Vec::new(), |s| s.known.clone()),
            diagnosis: self.diagnosed.pop().map(|(_, diagnosis)| diagnosis),
        }
    }
}

/// True for two diagnoses that say the same.
fn is_same(one: &Diagnosis, other: &Diagnosis) -> bool {
    let names = |diagnosis: &Diagnosis| -> BTreeSet<String> {
        diagnosis.effects.iter().map(|e| e.name.clone()).collect()
    };
    one.verdict == other.verdict && names(one) == names(other)
}

/// True for a verdict that further motion is not expected to change: causes or none, and no other that would do and could be told apart.
fn settles(diagnosis: &Diagnosis, known: &[Known]) -> bool {
    let inseparable = |name: &str, alias: &str| {
        known.iter().any(|k| {
            (k.name == name && k.inseparable.iter().any(|i| i == alias))
                || (k.name == alias && k.inseparable.iter().any(|i| i == name))
        })
    };
    let parted = || {
        diagnosis.effects.iter().all(|named| {
            let mut aliases = named.aliases.iter();
            aliases.all(|alias| inseparable(&named.name, alias))
        })
    };
    match diagnosis.verdict {
        Verdict::Named | Verdict::Alias => parted(),
        Verdict::NoGap => true,
        Verdict::Unknown | Verdict::InsufficientData => false,
    }
}
