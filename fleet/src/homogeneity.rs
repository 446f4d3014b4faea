//! Whether a courier reads the field that it shares with others as they do: what its poses leave there, against what they leave where the recording has
//! a field of its own.
//!
//! That field is one of cubic B-splines, which takes no aperture for granted. Both sizes are of g_p, robust, and over the equations that the unknowns
//! have not taken. The logarithm of their ratio has a mean of zero or less where all couriers are alike, and of both together a variance of
//! `1 / (0.37 n)` for n such equations: a median absolute deviation is as good as 37 % of the values (Rousseeuw and Croux 1993).

use crate::member::Member;
use crate::passes::Fitted;
use crate::shown::Spent;
use serde::Serialize;

/// Share of the values that a median absolute deviation is as good as. As published, derived from the normal distribution (Rousseeuw and Croux
/// 1993): 37 %.
const EFFICIENCY: f64 = 0.37;
/// Deviations from which on a courier is said not to fit. Derived from the normal distribution: chance names one of 30,000.
const TOO_MANY: f64 = 4.0;

/// How well a courier fits the fields that it shares.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize)]
pub struct Fits {
    /// What its poses leave of g_p in the shared fields, over what they leave in fields of their own.
    pub ratio: f64,
    /// The ratio's logarithm in deviations of chance; negative where the shared fields leave less.
    pub deviations: f64,
}

impl Fits {
    /// True of a courier that chance does not explain.
    #[must_use]
    pub fn is_astray(&self) -> bool {
        self.deviations > TOO_MANY
    }
}

/// Of some recordings of one courier, by their numbers among the members.
pub fn fits(members: &[Member], fitted: &Fitted, spent: &Spent, of: &[usize]) -> Fits {
    let (mut logs, mut count) = (0.0, 0.0);
    for i in of {
        let (name, shown) = (&members[*i].recording, &fitted.shown[*i]);
        let Some([alone_m, _]) = fitted.beginnings[*i].state.noise_m.get(name) else {
            continue;
        };
        let shared_m = shown.noise(name, &fitted.state, spent).segment_m;
        let free = shown.free(name, &fitted.state, spent);
        logs += free * (shared_m / alone_m).ln();
        count += free;
    }
    let mean = logs / f64::max(count, 1.0);
    Fits {
        ratio: mean.exp(),
        deviations: mean * (EFFICIENCY * count).sqrt(),
    }
}
