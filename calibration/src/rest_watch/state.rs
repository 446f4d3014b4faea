//! The watch over rests: reference, sums of the tests, what has been told.

use super::kept::RestKept;
use super::reference::Reference;
use super::rest::{Glance, Rest, RestKind};
use super::scores::Scores;
use super::sums::{ALONG, LEFT, Sums, WARMER};
use super::told::{RestChange, RestVerdict, size};
use crate::watch::{Cells, Standing, TAKEN_BACK};

/// Rests that make the reference. Derived from a window's: eight of them, so that the reference adds an eighth to its variance.
pub const REFERENCE: u16 = 128;
/// Rests of a window, each in a quarter of a tooth of its own. Derived from a tooth's sixteen such cells along both axes.
pub const WINDOW: u16 = 16;
/// Words of the set of cells. Derived from the reference's rests: eight times as many cells, of which an eighth are taken at the
/// most.
const CELL_WORDS: usize = 32;
/// What is told, of what is left of a rest. A derivation: places that a work is confined to may differ by one sigma from those of the reference,
/// all of it structure; the middle between what is told and what is left alone is then two sigma off.
const TOLD_SIGMAS: f32 = 3.0;
/// Less is not told, metres. A prior: a diode's drift of a working day.
const LEAST_TOLD_M: f32 = 5.0e-6;
/// Of what is told, at which the calibration is stale. A prior: twice what is told is far beyond chance, and less may go away
/// again.
const STALE: f32 = 2.0;
/// Of what is told of the middle, what is told of a slope, which is stated at full scale. A derivation: it does as much at half of that.
const SLOPES: f32 = 2.0;
/// Rests must lie so far apart along an axis to tell of a slope, a deviation of full scale. A derivation: structure of one sigma over it is a
/// slope of four sigma at full scale, the middle between what is told and what is left alone.
const WIDE: f32 = 0.25;
/// Rests of the reference must lie so far apart. A prior: some two teeth either way, three where places are counted, so that the offset is not
/// that of one place.
const REFERENCE_WIDE: f32 = 0.15;
/// What is left of a rest is at least so much, metres. A prior: what the diode's noise leaves.
const LEAST_SIGMA_M: f32 = 0.5e-6;
/// Of older windows' weight in the present estimate at each further one. A prior: a window says little, and twenty of them count.
const KEPT: f32 = 0.95;

/// All that the watch over one kind of rests keeps.
#[derive(Clone, Debug)]
pub struct RestWatch {
    kind: RestKind,
    watching: bool,
    is_known: bool,
    rest: Rest,
    /// Where places are counted from: under a beacon its middle; on the platen the first rest since the start, no numbers before it, and then
    /// the reference's middle.
    origin: [f32; 2],
    cells: Cells<CELL_WORDS>,
    reference: Reference,
    /// Of the window, or of the reference while that is learned.
    sums: Sums,
    /// Of windows since there was last no sign of a change, fading.
    long: Sums,
    scores: Scores,
    zero_s: u32,
    now_s: u32,
    windows: u32,
    has_told: bool,
    change: RestChange,
}

impl RestWatch {
    /// All zeros, so that a static of it is no part of the image: watches nothing.
    #[must_use]
    pub const fn blank() -> Self {
        Self {
            kind: RestKind::Beacon,
            watching: false,
            is_known: false,
            rest: Rest::NONE,
            origin: [0.0; 2],
            cells: Cells::EMPTY,
            reference: Reference::ZERO,
            sums: Sums::ZERO,
            long: Sums::ZERO,
            scores: Scores::ZERO,
            zero_s: 0,
            now_s: 0,
            windows: 0,
            has_told: false,
            change: RestChange {
                axis: 0,
                goes: super::told::Goes::Alike,
                size_m: 0.0,
                deviation_m: 0.0,
                since_s: 0,
                told_s: 0,
                warmer_k: 0.0,
                limit_m: 0.0,
            },
        }
    }

    /// Begins for a calibration that states these deviations of g_x and g_y ([`stated_m`](super::stated_m)), or of g_p and zero, or watches
    /// nothing.
    pub fn start(&mut self, kind: RestKind, stated_m: Option<[f32; 2]>) {
        *self = Self::blank();
        self.kind = kind;
        if kind == RestKind::Parity {
            self.origin = [f32::NAN; 2];
        }
        if let Some(stated_m) = stated_m {
            self.watching = true;
            // Not a number counts as nothing.
            self.reference.sigma_m = stated_m.map(|sigma_m| LEAST_SIGMA_M.max(sigma_m));
        }
    }

