//! The courier without effects, and a true sample of its motion.

use super::dice::Dice;
use std::f64::consts::TAU;

/// One true sample.
#[derive(Clone, Copy, Default)]
pub(super) struct Truth {
    pub(super) t: f64,
    pub(super) run: usize,
    pub(super) pose: [f64; 3],
    pub(super) v: [f64; 3],
    pub(super) last_dir: [f64; 4],
    pub(super) seen: bool,
    pub(super) temp: f64,
    /// Of the coils' mounts, which are warmed by the board.
    pub(super) mount: f64,
}

pub struct Courier {
    pub pitch: f64,
    pub span: f64,
    pub lo: f64,
    pub h: f64,
    pub l: [f64; 2],
    pub o: [f64; 2],
    pub fs: f64,
    pub k: [[f64; 9]; 4],
    pub amp: f64,
    pub noise: f64,
    pub sum: f64,
    pub psd_noise: f64,
}

impl Courier {
    pub fn draw(d: &mut Dice) -> Self {
        let mut k = [[0.0; 9]; 4];
        for s in 0..4 {
            k[s][0] = 2e-6 * d.normal();
            for j in 1..9 {
                k[s][j] = [0.0, 4e-6, 4e-6, 3e-6, 3e-6, 2e-6, 2e-6, 1e-6, 1e-6][j] * d.normal();
            }
        }
        Self {
            pitch: 1.016e-3,
            span: 9.7e-3,
            lo: d.range(1.5e-3, 4.5e-3),
            h: d.range(45e-3, 90e-3),
            l: [d.range(80e-3, 100e-3), d.range(-10e-3, 10e-3)],
            o: [d.range(-0.1, 0.1), d.range(-0.1, 0.1)],
            fs: d.range(0.08, 0.15),
            k,
            amp: d.range(16000.0, 26000.0),
            noise: d.range(4.0, 16.0),
            sum: d.range(18000.0, 30000.0),
            psd_noise: d.range(0.3, 2.0),
        }
    }
    pub(super) fn e(&self, s: usize, p: f64) -> (f64, f64) {
        let mut e = self.k[s][0];
        let mut de = 0.0;
        let f = TAU / self.pitch;
        for (j, n) in [1.0, 2.0, 4.0, 6.0].into_iter().enumerate() {
            let (a, b) = (self.k[s][1 + 2 * j], self.k[s][2 + 2 * j]);
            e += a * (n * f * p).sin() + b * (n * f * p).cos();
            de += n * f * (a * (n * f * p).cos() - b * (n * f * p).sin());
        }
        (e, de)
    }
    pub(super) fn raw(&self, s: usize, p: f64) -> f64 {
        let mut q = p;
        for _ in 0..30 {
            let (e, de) = self.e(s, q);
            q -= (q + e - p) / (1.0 + de);
        }
        q
    }
    pub(super) fn own(&self, q: [f64; 3]) -> [f64; 4] {
        let r = 0.5 * self.span * q[2];
        [q[0] + r, q[1] + r, q[0] - r, q[1] - r]
    }
    pub(super) fn across(&self, q: [f64; 3]) -> [f64; 4] {
        let r = self.lo * q[2];
        [q[1] - r, q[0] + r, q[1] + r, q[0] - r]
    }
}
