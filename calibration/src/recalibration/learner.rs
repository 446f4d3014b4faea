//! The estimator of what has changed since the calibration, which forgets, and the tests of what it makes.

use super::belief::{Belief, Rows, add, dot};
use super::candidate::Proposal;
use super::config::RecalibrationConfig;
use super::gain::{AS_CALIBRATED, axes, group, weighted};
use crate::equations::OWN_ORDERS;
use crate::math::sqrt;
use crate::watch::{AMOUNTS, Amounts, Follower, Place, REFERENCE_WINDOWS, Whole};

/// Windows in its memory. Derived from a reference's eight, whose error is not forgotten: four times as many add a quarter of its
/// variance.
const MEMORY_WINDOWS: f32 = 32.0;
/// Windows before there is a candidate. Derived from the degrees of freedom: of four windows their scatter has three.
const LEAST_WINDOWS: f32 = 4.0;
/// Sum of squares by which a window differs from those before that is no chance. Derived from as many amounts' chi-square, whose
/// deviation is 8: five deviations above its mean, one in a million.
const MOST_APART: f32 = AMOUNTS as f32 + 5.0 * 8.0;
/// Sum at which a candidate fits better. Derived from a chance of once in 10,000 hours of motion, in windows of 2 s: ln(10,000 *
/// 3,600 / 2) = 16.7.
const WANTED_EVIDENCE: f32 = 16.7;
/// It grows no further, so that what does not fit any more is not believed for long.
const MOST_EVIDENCE: f32 = 2.0 * WANTED_EVIDENCE;
/// Smallest share of a change that is worth a write to flash. A prior: what is left then shrinks by a quarter at least with each write.
const LEAST_STEP: f32 = 0.25;

/// Of four amounts that are known to a deviation each, `1 - 2 (deviation / size)^2` are expected to be nearest to the truth (James and Stein
/// 1961); their gain is half the size over the deviation.
const EXPECTED: f32 = 0.5;

/// By so much the courier must turn, square of the phases' difference between the segments of a pair, turns: half as far as the paper's
/// calibrations do, whose angles are uniform within ±0.5°, so 0.25° over the root of three times the span over the pitch, 9.55. Where it turns
/// less, what equation (3) does not hold of one segment's error passes for a change of both segments of the pair.
const LEAST_TURNING: f32 = 0.024 * 0.024;

/// What has been learned of a calibration's changes. To live in memory that is shared with the calibrations: 23 KiB.
#[derive(Clone, Debug)]
pub struct Learner {
    /// All windows, fading: of unit variance.
    rows: Rows,
    belief: Belief,
    /// What is to be taken off the corrections, zero where no gain is sure, metres.
    candidate_m: Amounts,
    evidence: f32,
    windows: u32,
    /// Pairs of readings, fading, and the same times their turning.
    pairs: f32,
    turning: f32,
    /// Sum over windows of what a row of the reference is worth beside theirs, fading.
    worth: f32,
    /// Pairs in new cells, of the last memory's windows and of those before them.
    fresh: [u32; 2],
    /// Windows of this memory so far.
    in_memory: u32,
    proposal: Proposal,
}

// The size that its documentation states: 22.8 KiB today.
const _: () = assert!(size_of::<Learner>() <= 23 * 1024);

impl Default for Learner {
    fn default() -> Self {
        Self::new()
    }
}

