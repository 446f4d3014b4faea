//! What outlives a window: the reference, the sums of the tests, and what has been told.

use super::config::WatchConfig;
use super::follow::{Follower, Whole};
use super::kept::Kept;
use super::places::{PLACES, Place};
use super::row::{OWN_COLUMNS, Reading};
use super::scores::Scores;
use super::told::{Present, Told};
use super::verdict::{Standing, Verdict};
use super::window::{LONGEST, SHORTEST, Window};
use super::windowed::Windowed;
use crate::math::sqrt;
use crate::quotient;

/// Pairs of each of the windows that come before the reference, and how many: only by what they find is the correlation known.
const FIRST_PAIRS: u32 = 2 * SHORTEST;
/// Windows that come before the reference: how many.
const FIRST_WINDOWS: u32 = 2;
/// Windows' worth of information in a reference. Derived from what it adds: an eighth of a window's variance.
pub(crate) const REFERENCE_WINDOWS: f32 = 8.0;
/// Of older windows' weight in the present estimate at each further one. Derived from the present's variance: a sum of weights
/// that fall by 0.8 counts nine windows, as many as the reference and itself.
const KEPT: f32 = 0.8;
/// A window of which the variance is so many times the one before's is broken off. A prior: twice the scatter, where that of one
/// place and another differs by a third.
const JUMP: f32 = 4.0;
/// Share of the information on a place that is left beside the other segment's, below which a motion shows the two as one.
/// Derived from its root: a seventh of the length is left, and the other segment's direction is nearer than noise tells.
const AS_ONE: f32 = 0.02;
/// Windows after which a change's size is taken for that from which it goes on: what is older counts a tenth. Derived from
/// `KEPT`: what is older counts 0.8^10, a tenth.
const SETTLED: u32 = 10;
/// Share of the sum that a change is told at below which it is taken back. A prior: half, so that what comes and goes is not told
/// at each turn.
pub(crate) const TAKEN_BACK: f32 = 0.5;
/// Looks at a window, readings. Cost alone: a window ends up to 63 readings later than it could.
const LOOK_EVERY: u32 = 64;

/// All that the watch keeps beside its window.
#[derive(Clone, Debug)]
pub struct Watch {
    config: WatchConfig,
    learning: bool,
    /// No window can be made of this motion.
    stalled: bool,
    reference_m: [f32; OWN_COLUMNS],
    /// The reference is not the first of this calibration: all that it saw counts as told apart, so that none follows by the same motion.
    again: bool,
    /// Places that the reference knows, and those of them that it tells from the other segment's. Where a window shows more, that is learned
    /// before it is judged.
    known: u16,
    apart: u16,
    /// The reference tells each segment's amounts from the other's of its pair: all that a recalibration may compare with.
    tells_apart: bool,
    /// A window that shows all places has agreed with the reference since it was learned. Until then a change may have come within it, and
    /// what was there from the first is no change that a recalibration may take back.
    agreed: bool,
    scores: [Scores; PLACES],
    /// When each place's test was last at zero, seconds.
    zero_s: [u32; PLACES],
    /// Places that the last window, or the reference, determined.
    seen: u16,
    /// Whether what follows has been told: no option, of which nothing would not be zeros.
    has_told: bool,
    told: Told,
    windows: u32,
    now_s: u32,
    sigma_m: f32,
    correlation: f32,
    temperature_k: f32,
    reference_temperature_k: f32,
    /// Deviation of a row of the windows that made the reference.
    reference_sigma_m: f32,
    /// By how much the calibration has been amended since the reference was learned, metres rms.
    amended_m: f32,
}

impl Watch {
    /// All zeros, so that a static of it is no part of the image; [`Watch::start`] comes before all else.
    #[must_use]
    pub const fn blank() -> Self {
        Self {
            config: WatchConfig {
                told_rms_m: 0.0,
                stale_rms_m: 0.0,
                residual_m: 0.0,
                uncertainty_m: 0.0,
                slopes: [0.0; 3],
                apart: 0.0,
                score: 0.0,
            },
            learning: false,
            stalled: false,
            reference_m: [0.0; OWN_COLUMNS],
            again: false,
            known: 0,
            apart: 0,
            tells_apart: false,
            agreed: false,
            scores: [Scores::ZERO; PLACES],
            zero_s: [0; PLACES],
            seen: 0,
            has_told: false,
            told: Told::ZERO,
            windows: 0,
            now_s: 0,
            sigma_m: 0.0,
            correlation: 0.0,
            temperature_k: 0.0,
            reference_temperature_k: 0.0,
            reference_sigma_m: 0.0,
            amended_m: 0.0,
        }
    }

