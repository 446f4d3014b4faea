//! The last unknowns of a factor by themselves, whatever the first are: what stands below the first rows says just that.

use super::packed;
use super::triangle::Triangle;
use core::ops::Range;

impl<const N: usize, const P: usize> Triangle<N, P> {
    /// Forgets what the rows say of the first `count` unknowns and keeps what they say of the others: these rows' own unknowns of the
    /// motion can then be used for the next rows' own.
    pub fn release(&mut self, count: usize) {
        for row in 0..count.min(self.unknowns) {
            self.row_mut(row).fill(0.0);
        }
    }

    /// The least-squares solution in the unknowns of `block`, where those before it are free and those behind it are zero; zero outside it.
    /// Some `len`² operations.
    #[must_use]
    pub fn block_solution(&self, block: Range<usize>) -> [f32; N] {
        let mut values = [0.0; N];
        let end = block.end.min(self.unknowns);
        for i in (block.start..end).rev() {
            let row = self.row(i);
            let right = row[row.len() - 1];
            let (head, tail) = values[i..end].split_at_mut(1);
            head[0] = right - packed::dot(&row[1..=tail.len()], tail);
        }
        for (value, scale) in values.iter_mut().zip(&self.scale) {
            *value *= scale * self.rhs_unit;
        }
        values
    }

    /// Sum of squares that `values` leave of the rows, where the first `free` unknowns are as they fit best, in the right-hand side's unit.
    /// Zero without as many values as there are unknowns. Some `N`² operations.
    #[must_use]
    pub fn square_left(&self, free: usize, values: &[f32]) -> f32 {
        let mut scaled = [0.0; N];
        for ((scaled, value), scale) in scaled.iter_mut().zip(values).zip(&self.scale) {
            *scaled = if *scale == 0.0 { 0.0 } else { value / scale };
        }
        let mut left = self.residual_square;
        for i in free..self.unknowns {
            let row = self.row(i);
            let right = row[row.len() - 1];
            let (head, tail) = scaled[i..self.unknowns].split_at(1);
            let told = self.rhs_scale * (head[0] + packed::dot(&row[1..=tail.len()], tail));
            left += row[0] * (right - told) * (right - told);
        }
        left * self.rhs_unit * self.rhs_unit
    }

    /// Variance of unknown `index` of `block` for rows of unit noise, as [`Triangle::block_solution`] has it; infinite where nothing
    /// determines it. Some `len`² operations.
    #[must_use]
    pub fn block_variance(&self, block: Range<usize>, index: usize) -> f32 {
        let end = block.end.min(self.unknowns);
        let mut solved = [0.0; N];
        if index >= end || self.scale[index] == 0.0 {
            return f32::INFINITY;
        }
        solved[index] = self.scale[index];
        let mut variance = 0.0;
        for i in index..end {
            let row = self.row(i);
            let (head, tail) = solved[i..end].split_at_mut(1);
            if head[0] == 0.0 {
                continue;
            }
            if row[0] == 0.0 {
                return f32::INFINITY;
            }
            variance += head[0] * head[0] / row[0];
            packed::subtract(tail, head[0], &row[1..=tail.len()]);
        }
        variance
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::lsq::packed_len;

    /// Two stretches with a constant of their own each, and one slope: y = 2 x + 1, and y = 2 x - 5, with a third unknown that is left out.
    fn stretches() -> Triangle<3, { packed_len(3) }> {
        let mut triangle = Triangle::new(3);
        for (constant, bend) in [(1.0, 0.1), (-5.0, -0.1)] {
            triangle.release(1);
            for x in [-1.0_f32, 0.0, 1.0] {
                let right = 2.0 * x + constant + bend * (x * x - 2.0 / 3.0);
                triangle.enter(&[1.0, x, x * x * x], right).unwrap();
            }
        }
        triangle
    }

    #[test]
    fn stretches_have_a_constant_of_their_own_and_share_the_slope() {
        let triangle = stretches();
        let found = triangle.block_solution(1..2);
        assert!((found[1] - 2.0).abs() < 1.0e-6, "{found:?}");
        assert_eq!([found[0], found[2]], [0.0; 2]);
        // x' x = 2 in each.
        let variance = triangle.block_variance(1..2, 1);
        assert!((variance - 0.25).abs() < 1.0e-6, "{variance}");
        assert_eq!(triangle.block_variance(1..2, 2), f32::INFINITY);
    }

    #[test]
    fn what_values_leave_is_the_sum_of_squares_with_the_best_constants() {
        let triangle = stretches();
        // 0.1 (1/3, -2/3, 1/3) twice.
        let bends = 2.0 * 0.01 * 6.0 / 9.0;
        let exact = triangle.square_left(1, &[0.0, 2.0, 0.0]);
        assert!((exact - bends).abs() < 1.0e-6, "{exact}");
        // A slope that is wrong by one leaves 2 more in each, a cubic of one the same, since x^3 is x at these places.
        for values in [[0.0, 3.0, 0.0], [0.0, 2.0, 1.0]] {
            let left = triangle.square_left(1, &values);
            assert!((left - bends - 4.0).abs() < 1.0e-5, "{left}");
        }
    }
}
