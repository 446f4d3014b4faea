//! The noise of a recording's readings, by what its poses leave and by how much of them the unknowns took.

use crate::key::{Key, Name, Platen};
use crate::member::Member;
use crate::state::State;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use tooth_map::{Left, Linear, Noise};

/// Most of a recording's equations that its unknowns are taken to have spent. Derived from the fewest poses, 100: 30 equations are left, of which
/// a size is told to an eighth.
const MOST_SPENT: f64 = 0.9;

/// What a recording's poses leave at a state.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Shown {
    /// Of their constraints.
    left: Left,
    /// The least noise that is believed.
    stated: Noise,
    /// How many there are.
    poses: usize,
}

/// Equations that unknowns took, by their owners: of an unknown it is the share of its prior variance that the data have taken away,
/// and of all together the trace of what takes readings to fitted ones.
pub struct Spent {
    couriers: BTreeMap<Name, f64>,
    recordings: BTreeMap<Name, f64>,
    platens: BTreeMap<Platen, f64>,
}

impl Shown {
    /// Of a recording's linearised poses.
    pub fn of(member: &Member, lines: &[Linear]) -> Self {
        Self {
            left: Left::of(lines),
            stated: member.setup.stated_noise(),
            poses: lines.len(),
        }
    }

    /// The noise that shows in it.
    pub fn noise(&self, recording: &str, state: &State, spent: &Spent) -> Noise {
        let share = self.share_spent(recording, state, spent);
        self.left.noise(&self.stated, share)
    }

    /// Equations of g_p that the unknowns have not taken.
    pub fn free(&self, recording: &str, state: &State, spent: &Spent) -> f64 {
        self.poses as f64 * (1.0 - self.share_spent(recording, state, spent))
    }

    /// Share of a recording's equations that the unknowns took; what is spent on a courier and on a platen is divided among their recordings.
    fn share_spent(&self, recording: &str, state: &State, spent: &Spent) -> f64 {
        let mut taken = spent.recordings.get(recording).copied().unwrap_or(0.0);
        if let Some(placed) = state.recordings.get(recording) {
            let [of_courier, over_platen] = state.counts(placed);
            let courier = spent.couriers.get(&placed.courier);
            let platen = spent.platens.get(&placed.platen);
            taken += courier.map_or(0.0, |spent| spent / of_courier);
            taken += platen.map_or(0.0, |spent| spent / over_platen);
        }
        (taken / (3.0 * self.poses as f64)).clamp(0.0, MOST_SPENT)
    }
}

impl Spent {
    /// By what is left of each unknown's prior variance.
    pub fn of(shares_left: impl IntoIterator<Item = (Platen, Key, f64)>) -> Self {
        let mut spent = Self {
            couriers: BTreeMap::new(),
            recordings: BTreeMap::new(),
            platens: BTreeMap::new(),
        };
        for (platen, key, left) in shares_left {
            let of_it = match key {
                Key::Courier(courier, _) => spent.couriers.entry(courier).or_default(),
                Key::Recording(recording, _) => spent.recordings.entry(recording).or_default(),
                _ => spent.platens.entry(platen).or_default(),
            };
            *of_it += 1.0 - left;
        }
        spent
    }
}