    /// Takes a look at a frame, or that it shows nothing, at so many seconds since the start; whether a window is complete by it, and the
    /// verdict may have changed. Cost: some ten additions, and some hundred at a rest that counts.
    #[inline(never)] // or it is compiled as its caller is, for less smallness
    pub fn take(&mut self, glance: Option<&Glance>, now_s: u32, pitch_m: f32) -> bool {
        let Some(visit) = self.rest.take(glance) else {
            return false;
        };
        if !self.watching || !self.cells.is_new(visit.cell) {
            return false;
        }
        if !self.is_known && self.sums == Sums::ZERO {
            self.reference.offset_m = visit.g_m;
            self.reference.temperature_k = visit.temperature_k;
        }
        let left_m = self.reference.left_m(&visit, pitch_m);
        if !left_m.iter().all(|m| m.is_finite()) {
            return false;
        }
        self.now_s = now_s;
        let warmer_k = visit.temperature_k - self.reference.temperature_k;
        if self.origin[0].is_nan() {
            self.origin = visit.place;
        }
        let [u, v] = [0, 1].map(|axis| visit.place[axis] - self.origin[axis]);
        let [x_m, y_m] = left_m;
        self.sums.add([1.0, u, v, warmer_k, x_m, y_m]);
        let count = self.sums.count();
        if !self.is_known {
            let is_wide = ALONG
                .iter()
                .all(|axis| self.sums.spread(*axis) >= REFERENCE_WIDE);
            if count < f32::from(REFERENCE) || !is_wide {
                return false;
            }
            self.reference = self.reference.of(&self.sums);
            if self.kind == RestKind::Parity {
                for (origin, along) in self.origin.iter_mut().zip(ALONG) {
                    *origin += self.sums.mean(along);
                }
            }
            (self.is_known, self.zero_s) = (true, now_s);
        } else if count < f32::from(WINDOW) {
            return false;
        } else {
            self.compare();
        }
        self.sums = Sums::ZERO;
        self.cells.clear();
        true
    }

    /// Whether a change is told.
    #[must_use]
    pub const fn has_told(&self) -> bool {
        self.has_told
    }

    /// What is known.
    #[must_use]
    pub fn verdict(&self) -> RestVerdict {
        let change = self.has_told.then_some(self.change);
        let standing = match &change {
            _ if !self.watching => Standing::Unwatched,
            Some(change) if change.size_m.abs() >= change.limit_m => Standing::Stale,
            Some(_) => Standing::Drifting,
            None if !self.is_known => Standing::Learning,
            None => Standing::Healthy,
        };
        RestVerdict {
            standing,
            windows: self.windows,
            scatter_m: self.reference.sigma_m,
            at_s: self.now_s,
            change,
        }
    }

    /// What is kept over a restart; none while the reference is being learned.
    #[must_use]
    #[inline(never)]
    pub fn kept(&self) -> Option<RestKept> {
        (self.watching && self.is_known).then_some(RestKept {
            reference: self.reference,
            change: self.has_told.then_some(self.change),
        })
    }

    /// Goes on from what was kept, after [`RestWatch::start`] for the same calibration. Times are then of before this start: zero.
    #[inline(never)]
    pub fn restore(&mut self, kept: &RestKept) {
        (self.is_known, self.reference) = (true, kept.reference);
        if let Some(change) = kept.change {
            (self.has_told, self.change) = (true, change);
            let axis = usize::from(change.axis & 1);
            self.change.limit_m = STALE * self.told_m(axis);
            self.scores = Scores::told(axis);
        }
    }

    fn told_m(&self, axis: usize) -> f32 {
        let sigma_m = self.reference.sigma_m.get(axis).copied().unwrap_or(0.0);
        (TOLD_SIGMAS * sigma_m).max(LEAST_TOLD_M)
    }

    fn compare(&mut self) {
        self.windows = self.windows.saturating_add(1);
        for (axis, sigma_m) in self.reference.sigma_m.into_iter().enumerate() {
            let (told_m, square) = (self.told_m(axis), sigma_m * sigma_m);
            let left = LEFT[axis];
            let (mean_m, of_mean) = (self.sums.mean(left), square / self.sums.count());
            self.scores.add(axis, 0, mean_m, of_mean, told_m);
            let (slopes_m, of_slopes) = self.sums.slopes(left);
            let slopes = ALONG.into_iter().zip(slopes_m).zip(of_slopes).zip(1..);
            for (((along, slope_m), of), number) in slopes {
                if self.sums.spread(along) >= WIDE {
                    let (variance, told_m) = (of * square, SLOPES * told_m);
                    self.scores.add(axis, number, slope_m, variance, told_m);
                }
            }
        }
        if self.scores == Scores::ZERO {
            // No sign of any change: what is summed begins with the next.
            (self.long, self.zero_s) = (Sums::ZERO, self.now_s);
        } else {
            // The first window that shows a change has rests from before it, and a step then looks like what rises with the temperature. It counts
            // until there is another, by half, so that it is fewer rests than any that are whole.
            let is_first = self.long == Sums::ZERO;
            let kept = if self.is_whole() { KEPT } else { 0.0 };
            self.long.fade_in(kept, &self.sums);
            if is_first {
                self.long.fade_in(0.5, &Sums::ZERO);
            }
        }
        self.tell();
    }

    /// Whether a whole window has shown the change.
    fn is_whole(&self) -> bool {
        self.long.count() >= f32::from(WINDOW)
    }

    fn tell(&mut self) {
        let [x, y] = [0, 1].map(|axis| self.scores.evidence(axis));
        let axis = usize::from(y > x);
        if x.max(y) < TAKEN_BACK {
            self.has_told = false;
        } else if x.max(y) >= 1.0 && self.is_whole() || self.has_told {
            let told_s = if self.has_told {
                self.change.told_s
            } else {
                self.now_s
            };
            let sigma_m = self.reference.sigma_m.get(axis).copied().unwrap_or(0.0);
            let (goes, size_m, deviation_m) = size(&self.long, axis, sigma_m);
            self.has_told = true;
            self.change = RestChange {
                axis: self.kind.axis(axis as u8),
                goes,
                size_m,
                deviation_m,
                since_s: self.zero_s,
                told_s,
                warmer_k: self.long.mean(WARMER),
                limit_m: STALE * self.told_m(axis),
            };
        }
    }
}
