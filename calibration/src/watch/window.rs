//! A window of the watch: readings of ordinary motion as one regression.
//!
//! Readings come in pairs, a part of a tooth apart, and a row is what the second says beside the first: displaced teeth, of which a segment
//! averages several, shift both alike, and so do temperature and whatever else is slow, while a wave within a tooth does not. How much of
//! the first is taken off the second follows from the correlation that pairs show (Cochrane and Orcutt 1949, J. Am. Stat. Assoc. 44, 32).
//!
//! What a pair tells depends on where it was taken, not on how often: the structure that a calibration leaves is the same each time the
//! courier comes by. So a pair counts only in a quarter of a tooth that the window has not seen, some milliseconds after the one before;
//! intervals and ways are random, so that no speed falls in step with the teeth (Shapiro and Silverman 1960, SIAM J. 8, 225).

use super::cells::Cells;
use super::lag::Lag;
use super::places::PLACES;
use super::row::{COLUMNS, FIRST_OWN, OWN_COLUMNS, Reading, SHAPE_COLUMNS, row};
use super::turning::Turning;
use super::windowed::Windowed;
use crate::frame::{Coordinate, SEGMENTS};
use crate::lsq::{Triangle, packed_len};
use crate::math::sqrt;

/// Words of the set of a window's cells. Derived from the longest window's pairs: four times as many cells, of which a quarter
/// are taken at the most.
const CELL_WORDS: usize = 512;
/// Words of the set of all cells. Derived from 90 mm by 90 mm, more than couriers work on for long: 131,072 cells of a quarter of
/// a tooth.
const ALL_CELL_WORDS: usize = 4096;
/// Between two pairs, milliseconds: at least, and a random rest below a power of two. Ten on average with the way between the
/// readings of a pair. Derived from the background's time: a row costs some 25,000 cycles, 1.5 % of it.
const GAP_MS: u64 = 4;
/// See [`GAP_MS`].
const RANDOM_GAP_MS: u32 = 8;
/// Way between the readings of a pair, teeth: at least, and a random rest. Derived from the waves: those of orders 1 to 6 differ
/// most over a half to a twelfth.
const WAY_TURNS: f32 = 0.08;
/// See [`WAY_TURNS`].
const RANDOM_WAY_TURNS: f32 = 0.42;
/// A second reading that comes later than this begins another pair, teeth. By definition: beyond a tooth it is at another one.
const LATE_TURNS: f32 = 1.0;
/// Cells in a row that are known, after which nothing new is expected. Derived from a quarter of a tooth each: a way of 5 m.
const EXHAUSTED: u32 = 20_000;
/// Fewest readings of a window. Derived from the unknowns: four for each, so that a quarter of the noise is taken for them.
pub(super) const SHORTEST: u32 = 4 * COLUMNS as u32;
/// Most of a window, and of the reference. A bound on the work: 41 s of motion at 10 ms, after which it counts as it is.
pub(super) const LONGEST: u32 = 4096;

/// The readings so far. To live in memory that is shared with the calibrations: a window that is lost is begun anew.
#[derive(Clone, Debug)]
pub struct Window {
    rows: Triangle<COLUMNS, { packed_len(COLUMNS) }>,
    cells: Cells<CELL_WORDS>,
    all_cells: Cells<ALL_CELL_WORDS>,
    taken: u32,
    /// Of them, in cells that none of the windows before had.
    fresh: u32,
    /// Last cell, and how often the courier has come to one that is known since the last pair.
    cell: [i32; 2],
    known: u32,
    next_ms: u64,
    dither: u32,
    correlation: f32,
    first: First,
    /// All columns' amounts by the window before, metres.
    amounts_m: [f32; COLUMNS],
    lag: Lag,
    turning: Turning,
    /// What windows have told so far, over their variance, fading.
    sums: [Windowed; PLACES],
}

