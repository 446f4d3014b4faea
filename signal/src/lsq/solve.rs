//! From the triangle to a solution: rank, condition number, values, covariance.
//!
//! The columns are first brought to equal length. Inverse iteration then finds the smallest singular value; if it is
//! below the tolerance, its right vector is entered as one more row of a copy of the factor, asking for zero along it
//! (Chan 1987, "Rank revealing QR factorizations"; here with rows in place of permutations), until the smallest one left
//! is above it. What remains is of full rank and gives the solution of least norm: the pseudo-inverse's, truncated.
//! Memory: one more packed triangle. The normal equations are not formed.

use super::null::norm;
use super::spectrum::Of;
use super::triangle::Triangle;
use super::upper::Upper;
use crate::math::sqrt;

/// Smallest singular value, relative to the largest, that counts as determined, columns equally long. Derived from the rounding
/// of f32, which over some thousand rows reaches 1e-5 of the largest: a direction ten times as strong is told from it.
const RANK_TOLERANCE: f32 = 1.0e-4;
/// A parameter of which more than this share (square of its component) lies in undetermined directions is not given. Derived from
/// the root of it: a hundredth of the parameter would be the undetermined direction's.
const UNDETERMINED_SHARE: f32 = 1.0e-4;

/// Why there is no solution at all.
#[derive(Clone, Copy, Debug, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
#[non_exhaustive]
pub enum SolveError {
    /// No rows.
    Empty,
    /// Intermediate results left f32's range.
    Numeric,
}

impl core::fmt::Display for SolveError {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        match self {
            Self::Empty => write!(f, "no rows were entered: nothing to solve"),
            Self::Numeric => write!(f, "the solution is outside the range of f32"),
        }
    }
}

impl core::error::Error for SolveError {}

/// A least-squares solution and what is known about it.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Solution<const N: usize> {
    /// Values; where the rows do not determine them, the combination of least norm.
    pub values: [f32; N],
    /// Standard deviation per parameter, by the residual's own size ([`Self::noise`]); infinite where undetermined.
    pub deviations: [f32; N],
    /// Unknowns in use.
    pub unknowns: usize,
    /// Directions that the rows determine.
    pub rank: usize,
    /// Largest over smallest singular value of the rows as entered; infinite if the rank is short.
    pub condition: f32,
    /// The same with all columns brought to equal length, within the determined directions: free of units.
    pub condition_equilibrated: f32,
    /// Estimate of the rows' noise, `sqrt(residual / (rows - rank))`; infinite without redundancy.
    pub noise: f32,
    /// Rows entered.
    pub rows: u32,
}

impl<const N: usize> Solution<N> {
    // A function: a constant would lie in the image's flash.
    const fn none() -> Self {
        Self {
            values: [0.0; N],
            deviations: [f32::INFINITY; N],
            unknowns: 0,
            rank: 0,
            condition: f32::INFINITY,
            condition_equilibrated: f32::INFINITY,
            noise: f32::INFINITY,
            rows: 0,
        }
    }

    /// As [`Solution::none`], in its place: it need not go over the stack.
    fn clear(&mut self) {
        self.values.fill(0.0);
        self.deviations.fill(f32::INFINITY);
        (self.unknowns, self.rank, self.rows) = (0, 0, 0);
        self.condition = f32::INFINITY;
        self.condition_equilibrated = f32::INFINITY;
        self.noise = f32::INFINITY;
    }
}

/// Rows, workspace and solution: all memory of an estimate of up to `N` unknowns, to live in a static.
#[derive(Clone, Debug)]
pub struct Estimator<const N: usize, const P: usize> {
    /// Where rows go.
    pub rows: Triangle<N, P>,
    solved: Upper<N, P>,
    inverse_length: [f32; N],
    solution: Solution<N>,
}

impl<const N: usize, const P: usize> Default for Estimator<N, P> {
    fn default() -> Self {
        Self::new(N)
    }
}

impl<const N: usize, const P: usize> Estimator<N, P> {
    /// Empty, with `unknowns` in use.
    #[must_use]
    pub const fn new(unknowns: usize) -> Self {
        Self {
            rows: Triangle::new(unknowns),
            solved: Upper::new(unknowns),
            inverse_length: [0.0; N],
            solution: Solution::none(),
        }
    }

