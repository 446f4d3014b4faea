//! A second simulator, written apart from hal-sim and from the catalogue, to judge the diagnosis by.
//!
//! Geometry of equations (3), (4), (9) to (11); every shape is drawn anew. It shares no code with either side of the
//! effects. `UNLISTED` holds effects that no catalogue has.
#![allow(dead_code, clippy::needless_range_loop, missing_docs)]

use recording::{Coordination, Electronics, Geometry, Meta, Recording, Row, Samples};
use std::collections::HashMap;
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

pub const CATALOGUE: [&str; 19] = [
    "lateral_dependence",
    "extra_harmonics",
    "tooth_variation",
    "angle_dependence",
    "psd_nonlinearity",
    "psd_misalignment",
    "thermal_drift",
    "velocity_lag",
    "psd_latency",
    "hysteresis",
    "gap_variation",
    "beacon_vibration",
    "axis_skew",
    "cycle_slip",
    "outlier_bursts",
    "excess_noise",
    "adc_clipping",
    "quadrature_drift",
    "span_error",
];

pub const UNLISTED: [&str; 11] = [
    "time_drift",
    "line_pickup",
    "platen_bow",
    "half_order",
    "warm_harmonics",
    "speed_harmonics",
    "direction_harmonics",
    "psd_time_drift",
    "psd_fringes",
    "theta_bend",
    "pair_product",
];

/// One true sample.
#[derive(Clone, Copy, Default)]
struct Truth {
    t: f64,
    run: usize,
    pose: [f64; 3],
    v: [f64; 3],
    last_dir: [f64; 4],
    seen: bool,
    temp: f64,
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
    fn e(&self, s: usize, p: f64) -> (f64, f64) {
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
    fn raw(&self, s: usize, p: f64) -> f64 {
        let mut q = p;
        for _ in 0..30 {
            let (e, de) = self.e(s, q);
            q -= (q + e - p) / (1.0 + de);
        }
        q
    }
    fn own(&self, q: [f64; 3]) -> [f64; 4] {
        let r = 0.5 * self.span * q[2];
        [q[0] + r, q[1] + r, q[0] - r, q[1] - r]
    }
    fn across(&self, q: [f64; 3]) -> [f64; 4] {
        let r = self.lo * q[2];
        [q[1] - r, q[0] + r, q[1] + r, q[0] - r]
    }
}

fn smooth(d: &mut Dice, n: usize) -> Vec<(f64, f64, f64)> {
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
fn eval(w: &[(f64, f64, f64)], x: f64) -> f64 {
    w.iter().map(|(f, a, p)| a * (TAU * f * x + p).sin()).sum()
}
fn hash(d: u64, i: i64, j: i64) -> f64 {
    let mut dice = Dice(
        d ^ (i as u64).wrapping_mul(0x1234_5678_9ABC_DEF1)
            ^ (j as u64).wrapping_mul(0xFEDC_BA98_7654_3211),
    );
    dice.unit();
    dice.normal()
}

/// An effect with everything drawn; the size multiplies it.
pub struct Effect {
    name: String,
    seed: u64,
    c: Vec<f64>,
    waves: Vec<Vec<(f64, f64, f64)>>,
    pub size: f64,
    slip: (f64, usize, i32),
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
    fn displace(&self, u: &Courier, q: &Truth, all: f64) -> [f64; 4] {
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
                "thermal_drift" => (q.temp - 25.0) * (b[0] + 0.3 * c[100 + s % 2] * own[s] * 1e2),
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
                "pair_product" => {
                    b[0] * (f * (own[(s + 2) % 4] + 3.0 * own[s]) + b[1]).sin()
                        + b[2] * (f * (2.0 * own[(s + 2) % 4] + own[s]) + b[3]).cos()
                }
                _ => 0.0,
            }
        })
    }
    fn gap(&self, u: &Courier, q: &Truth, s: usize) -> f64 {
        let w = u.own(q.pose);
        let a = u.across(q.pose);
        eval(&self.waves[s], w[s] / 0.06)
            + eval(&self.waves[4 + s], a[s] / 0.06)
            + 0.3 * self.c[130 + s] * q.pose[2] / 8.7e-3
    }
    /// Changes the deflection: returns what is added to tan psi, in metres at the beacon's height.
    fn deflect(&self, u: &Courier, q: &Truth, t: [f64; 2], all: f64) -> [f64; 2] {
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
            "psd_fringes" => [
                z * c[0] * (TAU * w[0] / 0.11 + c[1]).sin(),
                z * c[2] * (TAU * w[1] / 0.13 + c[3]).sin(),
            ],
            _ => [0.0; 2],
        }
    }
}

