//! With libm's functions.

use super::{Coefficients, Outcome};
use core::f32::consts::TAU;
use courier_sensor::frame::RawFrame;

/// Equation (3) as it is written: sine and cosine of each order's angle.
#[inline(never)]
pub fn step(c: &Coefficients, raw: &RawFrame, out: &mut Outcome) {
    pipeline(c, raw, out, |k, phase, _, _| {
        let orders = [1.0, 2.0, 4.0, 6.0].into_iter().zip(k[1..].chunks_exact(2));
        k[0] + orders
            .map(|(n, k)| {
                let (sine, cosine) = libm::sincosf(n * phase);
                k[0] * sine + k[1] * cosine
            })
            .sum::<f32>()
    });
}

/// The kindest way: harmonics from products of the normalised counts, so that no sine is called.
#[inline(never)]
pub fn step_products(c: &Coefficients, raw: &RawFrame, out: &mut Outcome) {
    pipeline(c, raw, out, |k, _, s1, c1| {
        let (s2, c2) = (2.0 * s1 * c1, c1 * c1 - s1 * s1);
        let (s4, c4) = (2.0 * s2 * c2, c2 * c2 - s2 * s2);
        let (s6, c6) = (s4 * c2 + c4 * s2, c4 * c2 - s4 * s2);
        k[0] + k[1] * s1
            + k[2] * c1
            + k[3] * s2
            + k[4] * c2
            + k[5] * s4
            + k[6] * c4
            + k[7] * s6
            + k[8] * c6
    });
}

#[inline(always)]
fn pipeline(
    c: &Coefficients,
    raw: &RawFrame,
    out: &mut Outcome,
    error: impl Fn(&[f32; 9], f32, f32, f32) -> f32,
) {
    let mut p = [0.0; 4];
    out.status = 0;
    for i in 0..4 {
        let sine = f32::from(raw.quadrature_counts[i][0]) - c.offset[i][0];
        let cosine = f32::from(raw.quadrature_counts[i][1]) - c.offset[i][1];
        let amplitude = libm::sqrtf(sine * sine + cosine * cosine);
        let phase = libm::atan2f(sine, cosine);
        out.status |= u32::from(amplitude < c.amplitude[0] || amplitude > c.amplitude[1]) << i;
        let e = error(&c.k[i], phase, sine / amplitude, cosine / amplitude);
        p[i] = phase * (c.pitch_m / TAU) + e;
    }
    let (theta_x, theta_y) = ((p[0] - p[2]) / c.span_m, (p[1] - p[3]) / c.span_m);
    out.pose = [
        0.5 * (p[0] + p[2]),
        0.5 * (p[1] + p[3]),
        theta_x,
        theta_y,
        0.5 * (theta_x + theta_y),
    ];
    out.parity_m = p[0] - p[1] - p[2] + p[3];
    for (axis, electrodes) in raw.electrode_counts.as_chunks::<2>().0.iter().enumerate() {
        let [plus, minus] = electrodes.map(f32::from);
        out.tan_psi[axis] = if plus + minus > 1000.0 {
            c.full_scale * (plus - minus) / (plus + minus)
        } else {
            0.0
        };
    }
}