    /// All zeros, to be [`Estimator::reset`] before use: as a constant it is a clearing of memory, where [`Estimator::new`] would be
    /// made on the stack and copied.
    #[must_use]
    pub const fn blank() -> Self {
        Self {
            rows: Triangle::new(0),
            solved: Upper::new(0),
            inverse_length: [0.0; N],
            solution: Solution {
                values: [0.0; N],
                deviations: [0.0; N],
                unknowns: 0,
                rank: 0,
                condition: 0.0,
                condition_equilibrated: 0.0,
                noise: 0.0,
                rows: 0,
            },
        }
    }

    /// Empties it and sets the number of unknowns in use.
    pub fn reset(&mut self, unknowns: usize) {
        self.rows.reset(unknowns);
        self.solution.clear();
    }

    /// Last solution.
    #[must_use]
    pub fn solution(&self) -> &Solution<N> {
        &self.solution
    }

    /// Solves for all unknowns. Cost: some hundred substitutions of `N^2` steps, background only.
    ///
    /// # Errors
    /// [`SolveError`]; the last solution is then void. Deficient rank is no error: see [`Solution::rank`].
    pub fn solve(&mut self) -> Result<&Solution<N>, SolveError> {
        let as_entered = self.condition_as_entered();
        self.solve_equilibrated()?;
        if self.solution.rank == self.solution.unknowns {
            self.solution.condition = as_entered;
        }
        Ok(&self.solution)
    }

    /// As [`Self::solve`], in half the time: [`Solution::condition`] is left infinite.
    ///
    /// # Errors
    /// As [`Self::solve`].
    pub fn solve_equilibrated(&mut self) -> Result<&Solution<N>, SolveError> {
        self.solution.clear();
        if self.rows.rows() == 0 || self.rows.unknowns == 0 {
            return Err(SolveError::Empty);
        }
        let n = self.rows.unknowns;
        let mut undetermined = [0.0f32; N];
        self.equilibrate();
        let largest = self.largest_singular_value(Of::Itself);
        let (rank, smallest, left) = self.complete_rank(largest, &mut undetermined);
        let solution = &mut self.solution;
        solution.unknowns = n;
        solution.rank = rank;
        solution.rows = self.rows.rows();
        solution.condition_equilibrated = largest / smallest;
        let freedom = self.rows.effective_rows() - rank as f32;
        if freedom > 0.0 {
            solution.noise = self.rows.residual_norm_with(left) / sqrt(freedom);
        }
        self.back_substitute()?;
        for (i, share) in undetermined[..n].iter().enumerate() {
            self.solution.deviations[i] = if *share > UNDETERMINED_SHARE {
                f32::INFINITY
            } else {
                self.unit_deviation(i) * self.solution.noise
            };
        }
        Ok(&self.solution)
    }

    /// Standard deviation of `functional * x` for unit noise of the rows, after [`Self::solve`]; undetermined directions
    /// are taken as known to be zero.
    #[must_use]
    pub fn functional_deviation(&self, functional: &[f32]) -> f32 {
        let mut v = [0.0; N];
        for (i, (v, f)) in v
            .iter_mut()
            .zip(functional)
            .take(self.solved.unknowns)
            .enumerate()
        {
            *v = f * self.to_equal_length(i);
        }
        self.whiten(&mut v)
    }

    /// Covariance of parameters `i` and `j` for unit noise of the rows, after [`Self::solve`].
    #[must_use]
    pub fn covariance(&self, i: usize, j: usize) -> f32 {
        let n = self.solved.unknowns;
        if i >= n || j >= n {
            return 0.0;
        }
        let (mut a, mut b) = ([0.0; N], [0.0; N]);
        a[i] = self.to_equal_length(i);
        b[j] = self.to_equal_length(j);
        self.solved.factor().forward(&mut a);
        self.solved.factor().forward(&mut b);
        a[..n].iter().zip(&b[..n]).map(|(a, b)| a * b).sum()
    }

    fn unit_deviation(&self, i: usize) -> f32 {
        let mut v = [0.0; N];
        v[i] = self.to_equal_length(i);
        self.whiten(&mut v)
    }