#[allow(clippy::too_many_arguments)]
fn moving(
    from: [f64; 3],
    to: [f64; 3],
    n: usize,
    dt: f64,
    t0: f64,
    run: usize,
    seen: bool,
    out: &mut Vec<Truth>,
) {
    for i in 0..n {
        let s = i as f64 / (n - 1) as f64;
        // Trapezoid of speed: 10 % ramps.
        let r = 0.1;
        let peak = 1.0 / (1.0 - r);
        let (w, ws) = if s < r {
            (0.5 * peak * s * s / r, peak * s / r)
        } else if s > 1.0 - r {
            (
                1.0 - 0.5 * peak * (1.0 - s).powi(2) / r,
                peak * (1.0 - s) / r,
            )
        } else {
            (peak * (s - 0.5 * r), peak)
        };
        let rate = ws / ((n - 1) as f64 * dt);
        let mut q = Truth {
            t: t0 + i as f64 * dt,
            run,
            seen,
            ..Truth::default()
        };
        for a in 0..3 {
            q.pose[a] = from[a] + (to[a] - from[a]) * w;
            q.v[a] = (to[a] - from[a]) * rate;
        }
        out.push(q);
    }
}

pub struct Options {
    pub beacon: bool,
    pub counts: bool,
    pub samples: usize,
    pub commanded: bool,
    pub reference: bool,
    /// The first so many segments are recorded.
    pub segments: usize,
}
impl Default for Options {
    fn default() -> Self {
        Self {
            beacon: true,
            counts: true,
            samples: 12000,
            commanded: true,
            reference: false,
            segments: 4,
        }
    }
}

