//! What a guided capture tells: step by step, and at its end.

use crate::terminal::figure;
use diagnosis::Diagnosis;
use guided::hand::words;
use guided::known::Known;
use guided::motion::Move;
use guided::question::Question;
use serde::Serialize;

/// What is known after some motions, and what is next.
#[derive(Clone, Debug, Serialize)]
pub struct Step {
    /// Time recorded, pauses included, s.
    pub seconds: f64,
    /// What is asked, and how well it is known.
    pub known: Vec<Known>,
    /// The next motion; none: it has ended.
    pub next: Option<Move>,
}

/// How a capture ended.
#[derive(Clone, Debug, PartialEq, Eq, Serialize)]
#[serde(rename_all = "snake_case")]
pub enum Ending {
    /// Everything that was asked is determined.
    Answered,
    /// Everything is determined that motions of this courier can determine; the rest is told with what would help.
    Partly,
    /// No motion of this courier determines any more of it.
    NoMotion,
    /// The time was over before.
    TimeOver,
    /// The user wanted no more.
    Interrupted,
    /// The readings cannot be calibrated.
    Unreadable(String),
}

/// The answer.
#[derive(Clone, Debug, Serialize)]
pub struct Answer {
    /// What was asked.
    pub question: Question,
    /// How it ended.
    pub ending: Ending,
    /// Time from the first sample to the last, s.
    pub seconds: f64,
    /// Motions made.
    pub motions: Vec<Move>,
    /// How well each part is known.
    pub known: Vec<Known>,
    /// The diagnosis, where effects are asked for.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub diagnosis: Option<Diagnosis>,
}

/// Parts that are told one by one in a step; of more, a count and the one that lacks most.
const FEW: usize = 5;

impl Step {
    /// In a line or a few.
    #[must_use]
    pub fn text(&self) -> String {
        let open: Vec<&Known> = self.known.iter().filter(|k| !k.is_determined()).collect();
        let mut lines = vec![format!(
            "{:5.1} s: {} of {} determined",
            self.seconds,
            self.known.len() - open.len(),
            self.known.len()
        )];
        if self.known.len() <= FEW {
            lines.extend(self.known.iter().map(told));
        } else {
            let least = open.iter().min_by(|a, b| a.progress.total_cmp(&b.progress));
            lines.extend(least.map(|known| told(known)));
        }
        lines.extend(self.next.map(|go| format!("         next: {}", words(&go))));
        lines.join("\n")
    }
}

/// One part, with what is known of it.
fn told(known: &Known) -> String {
    let micrometres = |m: f64| figure(1.0e6 * m);
    let deviation = known
        .deviation_m
        .map(|m| format!("± {} µm", micrometres(m)));
    let sizes = match (deviation, known.expected_m) {
        (Some(deviation), Some(expected)) => {
            format!("{deviation} of some {} µm", micrometres(expected))
        }
        (Some(deviation), None) => deviation,
        (None, _) if known.is_beyond_reach => {
            return format!("         {}: nothing within reach shows it", known.name);
        }
        (None, _) => "by what was gone over".to_owned(),
    };
    let state = if known.is_determined() {
        "determined".to_owned()
    } else {
        let rival = known.rival.as_ref().filter(|_| known.told_apart < 0.5);
        let beside = rival.map_or(String::new(), |rival| {
            format!(
                ", {rival} would leave {:.0} % of it",
                100.0 * known.told_apart
            )
        });
        format!("{:.0} % there{beside}", 100.0 * known.progress)
    };
    format!("         {}: {sizes}, {state}", known.name)
}

impl Answer {
    /// True where everything that was asked is answered.
    #[must_use]
    pub fn is_answered(&self) -> bool {
        self.ending == Ending::Answered
    }

    /// How it ended, in a sentence, and why what is missing is missing.
    #[must_use]
    pub fn text(&self) -> String {
        let question = self.question.name();
        let how = match &self.ending {
            Ending::Answered => format!("{question}: answered"),
            Ending::Partly => format!("{question}: answered as far as motion can"),
            Ending::NoMotion => format!("{question}: no motion of this courier tells more"),
            Ending::TimeOver => format!("{question}: not determined when the time was over"),
            Ending::Interrupted => "interrupted; what was recorded is kept".to_owned(),
            Ending::Unreadable(limit) => format!("{question}: not readable: {limit}"),
        };
        let mut lines = vec![format!(
            "{how}; {} motions, {:.1} s",
            self.motions.len(),
            self.seconds
        )];
        lines.extend(self.known.iter().filter(|k| k.is_beyond_reach).map(why));
        lines.extend(self.known.iter().flat_map(inseparable));
        if let Some(diagnosis) = &self.diagnosis {
            let named: Vec<String> = diagnosis
                .effects
                .iter()
                .map(|named| named.name.clone())
                .collect();
            let verdict = serde_json::to_value(diagnosis.verdict).unwrap_or_default();
            let verdict = verdict.as_str().unwrap_or_default().replace('_', " ");
            lines.push(if named.is_empty() {
                format!("diagnosis: {verdict}")
            } else {
                format!("diagnosis: {verdict}, {}", named.join(", "))
            });
        }
        lines.join("\n")
    }
}

/// Why no motion determines a part, and what would help.
fn why(known: &Known) -> String {
    let Some(card) = effects::card(&known.name) else {
        return format!(
            "{}: nothing within reach shows it; go under a beacon, with a coordination sensor",
            known.name
        );
    };
    let needs: Vec<&str> = card.needs.iter().map(|need| need.words()).collect();
    format!(
        "{}: nothing within reach shows it; it needs {}; what tells it: {}",
        known.name,
        needs.join(" and "),
        card.telling_motion
    )
}

/// Rivals that no motion parts a part from, and what would.
fn inseparable(known: &Known) -> Vec<String> {
    let card = effects::card(&known.name);
    let line = |rival: &String| {
        let confusable = card.iter().flat_map(|card| card.confusable);
        let parted = confusable.into_iter().find(|c| c.with == rival);
        let what = parted.map_or(String::new(), |parted| format!(": {}", parted.parted_by));
        format!("{}: no motion here tells it from {rival}{what}", known.name)
    };
    known.inseparable.iter().map(line).collect()
}