impl Learner {
    /// All zeros; [`Learner::start`] comes before all else.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            rows: Rows::new(0),
            belief: Belief::new(),
            candidate_m: [0.0; AMOUNTS],
            evidence: 0.0,
            windows: 0,
            pairs: 0.0,
            turning: 0.0,
            worth: 0.0,
            fresh: [0; 2],
            in_memory: 0,
            proposal: Proposal::NONE,
        }
    }

    /// Begins for a calibration; with none, learns nothing any more.
    #[inline(never)] // one copy in the images
    pub fn start(&mut self, config: Option<RecalibrationConfig>) {
        self.belief.start(config);
        self.forget();
    }

    /// Whether it was begun.
    #[must_use]
    pub fn has_begun(&self) -> bool {
        self.belief.has_begun()
    }

    /// What a calibration would change, believed or not; none while there is no candidate.
    #[must_use]
    pub fn proposal(&self) -> Option<Proposal> {
        (self.proposal.moves_m > 0.0).then_some(self.proposal)
    }

    /// The candidate has come in force: what follows is counted from it. By how much the calibration has been amended in all, metres rms.
    pub fn adopt(&mut self) -> f32 {
        self.belief.amend(&self.candidate_m);
        self.rows.shift(&self.candidate_m);
        self.candidate_m = [0.0; AMOUNTS];
        self.evidence = 0.0;
        self.proposal = Proposal::NONE;
        self.belief.amended_m()
    }

    /// What is to be taken off the corrections of equation (3): metres, zero where it stays.
    #[must_use]
    pub fn candidate_m(&self) -> &Amounts {
        &self.candidate_m
    }

    /// What is believed of the changes, metres, whether or not a gain is sure; zeros before the first complete windows.
    #[must_use]
    pub fn changes_m(&self) -> &Amounts {
        self.belief.changes_m()
    }

    /// Standard deviation of a functional of them.
    #[must_use]
    pub fn deviation(&self, functional: &Amounts) -> f32 {
        self.belief.deviation(functional)
    }

    /// Lets a window judge the candidate, which has not seen it.
    fn judge(&mut self, window: &Whole<'_>) {
        if self.proposal().is_none() {
            self.evidence = 0.0;
            return;
        }
        let (mut lowers, mut square) = (0.0, 0.0);
        for i in 0..AMOUNTS {
            let (row, rhs) = window.row(i);
            let fitted = dot(&row, &self.candidate_m);
            let rest = rhs - dot(&row, self.belief.left_m());
            lowers += fitted * (rest - 0.5 * fitted);
            square += fitted * fitted;
        }
        let grown = self.evidence + (0.5 * lowers - 0.125 * square) / self.scatter();
        #[allow(clippy::manual_clamp)] // not a number counts as nothing
        let bounded = grown.max(0.0).min(MOST_EVIDENCE);
        self.evidence = bounded;
    }

    fn enter(&mut self, window: &Whole<'_>) {
        let kept = 1.0 - 1.0 / MEMORY_WINDOWS;
        let most = MOST_APART * self.scatter();
        self.rows.forget(kept);
        self.pairs = kept * self.pairs + window.pairs() as f32;
        let turning = window.pairs() as f32 * window.turning();
        self.turning = kept * self.turning + turning;
        self.worth = kept * self.worth + window.reference_worth();
        self.windows = self.windows.saturating_add(1);
        if self.enter_rows(window) > most && self.windows > 1 {
            // Something has happened, or the courier is at other work: what was before says nothing of it.
            self.forget();
            (self.pairs, self.windows) = (window.pairs() as f32, 1);
            (self.turning, self.worth) = (turning, window.reference_worth());
            self.enter_rows(window);
        }
    }

    /// Enters a window's rows; by how much the window differs from those before, a sum of squares.
    fn enter_rows(&mut self, window: &Whole<'_>) -> f32 {
        let mut apart = 0.0;
        for i in 0..AMOUNTS {
            let (row, rhs) = window.row(i);
            // Finite: a window of which the variance is none is not complete.
            let rest = self.rows.enter(&row, rhs).unwrap_or(0.0);
            apart += rest * rest;
        }
        apart
    }

    /// Windows in memory, each counted by what is left of it.
    fn remembered(&self) -> f32 {
        self.rows.effective_rows() / AMOUNTS as f32
    }

    /// By how much the variance of windows among each other is larger than each tells: the square of the Birge ratio, one at least.
    fn scatter(&self) -> f32 {
        let freedom = self.rows.effective_rows() - AMOUNTS as f32;
        let norm = self.rows.residual_norm();
        let scatter = norm * norm / freedom;
        if freedom > AMOUNTS as f32 && scatter > 1.0 {
            scatter
        } else {
            1.0
        }
    }

    /// Windows' worth of new places in memory, one at least: only these tell of structure.
    fn places(&self) -> f32 {
        let (windows, fresh) = (self.remembered(), self.fresh.iter().max());
        let fresh = fresh.copied().unwrap_or(0) as f32;
        (fresh * windows / self.pairs).min(windows).max(1.0)
    }

    /// Makes a candidate of what is sure to be a gain.
    fn choose(&mut self, reference_m: &Amounts) {
        let (windows, scatter) = (self.remembered(), self.scatter());
        let now = sqrt(self.places() / (windows * scatter));
        let worth = self.worth / windows;
        let then = sqrt(REFERENCE_WINDOWS * worth / (windows * scatter));
        self.belief.solve(&self.rows, [now, then], reference_m);
        let (mut chosen, mut least) = ([0.0; AMOUNTS], f32::INFINITY);
        for axis in 0..2 {
            let along = self.along(axis);
            let gain = self.belief.gain(&along);
            let step = step(gain, self.belief.wanted_gain(&self.rows, now, &along));
            if step >= LEAST_STEP {
                add(&mut chosen, &along, step);
                least = least.min((2.0 - step) * gain);
            }
        }
        self.candidate_m = chosen;
        self.proposal = self.tell(least);
    }

    /// What is believed of the changes along one axis: of each order as much as is expected to help, by its own deviation.
    fn along(&self, axis: usize) -> Amounts {
        let mut along = [0.0; AMOUNTS];
        for order in 0..OWN_ORDERS.len() {
            let part = group(self.belief.changes_m(), axis, order);
            let gain = self.belief.gain(&part);
            let share = 1.0 - EXPECTED / (gain * gain);
            if share > 0.0 {
                add(&mut along, &part, share);
            }
        }
        along
    }

    fn tell(&self, gain: f32) -> Proposal {
        let weighted_m = weighted(&self.candidate_m, &AS_CALIBRATED);
        let [x, y] = axes(&self.candidate_m, &weighted_m);
        let moves_m = sqrt(x.max(y));
        let mut along = weighted_m;
        let is_x = x >= y;
        for (place, part) in Place::all().zip(along.as_chunks_mut::<2>().0) {
            if place.segment().is_multiple_of(2) != is_x {
                *part = [0.0; 2];
            }
        }
        let waves = self.candidate_m.as_chunks::<2>().0.iter();
        let sizes = waves.map(|[a, b]| sqrt(0.5 * (a * a + b * b)));
        let largest = Place::all().zip(sizes);
        let (place, size_m) = largest.fold((Place::default(), 0.0), |most, next| {
            if next.1 > most.1 { next } else { most }
        });
        Proposal {
            moves_m,
            deviation_m: self.belief.deviation(&along) / (8.0 * moves_m),
            gain,
            evidence: self.evidence / WANTED_EVIDENCE,
            segment: place.segment() as u8,
            order: place.order(),
            size_m,
            windows: self.windows,
        }
    }
}

