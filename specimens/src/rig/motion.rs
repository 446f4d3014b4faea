//! The usual runs.

use super::courier::{Courier, Truth};
use super::dice::{Dice, eval, smooth};
use std::f64::consts::TAU;

#[allow(clippy::too_many_arguments)]
pub(super) fn moving(
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
    /// So much is the recording's temperature above the usual one, K.
    pub warmer_k: f64,
    /// Time after which the mounts have followed the board to 1/e, s.
    pub mount_s: f64,
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
            warmer_k: 0.0,
            mount_s: 9.0,
        }
    }
}

/// Places and rates by `usual`, which belongs to the courier; poses and temperature by `d`, which are a recording's own.
pub(super) fn program(
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