/// Places and rates by `usual`, which belongs to the courier; poses and temperature by `d`, which are a recording's own.
fn program(
    u: &Courier,
    usual: &mut Dice,
    d: &mut Dice,
    o: &Options,
    names: &mut Vec<String>,
) -> Vec<Truth> {
    let mut out: Vec<Truth> = Vec::new();
    let unit = o.samples as f64 / 12000.0;
    let n = |k: f64| ((k * unit) as usize).max(40);
    let base = [usual.range(0.05, 0.1), usual.range(0.05, 0.1)];
    let gap = usual.range(0.02, 0.2);
    let dt = usual.range(0.6e-3, 1.2e-3);
    let mut t = 0.0;
    let mut add =
        |name: &str, out: &mut Vec<Truth>, f: &mut dyn FnMut(f64, usize, &mut Vec<Truth>)| {
            names.push(name.into());
            f(t, names.len() - 1, out);
            t = out.last().map_or(0.0, |q| q.t) + 2.0;
        };
    let mut poses = Dice((d.unit() * 1e15) as u64);
    add("scatter", &mut out, &mut |t0, run, out| {
        for i in 0..n(3000.0) {
            let pose = [
                base[0] + 10.16e-3 * poses.unit(),
                base[1] + 10.16e-3 * poses.unit(),
                17.4e-3 * (poses.unit() - 0.5),
            ];
            out.push(Truth {
                t: t0 + gap * i as f64,
                run,
                pose,
                ..Truth::default()
            });
        }
    });
    let m = n(900.0);
    for (name, axis, back, rate) in [
        ("flyby_x", 0, false, 1.0),
        ("flyby_x_back", 0, true, 1.0),
        ("flyby_y", 1, false, 1.0),
        ("flyby_y_back", 1, true, 1.0),
        ("flyby_y_slow", 1, false, 0.2),
    ] {
        let mut a = [base[0] + 3e-3, base[1] + 3e-3, 1e-3];
        let mut b = a;
        a[axis] -= 0.015;
        b[axis] += 0.025;
        if back {
            std::mem::swap(&mut a, &mut b);
        }
        add(name, &mut out, &mut |t0, run, out| {
            moving(a, b, m, dt * 900.0 / m as f64 / rate, t0, run, false, out)
        });
    }
    let at = |u: &Courier, c: [f64; 2], th: f64| {
        let (s, k) = f64::sin_cos(th);
        let r = [c[0] + u.l[0], c[1] + u.l[1]];
        [
            u.o[0] + k * r[0] - s * r[1],
            u.o[1] + s * r[0] + k * r[1],
            th,
        ]
    };
    if o.beacon {
        add("beacon", &mut out, &mut |t0, run, out| {
            for i in 0..n(2500.0) {
                let c = [2.0e-3 * (poses.unit() - 0.5), 2.0e-3 * (poses.unit() - 0.5)];
                let pose = at(u, c, 52e-3 * (poses.unit() - 0.5));
                out.push(Truth {
                    t: t0 + gap * i as f64,
                    run,
                    pose,
                    seen: true,
                    ..Truth::default()
                });
            }
        });
        for (name, axis, back) in [
            ("beacon_x", 0, false),
            ("beacon_x_back", 0, true),
            ("beacon_y", 1, false),
            ("beacon_y_back", 1, true),
        ] {
            let (mut a, mut b) = ([0.0; 2], [0.0; 2]);
            a[axis] = -4e-3;
            b[axis] = 4e-3;
            if back {
                std::mem::swap(&mut a, &mut b);
            }
            add(name, &mut out, &mut |t0, run, out| {
                moving(
                    at(u, a, 0.0),
                    at(u, b, 0.0),
                    n(400.0),
                    1e-3,
                    t0,
                    run,
                    true,
                    out,
                )
            });
        }
        add("spin", &mut out, &mut |t0, run, out| {
            for i in 0..n(500.0) {
                let s = i as f64 / n(500.0) as f64;
                let th = 21e-3 * (TAU * s).sin();
                let w = 21e-3 * TAU * (TAU * s).cos() / (n(500.0) as f64 * 2e-3);
                let pose = at(u, [0.0; 2], th);
                let (sn, k) = f64::sin_cos(th);
                let v = [
                    w * (-sn * u.l[0] - k * u.l[1]),
                    w * (k * u.l[0] - sn * u.l[1]),
                    w,
                ];
                out.push(Truth {
                    t: t0 + 2e-3 * i as f64,
                    run,
                    pose,
                    v,
                    seen: true,
                    ..Truth::default()
                });
            }
        });
    }
    add("still", &mut out, &mut |t0, run, out| {
        let pose = if o.beacon {
            at(u, [0.5e-3, 0.3e-3], 1e-3)
        } else {
            [base[0], base[1], 0.0]
        };
        for i in 0..n(400.0) {
            out.push(Truth {
                t: t0 + 1e-3 * i as f64,
                run,
                pose,
                seen: o.beacon,
                ..Truth::default()
            });
        }
    });
    let all = out.last().map_or(1.0, |q| q.t);
    let warm = smooth(d, 3);
    for q in &mut out {
        q.temp = 25.0 + 2.0 * (1.0 - (-(q.t / all) * 2.0).exp()) + 0.7 * eval(&warm, q.t / all);
    }
    out
}

/// Makes a recording of the courier with the effects.
pub fn record(seed: u64, effects: &[(&str, f64)], o: &Options) -> (Recording, Courier) {
    record_as(seed, seed, effects, o)
}

/// What one recording has for itself: poses, temperature, noise.
fn own(motion: u64) -> Dice {
    Dice(motion.wrapping_mul(517) + 29)
}