impl Follower for Learner {
    fn window(&mut self, window: &Whole<'_>) -> bool {
        if !self.has_begun() {
            return false;
        }
        if (window.reference_worth() > 0.0) != (self.worth > 0.0) {
            // There is a reference now and was none, or the other way round: what was learned is of another kind.
            self.forget();
        }
        self.judge(window);
        self.enter(window);
        self.fresh[0] += window.fresh_pairs();
        self.in_memory += 1;
        let is_full = self.in_memory >= MEMORY_WINDOWS as u32;
        if self.remembered() >= LEAST_WINDOWS && self.turning >= LEAST_TURNING * self.pairs {
            self.choose(window.reference_m());
        } else {
            self.candidate_m = [0.0; AMOUNTS];
            self.proposal = Proposal::NONE;
        }
        if is_full {
            (self.fresh, self.in_memory) = ([0, self.fresh[0]], 0);
        }
        is_full
    }

    fn forget(&mut self) {
        self.rows.reset(AMOUNTS);
        self.candidate_m = [0.0; AMOUNTS];
        (self.evidence, self.windows) = (0.0, 0);
        (self.pairs, self.turning, self.worth) = (0.0, 0.0, 0.0);
        (self.fresh, self.in_memory) = ([0; 2], 0);
        self.proposal = Proposal::NONE;
    }
}

/// Share of a change that is to be made. A gain of so many deviations by all of it is, by a share `s` of it, one of `2 - s` times as
/// many: it takes less to be sure that a part of it helps.
fn step(gain: f32, wanted: f32) -> f32 {
    let step = 2.0 - wanted / gain;
    // Not a number is no step.
    if step < 1.0 { step } else { 1.0 }
}
