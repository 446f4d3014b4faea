//! From the true pose to what is recorded.

use super::courier::{Courier, Truth};
use super::dice::{Dice, eval};
use super::effect::Effect;
use super::motion::Options;
use recording::{Logged, Row, Samples};
use std::collections::HashMap;
use std::f64::consts::TAU;

pub(super) fn beacon(u: &Courier, q: &Truth, shift: [f64; 2]) -> [f64; 2] {
    let (s, k) = q.pose[2].sin_cos();
    let r = [q.pose[0] - u.o[0] - shift[0], q.pose[1] - u.o[1] - shift[1]];
    [
        (k * r[0] + s * r[1] - u.l[0]) / u.h,
        (-s * r[0] + k * r[1] - u.l[1]) / u.h,
    ]
}

pub(super) fn measure(
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
            if let Some(e) = find("stray_field") {
                let [os, oc] = e.stray(u, q0, s, all);
                sn += os;
                cs += oc;
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
    let current = find("stray_field").map(|e| truth.iter().filter_map(|q| e.current_a(q, all)));
    let values: Vec<f64> = current.into_iter().flatten().collect();
    if !values.is_empty() {
        out.log(Logged {
            name: "aux_drive_a".into(),
            values,
        });
    }
    out
}