/// The same courier and effects (`seed`), other poses and noise (`motion`).
pub fn record_as(
    seed: u64,
    motion: u64,
    effects: &[(&str, f64)],
    o: &Options,
) -> (Recording, Courier) {
    let mut d = Dice(seed.wrapping_mul(77) + 5);
    let u = Courier::draw(&mut d);
    let mut list: Vec<Effect> = effects
        .iter()
        .map(|(n, s)| Effect::draw(n, &mut d, *s))
        .collect();
    // An effect's size is the courier's: it is stated over the first recording's motion, whichever is made.
    let usual = || Dice(seed.wrapping_mul(991) + 3);
    let first = program(&u, &mut usual(), &mut own(seed), o, &mut Vec::new());
    let all = first.last().map_or(1.0, |q| q.t);
    for e in &mut list {
        scale(e, &u, &first, all);
    }
    let mut m = own(motion);
    let mut names = Vec::new();
    let truth = program(&u, &mut usual(), &mut m, o, &mut names);
    let samples = measure(&u, &list, &truth, &names, all, &mut m, o);
    let meta = Meta {
        device: "rig".into(),
        source: format!("independent rig, seed {seed}"),
        geometry: Geometry {
            pitch_m: u.pitch,
            span_m: Some(u.span),
            lateral_m: Some(u.lo),
        },
        coordination: o.beacon.then(|| Coordination {
            height_m: u.h * 1.03,
            lever_x_m: u.l[0] * 0.98,
            lever_y_m: u.l[1] * 1.04,
            tan_full_scale: u.fs,
        }),
        electronics: Electronics {
            adc_bits: Some(16),
            amplitude_counts: Some(u.amp),
            quadrature_noise_counts: Some(u.noise),
            psd_sum_counts: Some(u.sum),
            psd_noise_counts: Some(u.psd_noise),
            position_noise_m: if o.counts {
                None
            } else {
                Some(u.noise / u.amp * u.pitch / TAU)
            },
        },
    };
    (
        Recording {
            meta,
            samples,
            warnings: Vec::new(),
        },
        u,
    )
}

/// Makes the rms of what an effect adds, over the samples where it acts, what was asked for.
fn scale(e: &mut Effect, u: &Courier, truth: &[Truth], all: f64) {
    let asked = e.size;
    e.size = 1.0;
    let (mut sum, mut n) = (0.0, 0.0);
    for q in truth.iter().step_by(7) {
        let d = e.displace(u, q, all);
        let mean = d.iter().map(|v| v * v).sum::<f64>() / 4.0;
        let t = beacon(u, q, [0.0; 2]);
        let z = if q.seen {
            e.deflect(u, q, t, all)
        } else {
            [0.0; 2]
        };
        let both = mean + (z[0] * z[0] + z[1] * z[1]) / 2.0;
        if both > 0.0 {
            sum += both;
            n += 1.0;
        }
    }
    e.size = if n > 0.0 {
        asked / (sum / n).sqrt()
    } else {
        asked
    };
}

fn beacon(u: &Courier, q: &Truth, shift: [f64; 2]) -> [f64; 2] {
    let (s, k) = q.pose[2].sin_cos();
    let r = [q.pose[0] - u.o[0] - shift[0], q.pose[1] - u.o[1] - shift[1]];
    [
        (k * r[0] + s * r[1] - u.l[0]) / u.h,
        (-s * r[0] + k * r[1] - u.l[1]) / u.h,
    ]
}

