//! Chance: a generator, smooth functions of chance, and values of chance by place.

use std::f64::consts::TAU;

/// SplitMix64: small, seeded, unlike the generator of the product.
pub struct Dice(pub u64);

impl Dice {
    pub fn unit(&mut self) -> f64 {
        self.0 = self.0.wrapping_add(0x9E37_79B9_7F4A_7C15);
        let mut z = self.0;
        z = (z ^ (z >> 30)).wrapping_mul(0xBF58_476D_1CE4_E5B9);
        z = (z ^ (z >> 27)).wrapping_mul(0x94D0_49BB_1331_11EB);
        ((z ^ (z >> 31)) >> 11) as f64 / (1u64 << 53) as f64
    }
    pub fn range(&mut self, low: f64, high: f64) -> f64 {
        low + (high - low) * self.unit()
    }
    pub fn normal(&mut self) -> f64 {
        (-2.0 * self.unit().max(1e-300).ln()).sqrt() * (TAU * self.unit()).cos()
    }
    pub fn sign(&mut self) -> f64 {
        if self.unit() < 0.5 { -1.0 } else { 1.0 }
    }
    pub fn pick(&mut self, n: usize) -> usize {
        (self.unit() * n as f64) as usize
    }
}

pub(super) fn smooth(d: &mut Dice, n: usize) -> Vec<(f64, f64, f64)> {
    (0..n)
        .map(|i| {
            (
                (i + 1) as f64 * d.range(0.6, 1.4),
                d.normal() / (1.0 + i as f64),
                d.range(0.0, TAU),
            )
        })
        .collect()
}
pub(super) fn eval(w: &[(f64, f64, f64)], x: f64) -> f64 {
    w.iter().map(|(f, a, p)| a * (TAU * f * x + p).sin()).sum()
}
pub(super) fn hash(d: u64, i: i64, j: i64) -> f64 {
    let mut dice = Dice(
        d ^ (i as u64).wrapping_mul(0x1234_5678_9ABC_DEF1)
            ^ (j as u64).wrapping_mul(0xFEDC_BA98_7654_3211),
    );
    dice.unit();
    dice.normal()
}
