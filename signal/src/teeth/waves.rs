//! A segment's waves, gathered so that the interrupt evaluates them and their derivatives without a loop over waves.
//!
//! `a sin(n phi + m lambda) + b cos(n phi + m lambda)` for m = 1 and m = -1 together is `sin(n phi) S + cos(n phi) C` with S and C
//! linear in sine and cosine of lambda.

use crate::frame::SEGMENTS;
use crate::model::Unit;
use core::f32::consts::TAU;
use serde::{Deserialize, Serialize};

/// A wave over own and lateral phase of every segment: `(0, 1)`, `(0, 2)`, `(1, ±1)` or `(2, ±1)`.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Wave {
    /// Order of the own phase, 0 to 2.
    pub own_order: u8,
    /// Order of the lateral phase: 1 or 2 without own phase, else ±1.
    pub lateral_order: i8,
    /// `[segment][sine, cosine]`, metres.
    pub coefficients_m: [[f32; 2]; SEGMENTS],
}

/// S = `s[1] cos + s[0] sin`, C likewise, of the lateral phase.
#[derive(Clone, Copy, Debug, Default)]
struct Mixed {
    s: [f32; 2],
    c: [f32; 2],
}

/// One segment's waves, pitches.
#[derive(Clone, Copy, Debug, Default)]
pub(super) struct SegmentWaves {
    /// Without own phase: sine and cosine of the lateral phase, and of twice that.
    lateral: [[f32; 2]; 2],
    /// Of own order 1 and 2, lateral order ±1.
    mixed: [Mixed; 2],
}

/// A segment's waves, pitches, and their derivatives by its own and its lateral place.
#[derive(Clone, Copy, Debug)]
pub(super) struct WaveSum {
    pub turns: f32,
    pub along: f32,
    pub across: f32,
}

impl WaveSum {
    pub(super) const NONE: Self = Self {
        turns: 0.0,
        along: 0.0,
        across: 0.0,
    };
}

impl Wave {
    /// Whether [`SegmentWaves`] has a place for its orders.
    pub(super) fn has_its_place(&self) -> bool {
        match self.own_order {
            0 => matches!(self.lateral_order, 1 | 2),
            1 | 2 => matches!(self.lateral_order, -1 | 1),
            _ => false,
        }
    }
}

impl SegmentWaves {
    pub(super) const NONE: Self = Self {
        lateral: [[0.0; 2]; 2],
        mixed: [Mixed {
            s: [0.0; 2],
            c: [0.0; 2],
        }; 2],
    };

    /// Gathers one segment's part of waves that have their places.
    #[inline] // built with the image, for size
    pub(super) fn new(waves: &[Wave], segment: usize, per_metre: f32) -> Self {
        let mut gathered = Self::NONE;
        for wave in waves {
            let [a, b] = wave.coefficients_m[segment % wave.coefficients_m.len()];
            let (a, b) = (a * per_metre, b * per_metre);
            if wave.own_order == 0 {
                let [sine, cosine] = &mut gathered.lateral[usize::from(wave.lateral_order == 2)];
                *sine += a;
                *cosine += b;
                continue;
            }
            // sin(n phi ± lambda) and cos(n phi ± lambda) by the theorems of addition.
            let sign = f32::from(wave.lateral_order);
            let mixed = &mut gathered.mixed[usize::from(wave.own_order == 2)];
            mixed.s[0] -= sign * b;
            mixed.s[1] += a;
            mixed.c[0] += sign * a;
            mixed.c[1] += b;
        }
        gathered
    }

    /// The waves at an own and a lateral phase. In the interrupt; some 60 operations.
    #[inline(always)]
    pub(super) fn sum(&self, [own, lateral]: [Unit; 2]) -> WaveSum {
        let value = |[a, b]: [f32; 2], unit: Unit| a * unit.sine + b * unit.cosine;
        let slope = |[a, b]: [f32; 2], unit: Unit| a * unit.cosine - b * unit.sine;
        let twice = lateral.doubled();
        let [first, second] = self.lateral;
        let second_slope = slope(second, twice);
        let mut turns = value(first, lateral) + value(second, twice);
        let mut across = slope(first, lateral) + (second_slope + second_slope);
        let part = |mixed: &Mixed, unit: Unit| {
            let (s, c) = (value(mixed.s, lateral), value(mixed.c, lateral));
            let slopes = [slope(mixed.s, lateral), slope(mixed.c, lateral)];
            (
                value([s, c], unit),
                slope([s, c], unit),
                value(slopes, unit),
            )
        };
        let one = part(&self.mixed[0], own);
        let two = part(&self.mixed[1], own.doubled());
        turns += one.0 + two.0;
        across += one.2 + two.2;
        WaveSum {
            turns,
            along: TAU * (one.1 + (two.1 + two.1)),
            across: TAU * across,
        }
    }
}
