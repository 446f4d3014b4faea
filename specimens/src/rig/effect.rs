//! Effects: what they add to the segments and to the deflection, all shapes drawn.

use super::courier::{Courier, Truth};
use super::dice::{Dice, eval, hash, smooth};
use std::f64::consts::TAU;

/// An effect with everything drawn; the size multiplies it.
pub struct Effect {
    pub(super) name: String,
    pub(super) seed: u64,
    pub(super) c: Vec<f64>,
    pub(super) waves: Vec<Vec<(f64, f64, f64)>>,
    pub size: f64,
    pub(super) slip: (f64, usize, i32),
}

impl Effect {
    pub fn draw(name: &str, d: &mut Dice, size: f64) -> Self {
        Self {
            name: name.into(),
            seed: (d.unit() * 1e18) as u64,
            c: (0..160).map(|_| d.normal()).collect(),
            waves: (0..24).map(|_| smooth(d, 3)).collect(),
            size,
            slip: (
                d.range(0.2, 0.8),
                d.pick(4),
                if d.unit() < 0.7 { 1 } else { 2 } * d.sign() as i32,
            ),
        }
    }
    /// Displacement of the segments.
    pub(super) fn displace(&self, u: &Courier, q: &Truth, all: f64) -> [f64; 4] {
        let f = TAU / u.pitch;
        let own = u.own(q.pose);
        let across = u.across(q.pose);
        let vs = [
            q.v[0] + 0.5 * u.span * q.v[2],
            q.v[1] + 0.5 * u.span * q.v[2],
            q.v[0] - 0.5 * u.span * q.v[2],
            q.v[1] - 0.5 * u.span * q.v[2],
        ];
        let c = &self.c;
        let th = q.pose[2];
        let z = self.size;
        std::array::from_fn(|s| {
            let (p, a) = (f * own[s], f * across[s]);
            let b = &c[s * 24..];
            z * match self.name.as_str() {
                "lateral_dependence" => {
                    b[0] * a.sin()
                        + b[1] * a.cos()
                        + 0.4 * (b[2] * (2.0 * a).sin() + b[3] * (2.0 * a).cos())
                        + 0.1 * b[4] * (p + a).sin()
                }
                "one_lateral" => f64::from(u8::from(s == 1)) * b[0].signum() * a.sin(),
                "extra_harmonics" => {
                    let n = [3.0, 5.0, 8.0, 7.0][(self.seed % 4) as usize];
                    b[0] * (n * p).sin()
                        + b[1] * (n * p).cos()
                        + 0.5 * (b[2] * (3.0 * p).sin() + b[3] * (8.0 * p).cos())
                }
                "tooth_variation" => {
                    let teeth = 4;
                    let (x, y) = (
                        own[s] / u.pitch,
                        (across[s] + [-0.5, 0.5, 0.5, -0.5][s] * u.span) / u.pitch,
                    );
                    let (i, j) = (x.floor() as i64, y.floor() as i64);
                    let (fx, fy) = (x - i as f64, y - j as f64);
                    let mut sum = 0.0;
                    for di in 0..=teeth {
                        for dj in 0..=teeth {
                            let wx = if di == 0 {
                                1.0 - fx
                            } else if di == teeth {
                                fx
                            } else {
                                1.0
                            };
                            let wy = if dj == 0 {
                                1.0 - fy
                            } else if dj == teeth {
                                fy
                            } else {
                                1.0
                            };
                            sum += wx * wy * hash(self.seed ^ (s as u64 % 2), i + di, j + dj);
                        }
                    }
                    sum / teeth as f64
                }
                "angle_dependence" => {
                    let t = th / 8.7e-3;
                    t * (b[0] * p.sin()
                        + b[1] * p.cos()
                        + 0.6 * (b[2] * (2.0 * p).sin() + b[3] * (2.0 * p).cos()))
                        + 0.1 * t * t * b[4] * p.sin()
                }
                // A coil of some width, turned either way: each order loses what a sinc does.
                "wide_coil" => {
                    let lost = |n: f64| {
                        let u = n * th / 0.012;
                        1.0 - if u == 0.0 { 1.0 } else { u.sin() / u }
                    };
                    lost(1.0) * (b[0] * p.sin() + b[1] * p.cos())
                        + lost(2.0) * (b[2] * (2.0 * p).sin() + b[3] * (2.0 * p).cos())
                }
                "thermal_drift" => (q.temp - 25.0) * (b[0] + 0.3 * c[100 + s % 2] * own[s] * 1e2),
                "bent_warmth" => {
                    let dt = q.temp - 25.0;
                    b[0] * dt * (1.0 + 0.08 * b[1].signum() * dt)
                }
                "late_warmth" => (q.mount - 25.0) * b[0],
                "velocity_lag" => {
                    let v = vs[s] / 0.03;
                    (1.0 + 0.5 * b[0]) * v / (1.0 + 0.15 * v.abs())
                }
                "hysteresis" => {
                    (0.8 + 0.5 * b[0])
                        * if vs[s].abs() > 1e-9 {
                            (vs[s] / 1e-3).tanh()
                        } else {
                            0.0
                        }
                }
                "gap_variation" => {
                    let g = self.gap(u, q, s);
                    g * (b[0] * p.sin()
                        + b[1] * p.cos()
                        + b[2] * (2.0 * p).sin()
                        + b[3] * (2.0 * p).cos())
                }
                "span_error" => [1.0, -0.6, -1.0, 0.6][s] * (1.0 + 0.2 * b[0]) * th * 100.0,
                "time_drift" => {
                    b[0] * (-(q.t / all) * 3.0).exp()
                        + b[1] * (q.t / all)
                        + 0.3 * b[2] * (7.0 * q.t / all).sin()
                }
                "line_pickup" => b[0] * (TAU * (7.0 + 20.0 * c[150].abs()) * q.t + b[1]).sin(),
                "platen_bow" => {
                    b[0] * (TAU * own[s] / 0.023 + b[1]).sin()
                        + b[2] * (TAU * across[s] / 0.017 + b[3]).cos()
                }
                "half_order" => b[0] * (0.5 * p + b[1]).sin() + b[2] * (1.5 * p + b[3]).sin(),
                "warm_harmonics" => (q.temp - 25.0) * (b[0] * p.sin() + b[1] * (2.0 * p).cos()),
                "speed_harmonics" => vs[s] / 0.02 * (b[0] * p.sin() + b[1] * (2.0 * p).cos()),
                "direction_harmonics" if vs[s].abs() > 1e-9 => {
                    vs[s].signum() * (b[0] * p.sin() + b[1] * (2.0 * p).cos())
                }
                "theta_bend" => {
                    (b[0] * 0.3 * (th * 90.0).sin() + b[1] * (th * 130.0).cos())
                        * [1.0, -1.0, -1.0, 1.0][s]
                }
                "speeds_together" => b[0] * q.v[0] * q.v[1],
                "warm_thirds" => (q.temp - 26.3) * b[0] * (3.0 * p + b[1]).sin(),
                "pair_product" => {
                    b[0] * (f * (own[(s + 2) % 4] + 3.0 * own[s]) + b[1]).sin()
                        + b[2] * (f * (2.0 * own[(s + 2) % 4] + own[s]) + b[3]).cos()
                }
                _ => 0.0,
            }
        })
    }
    /// Current of the drive, A, whose field `stray_field` is in every other courier; in the others a magnet's beside the platen.
    pub(super) fn current_a(&self, q: &Truth, all: f64) -> Option<f64> {
        (self.seed % 2 == 0).then(|| 0.4 + 0.8 * eval(&self.waves[20], 9.0 * q.t / all))
    }
    /// Field at a segment: of the drive by its current, else of a magnet some centimetres away.
    fn field(&self, u: &Courier, q: &Truth, s: usize, all: f64) -> f64 {
        self.current_a(q, all).unwrap_or_else(|| {
            let place = [u.own(q.pose)[s], u.across(q.pose)[s]];
            let magnet = [0, 1].map(|d| 0.09 + 0.02 * self.c[140 + d]);
            let [x, y] = if s % 2 == 0 { [0, 1] } else { [1, 0] };
            let away = [place[x] - magnet[0], place[y] - magnet[1]].map(|d| (d / 0.035).powi(2));
            3.0 / (1.0 + away[0] + away[1]).powf(1.5)
        })
    }
    /// What a stray field adds to a segment's sine and cosine, of the amplitude.
    pub(super) fn stray(&self, u: &Courier, q: &Truth, s: usize, all: f64) -> [f64; 2] {
        let turn = self.size * TAU / u.pitch * self.field(u, q, s, all);
        [0, 1].map(|channel| turn * self.c[24 * s + 8 + channel])
    }
    pub(super) fn gap(&self, u: &Courier, q: &Truth, s: usize) -> f64 {
        let w = u.own(q.pose);
        let a = u.across(q.pose);
        eval(&self.waves[s], w[s] / 0.06)
            + eval(&self.waves[4 + s], a[s] / 0.06)
            + 0.3 * self.c[130 + s] * q.pose[2] / 8.7e-3
    }
    /// Changes the deflection: returns what is added to tan psi, in metres at the beacon's height.
    pub(super) fn deflect(&self, u: &Courier, q: &Truth, t: [f64; 2], all: f64) -> [f64; 2] {
        let w = t.map(|v| v / u.fs);
        let c = &self.c;
        let z = self.size;
        match self.name.as_str() {
            "psd_nonlinearity" => {
                let poly = |o: usize| {
                    c[o] * w[0].powi(3)
                        + c[o + 1] * w[1].powi(3)
                        + 0.5 * c[o + 2] * w[0] * w[0] * w[1]
                        + 0.5 * c[o + 3] * w[0] * w[1]
                        + 0.3 * c[o + 4] * w[1] * w[1]
                        + 0.3 * c[o + 5] * w[0] * w[0]
                };
                [z * 10.0 * poly(0), z * 10.0 * poly(10)]
            }
            "psd_misalignment" => {
                let (r, g) = (c[0], c[1].signum() * (0.5 + c[1].abs()));
                [
                    z * 5.0 * (g * w[0] - r * w[1]),
                    z * 5.0 * (-g * w[1] + r * w[0]),
                ]
            }
            "beacon_vibration" => {
                let lines = 1 + (self.seed % 2) as usize;
                let mut d = [0.0; 2];
                for j in 0..lines {
                    let hz = 3.0 + 25.0 * (c[20 + j].abs() + j as f64);
                    d[0] += z * c[j] * (TAU * hz * q.t + c[30 + j]).sin();
                    d[1] += z * c[5 + j] * (TAU * hz * q.t + c[40 + j]).sin();
                }
                d
            }
            "psd_time_drift" => [
                z * 2.0 * eval(&self.waves[0], q.t / all),
                z * 2.0 * eval(&self.waves[1], q.t / all),
            ],
            "lamp_flicker" => {
                let wave = (TAU * (8.0 + 20.0 * c[150].abs()) * q.t + c[151]).sin();
                w.map(|w| z * (w + 0.2) * wave)
            }
            "psd_fringes" => [
                z * c[0] * (TAU * w[0] / 0.11 + c[1]).sin(),
                z * c[2] * (TAU * w[1] / 0.13 + c[3]).sin(),
            ],
            _ => [0.0; 2],
        }
    }
}