/// The first reading of a pair.
#[derive(Clone, Copy, Debug)]
struct First {
    /// Whether there is one.
    waits: bool,
    unmodified: [Coordinate; SEGMENTS],
    parity_m: f32,
    /// Until the courier has moved so far, turns.
    way_turns: f32,
}

impl Default for Window {
    fn default() -> Self {
        Self::new()
    }
}

impl Window {
    /// All zeros; [`Window::begin`] comes before all else.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            rows: Triangle::new(0),
            cells: Cells::EMPTY,
            all_cells: Cells::EMPTY,
            taken: 0,
            fresh: 0,
            cell: [0; 2],
            known: 0,
            next_ms: 0,
            dither: 0,
            correlation: 0.0,
            first: First {
                waits: false,
                unmodified: [Coordinate {
                    teeth: 0,
                    fraction_turns: 0.0,
                }; SEGMENTS],
                parity_m: 0.0,
                way_turns: 0.0,
            },
            amounts_m: [0.0; COLUMNS],
            lag: Lag::ZERO,
            turning: Turning::ZERO,
            sums: [Windowed {
                matrix: [0.0; 3],
                vector: [0.0; 2],
            }; PLACES],
        }
    }

    /// Begins anew, for noise of about `sigma_m` after `correlation` is taken out, with a prior of `shape_m` on each amount of the
    /// shapes.
    pub fn begin(&mut self, sigma_m: f32, correlation: f32, shape_m: f32) {
        self.rows.reset(COLUMNS);
        self.cells.clear();
        (self.taken, self.fresh, self.known) = (0, 0, 0);
        self.correlation = correlation;
        self.first.waits = false;
        self.turning = Turning::ZERO;
        self.lag.begin();
        for column in 1..=SHAPE_COLUMNS {
            let mut row = [0.0; COLUMNS];
            row[column] = sigma_m / shape_m;
            // Finite, or it is left out: the shapes are then free.
            let _ = self.rows.enter(&row, 0.0);
        }
    }

    /// All zeros again: the next reading begins anew.
    pub fn forget(&mut self) {
        self.rows.reset(0);
        self.forget_sums();
    }

    /// Nothing has been told.
    pub(super) fn forget_sums(&mut self) {
        self.sums.fill(Windowed::default());
    }

    /// Whether there is a window at all.
    #[must_use]
    pub fn has_begun(&self) -> bool {
        self.rows.unknowns() == COLUMNS
    }

    /// Pairs taken.
    #[must_use]
    pub fn taken(&self) -> u32 {
        self.taken
    }

    /// Those of them that were taken in cells where none was before, since [`Window::forget_cells`].
    #[must_use]
    pub(super) fn fresh(&self) -> u32 {
        self.fresh
    }

    /// All cells are new again.
    pub fn forget_cells(&mut self) {
        self.all_cells.clear();
        self.fresh = 0;
    }

    /// How far the courier has turned: [`Whole::turning`](super::follow::Whole::turning).
    pub(super) fn turning(&self) -> f32 {
        self.turning.variance(self.taken)
    }

    /// Whether the courier has long been where the window knows all.
    #[must_use]
    pub fn is_exhausted(&self) -> bool {
        self.known >= EXHAUSTED
    }

    /// Whether a reading is due at a time, so that no other needs to be made.
    #[must_use]
    pub fn is_due(&self, time_ms: u64) -> bool {
        self.first.waits || time_ms >= self.next_ms
    }

    /// Takes a reading, if it is due; whether it has made a pair. Cost: one row of 73 unknowns for a pair, next to nothing otherwise.
    pub fn take(&mut self, reading: &Reading) -> bool {
        if !self.is_due(reading.time_ms) {
            return false;
        }
        let way_turns = self.way_turns(&reading.unmodified);
        if !self.first.waits || way_turns > LATE_TURNS {
            self.first.waits = false;
            let cell = reading.cell();
            if self.cells.is_new(cell) {
                self.begin_pair(reading);
            } else if cell != self.cell {
                self.known = self.known.saturating_add(1);
            }
            self.cell = cell;
            return false;
        }
        if way_turns < self.first.way_turns {
            return false;
        }
        self.enter_pair(reading);
        let gap_ms = self.random() % RANDOM_GAP_MS;
        self.next_ms = reading.time_ms + GAP_MS + u64::from(gap_ms);
        true
    }

    /// How far the courier has come since the first reading of the pair: the segment that has come furthest, turns.
    fn way_turns(&self, unmodified: &[Coordinate; SEGMENTS]) -> f32 {
        let ways = unmodified.iter().zip(self.first.unmodified);
        ways.fold(0.0, |most, (now, then)| {
            now.minus_turns(then).abs().max(most)
        })
    }

    fn begin_pair(&mut self, reading: &Reading) {
        let share = (self.random() >> 16) as f32 / 65_536.0;
        self.first = First {
            waits: true,
            unmodified: reading.unmodified,
            parity_m: reading.parity_m,
            way_turns: WAY_TURNS + RANDOM_WAY_TURNS * share,
        };
    }

    fn enter_pair(&mut self, reading: &Reading) {
        let First {
            unmodified,
            parity_m,
            ..
        } = self.first;
        self.first.waits = false;
        let (before, mut entries) = (row(&unmodified), row(&reading.unmodified));
        self.lag.note(
            parity_m - dot(&before, &self.amounts_m),
            reading.parity_m - dot(&entries, &self.amounts_m),
        );
        for (entry, before) in entries.iter_mut().zip(before) {
            *entry -= self.correlation * before;
        }
        // Finite: frames with other numbers are not handed in.
        let rhs = reading.parity_m - self.correlation * parity_m;
        let _ = self.rows.enter(&entries, rhs);
        self.turning.note(&reading.unmodified);
        self.taken += 1;
        self.fresh += u32::from(self.all_cells.is_new(self.cell));
        self.known = 0;
    }

    /// Variance of a row, m²; infinite while there are too few.
    #[must_use]
    pub fn variance(&self) -> f32 {
        let freedom = self.rows.effective_rows() - COLUMNS as f32;
        if freedom < 1.0 {
            return f32::INFINITY;
        }
        let norm = self.rows.residual_norm();
        norm * norm / freedom
    }

    /// Correlation of a pair, as this window showed it.
    #[must_use]
    pub fn correlation(&self) -> f32 {
        self.lag.correlation()
    }

    /// What it tells of every place against a reference, equation (3)'s amounts in metres. Cost: some thousand multiplications.
    #[must_use]
    pub fn told(&self, reference_m: &[f32; OWN_COLUMNS]) -> [Windowed; PLACES] {
        let mut all = [Windowed::default(); PLACES];
        for i in 0..OWN_COLUMNS {
            let row: [f32; OWN_COLUMNS] = self.own_row(i);
            let expected: f32 = row.iter().zip(reference_m).map(|(r, k)| r * k).sum();
            let rest = self.own_right_hand_side(i) - expected;
            for (told, [sine, cosine]) in all.iter_mut().zip(row.as_chunks::<2>().0) {
                let [a, b, d] = &mut told.matrix;
                *a += sine * sine;
                *b += sine * cosine;
                *d += cosine * cosine;
                told.vector[0] += sine * rest;
                told.vector[1] += cosine * rest;
            }
        }
        all
    }

    /// Keeps what the window has found of all columns, for the next one's correlation.
    pub(super) fn keep_amounts(&mut self) {
        let mut amounts = [0.0; COLUMNS];
        for i in (0..COLUMNS).rev() {
            let known: f32 = (i + 1..COLUMNS)
                .map(|j| self.rows.entry(i, j) * amounts[j])
                .sum();
            let amount = (self.rows.right_hand_side(i) - known) / self.rows.entry(i, i);
            amounts[i] = if amount.is_finite() { amount } else { 0.0 };
        }
        self.amounts_m = amounts;
    }

    /// For each place the information on its amounts, times the variance, where those of the other segment of its pair are not known either:
    /// what is left of it is told by the courier's turning.
    pub(super) fn separated(&self) -> [f32; PLACES] {
        let mut own = [Windowed::default(); PLACES];
        let mut cross = [[[0.0; 2]; 2]; PLACES / 2];
        for i in 0..OWN_COLUMNS {
            let row: [f32; OWN_COLUMNS] = self.own_row(i);
            let pairs = row.as_chunks::<2>().0;
            for (own, [sine, cosine]) in own.iter_mut().zip(pairs) {
                let [a, b, d] = &mut own.matrix;
                *a += sine * sine;
                *b += sine * cosine;
                *d += cosine * cosine;
            }
            let others = pairs.iter().skip(PLACES / 2);
            for ((cross, first), second) in cross.iter_mut().zip(pairs).zip(others) {
                for (line, f) in cross.iter_mut().zip(first) {
                    line.iter_mut().zip(second).for_each(|(c, s)| *c += f * s);
                }
            }
        }
        let mut least = [0.0; PLACES];
        let (firsts, seconds) = own.split_at(PLACES / 2);
        let (least_firsts, least_seconds) = least.split_at_mut(PLACES / 2);
        let pairs = firsts.iter().zip(seconds).zip(cross);
        let leasts = least_firsts.iter_mut().zip(least_seconds);
        for (((first, second), c), (of_first, of_second)) in pairs.zip(leasts) {
            let turned = [[c[0][0], c[1][0]], [c[0][1], c[1][1]]];
            *of_first = first.without(second, c);
            *of_second = second.without(first, turned);
        }
        least
    }

    /// Equation (3)'s amounts, metres, by all readings and a prior of `prior_m` on each. The window cannot be used any more.
    #[must_use]
    pub fn solve(&mut self, prior_m: f32) -> [f32; OWN_COLUMNS] {
        let sigma_m = sqrt(self.variance());
        for column in FIRST_OWN..COLUMNS {
            let mut row = [0.0; COLUMNS];
            row[column] = sigma_m / prior_m;
            let _ = self.rows.enter(&row, 0.0);
        }
        let mut amounts = [0.0; OWN_COLUMNS];
        for i in (0..OWN_COLUMNS).rev() {
            let row: [f32; OWN_COLUMNS] = self.own_row(i);
            let known: f32 = row.iter().zip(&amounts).map(|(r, k)| r * k).sum();
            let amount = (self.rows.right_hand_side(FIRST_OWN + i) - known) / row[i];
            amounts[i] = if amount.is_finite() { amount } else { 0.0 };
        }
        amounts
    }

    /// Adds what a window has told, of this variance, to what earlier ones have, which keep a share.
    pub(super) fn sum(&mut self, kept: f32, told: &[Windowed; PLACES], variance: f32) {
        for (sum, told) in self.sums.iter_mut().zip(told) {
            *sum = sum.plus(kept, *told, 1.0 / variance);
        }
    }

    /// What windows have told so far, over their variance, fading.
    pub(super) fn sums(&self) -> &[Windowed; PLACES] {
        &self.sums
    }

    /// Right-hand side of such a row, metres.
    pub(super) fn own_right_hand_side(&self, i: usize) -> f32 {
        self.rows.right_hand_side(FIRST_OWN + i)
    }

    /// Row of the factor, of equation (3)'s columns alone.
    pub(super) fn own_row(&self, i: usize) -> [f32; OWN_COLUMNS] {
        core::array::from_fn(|j| self.rows.entry(FIRST_OWN + i, FIRST_OWN + j))
    }

    /// Marsaglia's xorshift (2003, J. Stat. Softw. 8, 14).
    fn random(&mut self) -> u32 {
        let mut x = if self.dither == 0 { 1 } else { self.dither };
        x ^= x << 13;
        x ^= x >> 17;
        x ^= x << 5;
        self.dither = x;
        x >> 3
    }
}

fn dot(a: &[f32; COLUMNS], b: &[f32; COLUMNS]) -> f32 {
    a.iter().zip(b).map(|(a, b)| a * b).sum()
}
