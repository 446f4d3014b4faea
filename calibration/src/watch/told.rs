//! A change that has been told: where it is, how large, and how it goes on.

use super::places::{PLACES, Place};
use super::verdict::Change;
use super::windowed::Windowed;
use crate::math::sqrt;

/// Below it, the other segment of a pair is named too. Derived from a likelihood ratio of 19 (95 %), twice its logarithm.
const CLOSE: f32 = 5.9;
/// A limit that is further away, seconds, is told as this. Derived from the 32 bits that seconds have.
const LONGEST_S: f32 = 4.0e9;
/// Deviations by which a change must have grown since it settled to be foreseen. Derived from a rate that is known to 15 %: the
/// growth is the difference of two sizes, each with a deviation, sqrt(2) / 0.15.
const GROWN: f32 = 9.4;

/// A change that has been told.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Told {
    pub at_s: u32,
    /// Windows by then.
    pub windows: u32,
    /// Temperature then over that of the reference, kelvin.
    pub warmer_k: f32,
    pub now: Present,
    /// From when on it is told how it goes on, and its size then: once the windows before it are forgotten.
    pub base: Option<(u32, f32)>,
}

/// Where a change is, its size and that size's deviation, metres rms.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Present {
    pub place: Place,
    pub or_segment: Option<u8>,
    pub size_m: f32,
    pub deviation_m: f32,
}

impl Told {
    /// All zeros.
    pub const ZERO: Self = Self {
        at_s: 0,
        windows: 0,
        warmer_k: 0.0,
        now: Present {
            place: Place::FIRST,
            or_segment: None,
            size_m: 0.0,
            deviation_m: 0.0,
        },
        base: None,
    };

    /// At a time, where the calibration is stale from `limit_m` on; `zero_s` is when the test of each place was last at zero.
    pub fn change(&self, now_s: u32, limit_m: f32, zero_s: &[u32; PLACES]) -> Change {
        let Present {
            place,
            or_segment,
            size_m,
            deviation_m,
        } = self.now;
        let rate_m_per_s = self.rate_m_per_s(now_s);
        let left_m = (limit_m - size_m).max(0.0);
        Change {
            segment: place.segment() as u8,
            order: place.order(),
            or_segment,
            size_m,
            deviation_m,
            since_s: zero_s.get(place.index()).copied().unwrap_or(0),
            told_s: self.at_s,
            warmer_k: self.warmer_k,
            limit_m,
            limit_in_s: rate_m_per_s.map(|rate| (left_m / rate).min(LONGEST_S) as u32),
        }
    }

    /// By how much it grows, if it does, once it has been followed for longer than it took to settle.
    fn rate_m_per_s(&self, now_s: u32) -> Option<f32> {
        let (base_s, base_m) = self.base?;
        let in_s = now_s.saturating_sub(base_s);
        let grown_m = self.now.size_m - base_m;
        let is_long = in_s >= base_s.saturating_sub(self.at_s);
        (is_long && grown_m > GROWN * self.now.deviation_m).then(|| grown_m / in_s.max(1) as f32)
    }
}

impl Present {
    /// As it was kept.
    pub const fn kept(place: Place, of_either: bool, size_m: f32, deviation_m: f32) -> Self {
        let other = place.other().segment() as u8;
        Self {
            place,
            or_segment: if of_either { Some(other) } else { None },
            size_m,
            deviation_m,
        }
    }

    /// The wave that lowers the sum of squares most.
    pub fn of(sums: &[Windowed; PLACES]) -> Self {
        let gains = Place::all()
            .zip(sums)
            .map(|(place, sum)| (place, sum.gain()));
        let (place, gain) = gains.fold((Place::FIRST, 0.0), |best, next| {
            if next.1 > best.1 { next } else { best }
        });
        let sum = |place: Place| sums.get(place.index());
        let estimate = sum(place).and_then(Windowed::estimate);
        let (size_m, deviation_m) = estimate.map_or((0.0, 0.0), |([a, b], least)| {
            (sqrt(0.5 * (a * a + b * b)), sqrt(0.5 / least))
        });
        let other = place.other();
        let is_close = gain - sum(other).map_or(0.0, Windowed::gain) < CLOSE;
        Self {
            place,
            or_segment: is_close.then(|| other.segment() as u8),
            size_m,
            deviation_m,
        }
    }
}
