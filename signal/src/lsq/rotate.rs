//! Rotating a row into the factor: square-root-free Givens rotations (Gentleman 1973), four rows of the factor a pass.
//!
//! The factor is `sqrt(D) U` with a unit diagonal in `U`: a row of it holds `d` and the rest of `U`'s row `u`. The entering
//! row is `sqrt(g) a`. With `part = g a_i^2` and `kept = d / (d + part)`, the rotation that takes `a_i` out is one of two, each
//! of two multiplications and two additions an entry, one division, and no root:
//!
//! ```text
//! kept >= 1/8:  a_j <- a_j - a_i u_j,    u_j <- u_j + g a_i / (d + part) a_j,  g <- g kept
//! otherwise:    a_j <- u_j - a_j / a_i,  u_j <- a_j / a_i + kept a_j,          g <- part kept
//! both:         d <- d + part
//! ```
//!
//! where the last `a_j` of a line is the new one. The second is the first with the parts of the two rows exchanged; each is
//! used where it neither loses digits nor range. In the long run all are of the first kind.
//!
//! On the target four of these go along the row together, so that each entry of it is loaded and stored once for four
//! (`arm/givens.rs`): another order of the same operations, so the same bits.

use super::packed::start;
use crate::math::sqrt;
use core::array::from_fn;
use core::mem::take;

/// A pivot whose square is below this would be lost in rounding beside its column, of which the norm is at least about one: it
/// counts as zero. A row's `d` is zero or at least this. Derived from f32's 24 bits: 1e-12 of a norm of one is far below its
/// rounding, 6e-8.
pub(super) const LEAST_PIVOT: f32 = 1.0e-24;

/// Rotations of the first kind keep at least this share of `d + part`. Derived from the rounding that one magnifies which keeps a
/// share `s`, by `1 / sqrt(s)`: by less than 3, which a pivot sees a few times, while it grows from nothing.
const LEAST_KEPT: f32 = 0.125;

/// Rotates the entering row into the factor from row `first` on; returns what is left of its right-hand side. One copy for triangles of
/// every size, built for speed with this package.
#[inline(never)]
pub(super) fn rotate(packed: &mut [f32], unknowns: usize, first: usize) -> f32 {
    let (entering, factor) = packed.split_at_mut(unknowns + 1);
    let mut front = Front {
        factor: &mut factor[start(unknowns, first) - entering.len()..],
        entries: &mut entering[first..],
        weight: 1.0,
    };
    while front.goes_on() {
        front.rotate_fours();
        (0..4).for_each(|_| front.rotate_one());
    }
    let weight = front.weight;
    entering[unknowns] * sqrt(weight)
}

/// How far the entering row has come.
struct Front<'a> {
    /// The factor's rows that are left.
    factor: &'a mut [f32],
    /// What is left of the entering row, its right-hand side last.
    entries: &'a mut [f32],
    /// Its `g`.
    weight: f32,
}

impl Front<'_> {
    /// Whether there is a row left, and something to enter.
    fn goes_on(&self) -> bool {
        self.entries.len() > 1 && self.weight > 0.0
    }

    /// Leaves rows behind.
    #[inline(always)]
    fn pass(&mut self, rows: usize) {
        let numbers = rows * self.entries.len() - rows * rows.saturating_sub(1) / 2;
        let (factor, entries) = (take(&mut self.factor), take(&mut self.entries));
        self.factor = factor.get_mut(numbers..).unwrap_or_default();
        self.entries = entries.get_mut(rows..).unwrap_or_default();
    }

    /// As many blocks of four rows as are of the first kind, where there is a faster way to them.
    fn rotate_fours(&mut self) {
        #[cfg(target_os = "none")]
        {
            let rows =
                crate::arm::givens::rotate_fours(self.factor, self.entries, &mut self.weight);
            self.pass(rows);
        }
    }

    /// One rotation of either kind.
    fn rotate_one(&mut self) {
        if !self.goes_on() {
            return;
        }
        let Some((&mut entry, entries)) = self.entries.split_first_mut() else {
            return;
        };
        let row = self.factor.get_mut(..=entries.len());
        let Some((pivot, row)) = row.and_then(<[f32]>::split_first_mut) else {
            return;
        };
        let weighted = self.weight * entry;
        let (part, old) = (weighted * entry, *pivot);
        let sum = old + part;
        let inverse = 1.0 / sum;
        let kept = old * inverse;
        if kept >= LEAST_KEPT {
            *pivot = sum;
            let gain = weighted * inverse;
            turn(row, entries, &First { entry, gain });
            self.weight *= kept;
        } else if part >= LEAST_PIVOT {
            *pivot = sum;
            let scale = 1.0 / entry;
            turn(row, entries, &Second { scale, kept });
            self.weight = part * kept;
        }
        self.pass(1);
    }
}

/// Applies a rotation to all columns, four in step so that no result is waited for.
#[inline(always)]
fn turn(row: &mut [f32], entries: &mut [f32], kind: &impl Kind) {
    let (rows, row_rest) = row.as_chunks_mut::<4>();
    let (chunks, rest) = entries.as_chunks_mut::<4>();
    for (u, a) in rows.iter_mut().zip(chunks) {
        (*u, *a) = kind.turned(*u, *a);
    }
    for (u, a) in row_rest.iter_mut().zip(rest) {
        ([*u], [*a]) = kind.turned([*u], [*a]);
    }
}

/// What a rotation makes of `u` and `a` in some columns.
trait Kind {
    fn turned<const W: usize>(&self, u: [f32; W], a: [f32; W]) -> ([f32; W], [f32; W]);
}

struct First {
    entry: f32,
    gain: f32,
}

impl Kind for First {
    #[inline(always)]
    fn turned<const W: usize>(&self, u: [f32; W], a: [f32; W]) -> ([f32; W], [f32; W]) {
        let taken = u.map(|u| self.entry * u);
        let left: [f32; W] = from_fn(|j| a[j] - taken[j]);
        let added = left.map(|a| self.gain * a);
        (from_fn(|j| u[j] + added[j]), left)
    }
}

struct Second {
    scale: f32,
    kept: f32,
}

impl Kind for Second {
    #[inline(always)]
    fn turned<const W: usize>(&self, u: [f32; W], a: [f32; W]) -> ([f32; W], [f32; W]) {
        let unit = a.map(|a| a * self.scale);
        let left: [f32; W] = from_fn(|j| u[j] - unit[j]);
        let added = left.map(|a| self.kept * a);
        (from_fn(|j| unit[j] + added[j]), left)
    }
}
