//! Rows of the calibration: functions of phases, as the session makes them, and values at the ends of f32.

use crate::UNKNOWNS;
use crate::inputs::Random;
use courier_sensor::math::sincos_turns;

/// One equation `row * x = rhs`.
#[derive(Clone, Copy, Debug)]
pub struct Row {
    /// Entries.
    pub entries: [f32; UNKNOWNS],
    /// Right-hand side.
    pub rhs: f32,
}

/// An endless sequence of equations.
#[derive(Clone, Debug)]
pub struct Rows {
    random: Random,
    extremes: bool,
}

impl Rows {
    /// From a seed; with `extremes`, one row in 64 holds values at the ends of f32 or none at all.
    pub const fn new(seed: u64, extremes: bool) -> Self {
        Self {
            random: Random::new(seed),
            extremes,
        }
    }

    /// The parity's row at random phases: orders 1, 2, 4, 6 of four segments, the signs + - - +, and the offset.
    pub fn row(&mut self) -> Row {
        let mut entries = [1.0; UNKNOWNS];
        for (segment, part) in entries[1..].chunks_exact_mut(8).enumerate() {
            let sign = if segment == 0 || segment == 3 {
                1.0
            } else {
                -1.0
            };
            let turns = self.random.signed();
            for (pair, order) in part.chunks_exact_mut(2).zip([1.0, 2.0, 4.0, 6.0]) {
                let (sine, cosine) = sincos_turns(order * turns);
                pair.copy_from_slice(&[sign * sine, sign * cosine]);
            }
        }
        let mut row = Row {
            entries,
            rhs: 30.0e-6 * self.random.signed(),
        };
        if self.extremes && self.random.bits().is_multiple_of(64) {
            self.spoil(&mut row);
        }
        row
    }

    fn spoil(&mut self, row: &mut Row) {
        let scale = self.random.pick(&[0.0, 1.0e-30, 1.0e30, 1.0e-38, 1.0e15]);
        row.entries.iter_mut().for_each(|x| *x *= scale);
        row.rhs *= self.random.pick(&[0.0, 1.0, 1.0e20, f32::NAN]);
    }
}