fn measure(
    u: &Courier,
    list: &[Effect],
    truth: &[Truth],
    names: &[String],
    all: f64,
    d: &mut Dice,
    o: &Options,
) -> Samples {
    let f = TAU / u.pitch;
    let mut out = Samples::default();
    let find = |n: &str| list.iter().find(|e| e.name == n);
    let mut burst: HashMap<usize, f64> = HashMap::new();
    if let Some(e) = find("outlier_bursts") {
        let starts = (truth.len() as f64 * 0.004) as usize;
        for _ in 0..starts {
            let at = d.pick(truth.len());
            for i in at..(at + 3 + d.pick(6)).min(truth.len()) {
                burst.insert(i, e.size * d.range(4.0, 14.0) * d.sign());
            }
        }
    }
    let burst_seg = d.pick(4);
    for (i, q0) in truth.iter().enumerate() {
        let q = *q0;
        let mut p = u.own(q.pose);
        if let Some(e) = find("axis_skew") {
            let s = e.size / 1.5e-3;
            let stretch = s * e.c[0].signum() * (0.4 + 0.5 * e.c[0].abs());
            let across = u.across(q.pose);
            for i in 0..4 {
                p[i] += if i % 2 == 0 {
                    stretch * p[i] + s * e.c[1] * across[i]
                } else {
                    -stretch * p[i]
                };
            }
        }
        for e in list {
            let add = e.displace(u, q0, all);
            for s in 0..4 {
                p[s] += add[s];
            }
        }
        let mut counts = [[0.0; 2]; 4];
        let mut teeth = [0i32; 4];
        for s in 0..4 {
            let mut raw = u.raw(s, p[s]);
            if let Some(b) = burst.get(&i)
                && s == burst_seg
            {
                raw += b * d.range(0.7, 1.3);
            }
            let mut amp = u.amp;
            if let Some(e) = find("gap_variation") {
                amp *= (0.05 * e.gap(u, q0, s)).exp();
            }
            let (mut sn, mut cs) = (f * raw).sin_cos();
            if let Some(e) = find("quadrature_drift") {
                let z = e.size * f * 1.4;
                let x = q.t / all;
                let (os, oc, g, ps) = (
                    eval(&e.waves[s], x),
                    eval(&e.waves[4 + s], x),
                    eval(&e.waves[8 + s], x),
                    eval(&e.waves[12 + s], x),
                );
                sn = (1.0 + z * g) * (f * raw + z * ps).sin() + z * os;
                cs += z * oc;
            }
            let noise = u.noise.hypot(find("excess_noise").map_or(0.0, |e| {
                if e.seed % 2 == 0 || s == (e.seed / 2 % 4) as usize {
                    e.size * f * amp
                } else {
                    0.0
                }
            }));
            let mut pair = [sn * amp + noise * d.normal(), cs * amp + noise * d.normal()];
            if let Some(e) = find("adc_clipping") {
                let level =
                    u.amp * (1.0 - (e.size / 4e-6).sqrt() * (0.12 + 0.03 * e.c[s].abs()).min(0.3));
                pair = pair.map(|v| v.clamp(-level, level));
            }
            counts[s] = pair.map(|v| v.round().clamp(-32768.0, 32767.0));
            teeth[s] = (raw / u.pitch).round() as i32;
            let seen = (counts[s][0].atan2(counts[s][1])) / TAU;
            teeth[s] = ((raw / u.pitch) - seen).round() as i32;
            if let Some(e) = find("cycle_slip")
                && s == e.slip.1
                && i as f64 > e.slip.0 * truth.len() as f64
            {
                teeth[s] += e.slip.2;
            }
        }
        let electrodes = (o.beacon).then(|| {
            if !q.seen {
                return [0.0; 4];
            }
            let mut at = *q0;
            if let Some(e) = find("psd_latency") {
                let tau = e.size / 1.1e-2;
                for a in 0..3 {
                    at.pose[a] += q0.v[a] * tau * e.c[0].signum();
                }
            }
            let mut t = beacon(u, &at, [0.0; 2]);
            for e in list {
                let z = e.deflect(u, q0, t, all);
                for a in 0..2 {
                    t[a] += z[a] / u.h;
                }
            }
            let mut out = [0.0; 4];
            for a in 0..2 {
                let w = t[a] / u.fs;
                out[2 * a] = (0.5 * u.sum * (1.0 + w) + u.psd_noise * d.normal()).round();
                out[2 * a + 1] = (0.5 * u.sum * (1.0 - w) + u.psd_noise * d.normal()).round();
            }
            out
        });
        let mut row = Row {
            t_s: q.t,
            run: &names[q.run],
            temperature_c: Some((q.temp * 100.0).round() / 100.0),
            electrode_counts: electrodes,
            ..Row::default()
        };
        for s in 0..o.segments {
            if o.counts {
                row.quadrature_counts[s] = Some(counts[s]);
                row.teeth[s] = Some(teeth[s]);
            } else {
                row.position_m[s] = Some(recording::unmodified_m(teeth[s], counts[s], u.pitch));
            }
        }
        if o.commanded {
            row.commanded = [
                Some(q0.pose[0] + 30e-6 * d.normal()),
                Some(q0.pose[1] + 30e-6 * d.normal()),
                Some(q0.pose[2] + 1e-3 * d.normal()),
            ];
        }
        if o.reference {
            row.reference = q0.pose.map(Some);
        }
        out.push(&row);
    }
    out
}