    /// Begins for a calibration.
    #[must_use]
    pub fn new(config: WatchConfig) -> Self {
        let mut watch = Self::blank();
        watch.start(config);
        watch
    }

    /// Begins for a calibration, in place.
    pub fn start(&mut self, config: WatchConfig) {
        *self = Self::blank();
        self.config = config;
        self.learning = true;
        self.sigma_m = config.residual_m;
    }

    /// What it is for.
    #[must_use]
    pub fn config(&self) -> &WatchConfig {
        &self.config
    }

    /// Takes a reading into the window; whether a window is complete by it, and the verdict may have changed. Cost: a row of 73 unknowns
    /// for a reading that counts, all but nothing for the others; a complete window some ten rows'.
    pub fn take(
        &mut self,
        window: &mut Window,
        reading: &Reading,
        follower: &mut impl Follower,
    ) -> bool {
        if !window.has_begun() {
            self.begin(window);
        }
        if !window.take(reading) {
            return window.is_exhausted() && self.give_up(window, follower);
        }
        let taken = window.taken();
        self.now_s = quotient(reading.time_ms, 1000) as u32;
        self.temperature_k += (reading.temperature_delta_k - self.temperature_k) / SHORTEST as f32;
        if taken < SHORTEST || !taken.is_multiple_of(LOOK_EVERY) {
            return false;
        }
        self.look(window, taken >= LONGEST, follower)
    }

    /// The largest sum of all tests, of that at which a change is told.
    #[must_use]
    pub fn evidence(&self) -> f32 {
        let largest = self.scores.iter().map(Scores::largest);
        largest.fold(0.0, f32::max) / self.config.score
    }

    /// By how much the calibration has been amended since the reference was learned, metres rms.
    #[must_use]
    pub const fn amended_m(&self) -> f32 {
        self.amended_m
    }

    /// Whether a change is told.
    #[must_use]
    pub const fn has_told(&self) -> bool {
        self.has_told
    }

    /// Whether a recalibration may compare with the reference: it tells the segments of a pair apart, and a window has agreed with it.
    #[must_use]
    pub const fn is_measure(&self) -> bool {
        self.tells_apart && self.agreed
    }

    /// What is kept over a restart; none while the reference is being learned.
    #[must_use]
    pub fn kept(&self) -> Option<Kept> {
        (!self.learning).then_some(Kept {
            reference_m: self.reference_m,
            known: self.known,
            apart: self.apart,
            is_measure: self.is_measure(),
            waits: self.tells_apart && !self.agreed,
            sigma_m: self.reference_sigma_m,
            correlation: self.correlation,
            temperature_k: self.reference_temperature_k,
            amended_m: self.amended_m,
            told: self.has_told.then_some(self.told),
        })
    }

    /// Goes on from what was kept, after [`Watch::start`] for the same calibration. Times are then of before this start: zero.
    pub fn restore(&mut self, kept: &Kept) {
        (self.learning, self.seen) = (false, u16::MAX);
        self.reference_m = kept.reference_m;
        (self.known, self.apart) = (kept.known, kept.apart);
        self.agreed = kept.is_measure;
        self.tells_apart = kept.is_measure | kept.waits;
        (self.sigma_m, self.reference_sigma_m) = (kept.sigma_m, kept.sigma_m);
        self.correlation = kept.correlation;
        self.temperature_k = kept.temperature_k;
        self.reference_temperature_k = kept.temperature_k;
        self.amended_m = kept.amended_m;
        if let Some(told) = kept.told {
            (self.has_told, self.told) = (true, told);
            if let Some(scores) = self.scores.get_mut(told.now.place.index()) {
                *scores = Scores::told(self.config.score);
            }
        }
    }

