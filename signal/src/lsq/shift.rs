//! Counting the unknowns from another point.

use super::packed;
use super::triangle::Triangle;

impl<const N: usize, const P: usize> Triangle<N, P> {
    /// Counts the unknowns from `to` on: the rows are then as if each right-hand side had been less by `row * to`. Nothing happens if `to` has
    /// another length than there are unknowns. Cost: a substitution.
    pub fn shift(&mut self, to: &[f32]) {
        if to.len() != self.unknowns {
            return;
        }
        let mut scaled = [0.0; N];
        for ((scaled, to), scale) in scaled.iter_mut().zip(to).zip(&self.scale) {
            // An unknown of which no row speaks has no scale, and nothing to be shifted.
            *scaled = if *scale == 0.0 { 0.0 } else { to / scale };
        }
        let rhs_scale = self.rhs_scale;
        for i in 0..self.unknowns {
            let (head, tail) = scaled[i..self.unknowns].split_at(1);
            let row = self.row_mut(i);
            let told = head[0] + packed::dot(&row[1..=tail.len()], tail);
            if let (true, Some(rhs)) = (row[0] != 0.0, row.last_mut()) {
                *rhs -= rhs_scale * told;
            }
        }
    }
}
