//! What is kept of a diagnosis.

use diagnosis::verdict::answer::{HeldOut, Share, Unexplained};
use diagnosis::{Options, Verdict, check, diagnose_fully};
use recording::Recording;
use serde::{Deserialize, Serialize};

/// Verdict, names and numbers, every number at full length.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Answer {
    /// The verdict.
    pub verdict: Verdict,
    /// What is named, by share.
    pub effects: Vec<Named>,
    /// The excess of each channel, m, and its interval.
    pub excess_m: Vec<[f64; 3]>,
    /// Where the gap lies.
    pub place: Vec<Share>,
    /// What the effects leave.
    pub held_out: Residual,
    /// What nothing named explains, without what is told of it beyond its share and its places: these are further fits of the same columns.
    pub unexplained: Unexplained,
    /// What the model leaves on the other recording of the same courier.
    #[serde(default, skip_serializing_if = "Option::is_none")]
    pub checked: Option<Residual>,
}

/// Odds of a thousand to one and more are kept as these: they are exponentials of what rounding moves.
const MOST_WEIGHT: f64 = 0.999;

/// An effect that is named.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Named {
    /// Its name.
    pub name: String,
    /// Its weight among all that would do in its place, of which its probability is made, at most `MOST_WEIGHT`.
    pub weight: f64,
    /// What explains the same.
    #[serde(default, skip_serializing_if = "Vec::is_empty")]
    pub aliases: Vec<String>,
    /// Share of the squared excess.
    pub share: f64,
    /// Largest channel's rms with this effect alone, m.
    pub alone_m: f64,
    /// Its amounts, each with its standard deviation (zero where none is told), in the units of the diagnosis.
    pub amounts: Vec<[f64; 2]>,
}

/// Held-out residuals.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Residual {
    /// Over the simulator's own scatter, before and after.
    pub whitened: [f64; 2],
    /// Of each channel: before, after, floor, rms m.
    pub channels_m: Vec<[f64; 3]>,
}

impl Residual {
    fn new(held_out: &HeldOut) -> Self {
        let channels = held_out.channels.iter();
        Self {
            whitened: [held_out.whitened_before, held_out.whitened_after],
            channels_m: channels
                .map(|c| [c.before_rms_m, c.after_rms_m, c.floor_rms_m])
                .collect(),
        }
    }
}

/// Diagnoses `first`, checks the model on `second` if there is one, and keeps the answer.
#[must_use]
pub fn answer(first: &Recording, second: Option<&Recording>) -> Answer {
    let told = diagnose_fully(first, "frozen", &Options::default());
    let checked = told.model.as_ref().zip(second);
    let diagnosis = told.diagnosis;
    let named = diagnosis.effects.into_iter().map(|e| Named {
        amounts: e
            .magnitude
            .iter()
            .map(|m| [m.value, m.deviation.unwrap_or(0.0)])
            .collect(),
        name: e.name,
        weight: e.odds.weight().min(MOST_WEIGHT),
        aliases: e.aliases,
        share: e.share,
        alone_m: e.gap_after_alone_m,
    });
    Answer {
        verdict: diagnosis.verdict,
        effects: named.collect(),
        excess_m: diagnosis
            .gap
            .iter()
            .map(|g| [g.excess_rms_m, g.excess_ci95_m[0], g.excess_ci95_m[1]])
            .collect(),
        place: diagnosis.place,
        held_out: Residual::new(&diagnosis.held_out),
        unexplained: Unexplained {
            follows: Vec::new(),
            correction: None,
            ..diagnosis.unexplained
        },
        checked: checked
            .and_then(|(model, second)| check(model, second).ok())
            .map(|held_out| Residual::new(&held_out)),
    }
}