    /// What is known.
    #[must_use]
    pub fn verdict(&self) -> Verdict {
        let limit_m = self.config.stale_rms_m;
        let told = self.has_told.then_some(&self.told);
        let change = told.map(|told| told.change(self.now_s, limit_m, &self.zero_s));
        let standing = match &change {
            Some(change) if change.size_m >= limit_m => Standing::Stale,
            Some(_) => Standing::Drifting,
            None if self.stalled => Standing::NotObservable,
            None if self.learning => Standing::Learning,
            None if self.seen != u16::MAX => Standing::NotObservable,
            None => Standing::Healthy,
        };
        Verdict {
            standing,
            seen: self.seen,
            windows: self.windows,
            scatter_m: self.sigma_m,
            at_s: self.now_s,
            change,
        }
    }

    /// Ends a window that learns nothing new any more.
    fn give_up(&mut self, window: &mut Window, follower: &mut impl Follower) -> bool {
        let is_reference = !self.learning || self.windows >= FIRST_WINDOWS;
        if window.taken() >= SHORTEST && is_reference {
            return self.look(window, true, follower);
        }
        (self.seen, self.stalled) = (0, true);
        self.begin(window);
        true
    }

    fn look(&mut self, window: &mut Window, is_last: bool, follower: &mut impl Follower) -> bool {
        if self.learning {
            self.learn(window, is_last)
        } else {
            self.compare(window, is_last, follower)
        }
    }

    fn begin(&self, window: &mut Window) {
        window.begin(self.sigma_m, self.correlation, self.config.shape_m());
    }

    /// Ends the reference when it is known well enough, or as well as this motion tells it.
    fn learn(&mut self, window: &mut Window, is_last: bool) -> bool {
        if self.windows < FIRST_WINDOWS {
            if window.taken() >= FIRST_PAIRS {
                self.note(window);
                self.begin(window);
            }
            return false;
        }
        let told = window.told(&[0.0; OWN_COLUMNS]);
        let seen = self.determined(&told, window.variance() * REFERENCE_WINDOWS);
        if seen != u16::MAX && !is_last {
            return false;
        }
        let variance = window.variance();
        self.seen = self.determined(&told, variance);
        let is_as_calibrated = self.is_as_calibrated(&told, variance, self.seen);
        let separated = self.separated(window, variance);
        self.note(window);
        if is_as_calibrated {
            self.reference_m = window.solve(self.config.residual_m);
            self.known = self.seen;
            self.tells_apart = self.seen & separated == u16::MAX;
            self.apart = self.seen & if self.again { u16::MAX } else { separated };
        } else {
            (self.known, self.apart) = (u16::MAX, u16::MAX);
            self.tells_apart = false;
        }
        self.learning = false;
        self.zero_s = [self.now_s; PLACES];
        self.reference_temperature_k = self.temperature_k;
        self.reference_sigma_m = self.sigma_m;
        self.begin(window);
        true
    }

    /// Whether none of these places differs from the calibration by more than it, and what a window does not know, explain. What differs more
    /// is no reference, and is told by the windows that follow. A place that the motion does not show is none: its amounts are those of the
    /// reading's own noise, which its phase has too.
    fn is_as_calibrated(&self, told: &[Windowed; PLACES], variance: f32, seen: u16) -> bool {
        let (bounds, uncertainty_m) = (self.config.bounds(), self.config.uncertainty_m);
        let places = Place::all().zip(told);
        let mut shown = places.filter(|(place, _)| seen & place.bit() != 0);
        shown.all(|(_, told)| {
            told.estimate().is_none_or(|([a, b], least)| {
                let deviation_m = sqrt(variance / least + uncertainty_m * uncertainty_m);
                sqrt(a * a + b * b) < bounds.left_alone_m + self.config.apart * deviation_m
            })
        })
    }

