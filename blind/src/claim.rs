//! What was claimed of the gap after, beside what is true of it.

use diagnosis::verdict::answer::{HeldOut, HeldOutChannel};
use serde::{Deserialize, Serialize};

/// Claims are right within this share: that which `check` confirms by.
pub const CLAIM_WITHIN: f64 = diagnosis::verdict::confirmation::WITHIN;

/// What was claimed of the gap after, and what is true of it; rms over the simulator's own scatter.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Claim {
    /// Before, as claimed.
    pub before: f64,
    /// After, as claimed.
    pub claimed: f64,
    /// After, by `check` on the second recording.
    pub confirmed: Option<f64>,
    /// Largest difference of any channel's rms, as a share of the confirmed one.
    pub worst_channel: Option<f64>,
    /// Channels whose confirmed rms lies in the claimed 95 % interval, and those that were looked at.
    pub within_interval: [usize; 2],
    /// Best possible: the same courier, motion and noise, what its effects add known exactly.
    pub best: Option<f64>,
}

impl Claim {
    /// Of an answer, its check, and its best possible.
    #[must_use]
    pub fn new(answer: &HeldOut, again: Option<&HeldOut>, best: Option<&HeldOut>) -> Self {
        let pairs: Vec<_> = again.map_or(Vec::new(), |again| channels(answer, again));
        let within = |(claimed, confirmed): &&(&HeldOutChannel, &HeldOutChannel)| {
            let [low, high] = claimed.after_ci95_m;
            (low..=high).contains(&confirmed.after_rms_m)
        };
        let difference = |(claimed, confirmed): &(&HeldOutChannel, &HeldOutChannel)| {
            (claimed.after_rms_m / confirmed.after_rms_m - 1.0).abs()
        };
        Self {
            before: answer.whitened_before,
            claimed: answer.whitened_after,
            confirmed: again.map(|a| a.whitened_after),
            worst_channel: again.map(|_| pairs.iter().map(difference).fold(0.0, f64::max)),
            within_interval: [pairs.iter().filter(within).count(), pairs.len()],
            best: best.map(|b| b.whitened_before),
        }
    }

    /// Whether the claim is confirmed within `CLAIM_WITHIN`.
    #[must_use]
    pub fn holds(&self) -> Option<bool> {
        self.confirmed
            .map(|c| (self.claimed / c - 1.0).abs() <= CLAIM_WITHIN)
    }

    /// Whether it is in every channel by itself.
    #[must_use]
    pub fn holds_in_each(&self) -> Option<bool> {
        self.worst_channel.map(|worst| worst <= CLAIM_WITHIN)
    }

    /// Shares of the squared gap that are closed: as claimed, and as the second recording shows.
    #[must_use]
    pub fn closed(&self) -> Option<[f64; 2]> {
        let gap = |v: f64| (v * v - 1.0).max(0.0);
        let before = gap(self.before);
        let confirmed = self.confirmed.filter(|_| before > 0.0)?;
        Some([self.claimed, confirmed].map(|after| 1.0 - gap(after) / before))
    }

    /// Whether it is within `CLAIM_WITHIN` of the best possible.
    #[must_use]
    pub fn best_reached(&self) -> Option<bool> {
        self.best.map(|b| self.claimed / b - 1.0 <= CLAIM_WITHIN)
    }
}

/// Channels of an answer beside the same of its check.
fn channels<'a>(
    answer: &'a HeldOut,
    again: &'a HeldOut,
) -> Vec<(&'a HeldOutChannel, &'a HeldOutChannel)> {
    let beside = |c: &'a HeldOutChannel| {
        let same = again.channels.iter().find(|a| a.channel == c.channel);
        same.map(|a| (c, a))
    };
    answer.channels.iter().filter_map(beside).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn held_out(whitened: [f64; 2], after_rms_m: f64) -> HeldOut {
        let channel = HeldOutChannel {
            channel: "g_p".into(),
            after_rms_m,
            after_ci95_m: [0.9, 1.1],
            ..HeldOutChannel::default()
        };
        HeldOut {
            whitened_before: whitened[0],
            whitened_after: whitened[1],
            channels: vec![channel],
        }
    }

    #[test]
    fn a_claim_beside_its_check() {
        let claim = |confirmed| {
            let again = held_out([3.0, confirmed], confirmed);
            Claim::new(&held_out([3.0, 1.0], 1.0), Some(&again), None)
        };
        let right = claim(1.05);
        assert_eq!(
            (right.holds(), right.holds_in_each()),
            (Some(true), Some(true))
        );
        assert_eq!(right.within_interval, [1, 1]);
        let [claimed, confirmed] = right.closed().unwrap();
        assert!(claimed == 1.0 && (confirmed - (1.0 - 0.1025 / 8.0)).abs() < 1e-9);
        let wrong = claim(1.2);
        assert_eq!(
            (wrong.holds(), wrong.holds_in_each()),
            (Some(false), Some(false))
        );
        assert_eq!(wrong.within_interval, [0, 1]);
        assert_eq!(
            Claim::new(&held_out([3.0, 1.0], 1.0), None, None).holds_in_each(),
            None
        );
    }
}