    fn whiten(&self, v: &mut [f32; N]) -> f32 {
        self.solved.factor().forward(v);
        let length = norm(&v[..self.solved.unknowns]);
        if length.is_finite() {
            length
        } else {
            f32::INFINITY
        }
    }

    /// Parameter per unit of its equally long column.
    fn to_equal_length(&self, i: usize) -> f32 {
        self.rows.scale[i] * self.inverse_length[i]
    }

    /// Copies the factor with its columns brought to length one (a column of zeros stays).
    fn equilibrate(&mut self) {
        let n = self.rows.unknowns;
        self.inverse_length = [0.0; N];
        for i in 0..n {
            let row = self.rows.row(i);
            let root = sqrt(row[0]);
            let lengths = &mut self.inverse_length[i..n];
            lengths[0] = super::givens::hypot(lengths[0], root);
            for (length, u) in lengths[1..].iter_mut().zip(&row[1..]) {
                *length = super::givens::hypot(*length, root * u);
            }
        }
        for length in &mut self.inverse_length[..n] {
            *length = if *length > 0.0 { 1.0 / *length } else { 0.0 };
        }
        let lengths = self.inverse_length;
        self.copy_with_columns(&lengths);
    }

    fn copy_with_columns(&mut self, factors: &[f32; N]) {
        let n = self.rows.unknowns;
        self.solved.unknowns = n;
        for i in 0..n {
            let from = self.rows.row(i);
            let root = sqrt(from[0]);
            let to = self.solved.row_mut(i);
            to[0] = root * factors[i];
            to[n - i] = root * from[n - i];
            for ((to, u), factor) in to[1..n - i]
                .iter_mut()
                .zip(&from[1..])
                .zip(&factors[i + 1..])
            {
                *to = root * u * factor;
            }
        }
    }

    /// Condition number in the units of the rows as entered.
    fn condition_as_entered(&mut self) -> f32 {
        let n = self.rows.unknowns;
        let reference = self.rows.scale[..n].iter().fold(0.0f32, |a, b| a.max(*b));
        let mut factors = [0.0; N];
        for (factor, scale) in factors.iter_mut().zip(&self.rows.scale[..n]) {
            *factor = if *scale > 0.0 { reference / scale } else { 0.0 };
        }
        if factors.iter().any(|f| !f.is_finite()) {
            return f32::INFINITY;
        }
        self.copy_with_columns(&factors);
        self.largest_singular_value(Of::Itself) * self.largest_singular_value(Of::Inverse)
    }

    /// Of the factor as it was copied last. Largest of the inverse: the smallest's inverse.
    #[inline(never)]
    fn largest_singular_value(&self, of: Of) -> f32 {
        let mut work = [[0.0; N]; 3];
        let factor = self.solved.factor();
        let work = work.each_mut().map(|vector| &mut vector[..factor.unknowns]);
        factor.largest_singular_value(of, work)
    }

    /// Makes every direction below the tolerance zero; returns the rank, the smallest singular value left and the norm
    /// of what those directions had taken from the (scaled) residual.
    fn complete_rank(&mut self, largest: f32, undetermined: &mut [f32; N]) -> (usize, f32, f32) {
        let n = self.solved.unknowns;
        let (mut rank, mut left) = (n, 0.0);
        loop {
            let smallest = 1.0 / self.largest_singular_value(Of::Inverse);
            let bound = RANK_TOLERANCE * largest;
            if smallest > bound || rank == 0 {
                return (rank, smallest, left);
            }
            let mut direction = [0.0; N];
            let factor = self.solved.factor();
            factor.null_direction(bound, largest, &mut direction[..n]);
            rank -= 1;
            for (share, d) in undetermined.iter_mut().zip(&direction[..n]) {
                *share += d * d;
            }
            left = super::givens::hypot(left, self.solved.enter(&direction[..n], largest));
        }
    }

    fn back_substitute(&mut self) -> Result<(), SolveError> {
        let mut x = [0.0; N];
        self.solved.solve(&mut x);
        for (i, x) in x.iter().enumerate().take(self.rows.unknowns) {
            let value = x * self.inverse_length[i] * self.rows.rhs_unit * self.rows.scale[i];
            if !value.is_finite() {
                return Err(SolveError::Numeric);
            }
            self.solution.values[i] = value;
        }
        Ok(())
    }
}