    /// Ends a window when what it has seen is known well enough, or as well as this motion tells it.
    fn compare(
        &mut self,
        window: &mut Window,
        is_last: bool,
        follower: &mut impl Follower,
    ) -> bool {
        let (told, variance) = (window.told(&self.reference_m), window.variance());
        if variance > JUMP * self.sigma_m * self.sigma_m && !is_last {
            // Something has changed within it: what follows is a window of its own, and the measure of the next.
            self.sigma_m = sqrt(variance);
            self.begin(window);
            return false;
        }
        let seen = self.determined(&told, variance);
        if seen != u16::MAX && !is_last {
            return false;
        }
        let separated = self.separated(window, variance / REFERENCE_WINDOWS);
        let new = seen & (!self.known | separated & !self.apart);
        if new != 0 && self.known & !seen == 0 && !self.has_told {
            // This motion shows all that the reference knows and more: another is learned, from the start.
            self.begin_anew(window);
            follower.forget();
            window.forget_cells();
            return true;
        }
        // What the reference does not tell apart is judged by motion alone that does not either.
        let judged = seen & self.known & (self.apart | !turns_apart(window, &told));
        self.seen = judged;
        let (bounds, now_s) = (self.config.bounds(), self.now_s);
        let tests = self.scores.iter_mut().zip(&mut self.zero_s);
        for ((place, told), (scores, zero_s)) in Place::all().zip(&told).zip(tests) {
            let Some((amounts_m, least)) = told.estimate() else {
                continue;
            };
            if judged & !new & place.bit() == 0 {
                continue;
            }
            scores.add(amounts_m, variance / least, bounds);
            if *scores == Scores::ZERO {
                *zero_s = now_s;
            }
        }
        if self.scores.iter().all(|scores| *scores == Scores::ZERO) {
            // No sign of any change: what is summed begins with the next.
            window.forget_sums();
            self.agreed |= judged == u16::MAX;
        } else {
            window.sum(KEPT, &told, variance);
        }
        let is_measure = self.is_measure();
        let compares = self.known == u16::MAX && new == 0;
        if is_measure && compares || !is_measure && self.has_told {
            let whole = Whole {
                rows: window,
                reference_m: &self.reference_m,
                variance,
                // A change that is told before there is a measure is compared with the calibration alone.
                reference_variance: if is_measure {
                    self.reference_sigma_m * self.reference_sigma_m
                } else {
                    f32::INFINITY
                },
            };
            if follower.window(&whole) {
                window.forget_cells();
            }
        }
        self.note(window);
        self.tell(Present::of(window.sums()));
        self.begin(window);
        true
    }

    /// Forgets the reference, and what windows have found.
    fn begin_anew(&mut self, window: &mut Window) {
        let now_s = self.now_s;
        self.start(self.config);
        (self.again, self.now_s) = (true, now_s);
        window.forget();
        self.begin(window);
    }

    /// Places whose amounts are known well enough.
    fn determined(&self, told: &[Windowed; PLACES], variance: f32) -> u16 {
        let precision_m = self.config.precision_m();
        let wanted = variance / (precision_m * precision_m);
        let known = |told: &Windowed| told.estimate().is_some_and(|(_, least)| least >= wanted);
        let places = Place::all().zip(told).filter(|(_, told)| known(told));
        places.fold(0, |seen, (place, _)| seen | place.bit())
    }

    /// Places whose amounts are known beside those of the other segment to what is left alone.
    fn separated(&self, window: &Window, variance: f32) -> u16 {
        let left_alone_m = self.config.bounds().left_alone_m;
        let wanted = variance / (left_alone_m * left_alone_m);
        let least = window.separated();
        let places = Place::all()
            .zip(least)
            .filter(|(_, least)| *least >= wanted);
        places.fold(0, |set, (place, _)| set | place.bit())
    }

    /// What the next window begins with.
    fn note(&mut self, window: &mut Window) {
        window.keep_amounts();
        self.stalled = false;
        self.windows = self.windows.saturating_add(1);
        self.sigma_m = sqrt(window.variance());
        self.correlation = window.correlation();
    }

    fn tell(&mut self, now: Present) {
        let evidence = self.evidence();
        if !self.has_told && evidence >= 1.0 {
            self.has_told = true;
            self.told = Told {
                at_s: self.now_s,
                windows: self.windows,
                warmer_k: self.temperature_k - self.reference_temperature_k,
                now,
                base: None,
            };
        } else if evidence < TAKEN_BACK {
            self.has_told = false;
        } else {
            self.told.now = now;
            if self.windows == self.told.windows + SETTLED {
                self.told.base = Some((self.now_s, now.size_m));
            }
        }
    }
}

/// Places of which this motion tells the segment from the other of its pair, be it a little.
fn turns_apart(window: &Window, told: &[Windowed; PLACES]) -> u16 {
    let least = told
        .iter()
        .map(|told| told.estimate().map_or(0.0, |(_, least)| least));
    let places = Place::all().zip(window.separated()).zip(least);
    let apart = places.filter(|((_, left), least)| *left > AS_ONE * least);
    apart.fold(0, |set, ((place, _), _)| set | place.bit())
}
