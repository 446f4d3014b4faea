//! The paper's equations (3) to (7) and (9) to (11): signs, orders, errors, constraints and their derivatives, once for every estimator.
//!
//! Generic over the number: the board fits in `f32`, the host in `f64`. Lengths are metres or any other unit, the same one
//! throughout; angles are radians. Segments 1 and 3 (indices 0 and 2) measure x, segments 2 and 4 measure y. The plant's side of a
//! simulation must not use this: its counts come from the true pose.

use crate::frame::SEGMENTS;
use core::ops::{Add, Div, Mul, Neg, Sub};

/// Orders of the own tooth phase, by definition of equation (3).
pub const OWN_ORDERS: [u8; 4] = [1, 2, 4, 6];
/// Coefficients of a segment in equation (3): k_i,0, then those of sine and cosine of each order.
pub const OWN_COEFFICIENTS: usize = 1 + 2 * OWN_ORDERS.len();
/// Sign of each segment in the parity, by definition of equation (5).
pub const PARITY_SIGN: [f32; SEGMENTS] = [1.0, -1.0, -1.0, 1.0];
/// Sign of each segment in the angle, by definition of equation (4).
pub const ANGLE_SIGN: [f32; SEGMENTS] = [1.0, 1.0, -1.0, -1.0];
/// Sign of l_o theta in each segment's lateral argument, and which side of the courier's middle the segment is on, across its own
/// direction: by definition of equation (9).
pub const LATERAL_SIGN: [f32; SEGMENTS] = [-1.0, 1.0, 1.0, -1.0];

/// What an estimator computes in.
pub trait Number:
    Copy
    + From<f32>
    + Add<Output = Self>
    + Sub<Output = Self>
    + Mul<Output = Self>
    + Div<Output = Self>
    + Neg<Output = Self>
{
}

impl Number for f32 {}
impl Number for f64 {}

/// Sine, cosine and one minus the cosine of the courier's angle: no two large numbers cancel in equation (11).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Angle<T> {
    /// sin(theta).
    pub sine: T,
    /// cos(theta).
    pub cosine: T,
    /// 1 - cos(theta).
    pub cosine_rest: T,
}

impl Angle<f64> {
    /// Of an angle in radians.
    #[must_use]
    pub fn of_rad(theta_rad: f64) -> Self {
        let (sine, cosine) = libm::sincos(theta_rad);
        let half = libm::sin(0.5 * theta_rad);
        Self {
            sine,
            cosine,
            cosine_rest: 2.0 * half * half,
        }
    }
}

impl<T: Number> Angle<T> {
    /// A vector of the courier's frame as the platen's frame has it: turned by the angle.
    #[inline(always)]
    pub fn turn(&self, [x, y]: [T; 2]) -> [T; 2] {
        [
            self.cosine * x - self.sine * y,
            self.sine * x + self.cosine * y,
        ]
    }

    /// Derivatives of g_x and g_y by the lever arms l_x and l_y, equation (11), the beacon's place at angle zero being kept.
    #[inline(always)]
    pub fn by_lever(&self) -> [[T; 2]; 2] {
        [
            [-self.cosine_rest, self.sine],
            [-self.sine, -self.cosine_rest],
        ]
    }
}

/// The functions of equation (3): sine and cosine of each of [`OWN_ORDERS`] times a phase f p, of which `[sine, cosine]` is given.
#[inline(always)]
pub fn own_functions<T: Number>(phase: [T; 2]) -> [[T; 2]; OWN_ORDERS.len()] {
    let plus =
        |[s, c]: [T; 2], [sine, cosine]: [T; 2]| [s * cosine + c * sine, c * cosine - s * sine];
    let two = plus(phase, phase);
    let four = plus(two, two);
    [phase, two, four, plus(four, two)]
}

/// The error e of equation (3), by a segment's k_i,0 to k_i,8 and the [`own_functions`] of its phase.
#[inline(always)]
pub fn own_error<T: Number>(
    k: &[T; OWN_COEFFICIENTS],
    functions: &[[T; 2]; OWN_ORDERS.len()],
) -> T {
    let mut error = k[0];
    for (n, [sine, cosine]) in functions.iter().enumerate() {
        error = error + k[1 + 2 * n] * *sine + k[2 + 2 * n] * *cosine;
    }
    error
}

/// The derivative of equation (3) by the phase f p: times f it is that by the unmodified output p.
#[inline(always)]
pub fn own_error_by_phase<T: Number>(
    k: &[T; OWN_COEFFICIENTS],
    functions: &[[T; 2]; OWN_ORDERS.len()],
) -> T {
    let mut slope = T::from(0.0);
    for (n, ([sine, cosine], order)) in functions.iter().zip(OWN_ORDERS).enumerate() {
        let turned = k[1 + 2 * n] * *cosine - k[2 + 2 * n] * *sine;
        slope = slope + T::from(f32::from(order)) * turned;
    }
    slope
}

/// The parity g_p of four calibrated outputs, equation (5).
#[inline(always)]
pub fn parity<T: Number>(p: &[T; SEGMENTS]) -> T {
    (p[0] - p[2]) - (p[1] - p[3])
}

/// The mean of both angles of equation (4), rad; `span` is the distance l_s between the segments of a pair.
#[inline(always)]
pub fn theta<T: Number>(p: &[T; SEGMENTS], span: T) -> T {
    ((p[0] - p[2]) + (p[1] - p[3])) / (T::from(2.0) * span)
}

/// The platen sensor's place `[x, y]`: the mean of each pair.
#[inline(always)]
pub fn middle<T: Number>(p: &[T; SEGMENTS]) -> [T; 2] {
    let half = T::from(0.5);
    [half * (p[0] + p[2]), half * (p[1] + p[3])]
}

/// Outputs of the segments where the platen sensor is at `middle` and turned by `theta`: equation (4) the other way round.
#[inline(always)]
pub fn outputs<T: Number>(middle: [T; 2], theta: T, span: T) -> [T; SEGMENTS] {
    let ([x, y], arm) = (middle, T::from(0.5) * span * theta);
    [x + arm, y + arm, x - arm, y - arm]
}

/// The argument of each segment's lateral term, equation (9): the place across, shifted by the angle times l_o (`lateral`).
#[inline(always)]
pub fn lateral_arguments<T: Number>(middle: [T; 2], theta: T, lateral: T) -> [T; SEGMENTS] {
    core::array::from_fn(|i| middle[1 - i % 2] + T::from(LATERAL_SIGN[i]) * lateral * theta)
}

/// Where each segment is over the platen, along its own direction and across it, by the outputs p and their [`lateral_arguments`].
#[inline(always)]
pub fn places<T: Number>(
    p: &[T; SEGMENTS],
    lateral_arguments: &[T; SEGMENTS],
    span: T,
) -> [[T; 2]; SEGMENTS] {
    let half = T::from(0.5) * span;
    core::array::from_fn(|i| [p[i], lateral_arguments[i] + T::from(LATERAL_SIGN[i]) * half])
}

/// Equations (10) and (11) at one pose.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Beacon<T> {
    /// g_x, g_y.
    pub g: [T; 2],
    /// Their derivatives by the angle.
    pub by_theta: [T; 2],
    /// The beacon's displacement (equation 10), turned from the sensor's frame into the platen's.
    pub turned: [T; 2],
}

/// Equation (11), with the beacon's place `b = o' + l` as it is seen at angle zero instead of o':
///
/// ```text
/// g_x = -p_x + cos(t) c_x - sin(t) c_y - l_y sin(t) - l_x (1 - cos(t)) + b_x
/// g_y = -p_y + sin(t) c_x + cos(t) c_y + l_x sin(t) - l_y (1 - cos(t)) + b_y
/// ```
///
/// `middle` is p, `displacement` c, `lever` l.
#[inline(always)]
pub fn beacon<T: Number>(
    middle: [T; 2],
    displacement: [T; 2],
    lever: [T; 2],
    place: [T; 2],
    angle: &Angle<T>,
) -> Beacon<T> {
    let [lx, ly] = lever;
    let Angle {
        sine,
        cosine,
        cosine_rest,
    } = *angle;
    let turned = angle.turn(displacement);
    Beacon {
        g: [
            turned[0] - middle[0] - ly * sine - lx * cosine_rest + place[0],
            turned[1] - middle[1] + lx * sine - ly * cosine_rest + place[1],
        ],
        by_theta: [
            -turned[1] - ly * cosine - lx * sine,
            turned[0] + lx * cosine - ly * sine,
        ],
        turned,
    }
}

/// Derivatives of g_p, g_x and g_y by the calibrated outputs, `[constraint][segment]`.
#[inline(always)]
pub fn by_outputs<T: Number>(by_theta: [T; 2], span: T) -> [[T; SEGMENTS]; 3] {
    let per_output = T::from(1.0) / (T::from(2.0) * span);
    let turn = |axis: usize| -> [T; SEGMENTS] {
        let scale = by_theta[axis] * per_output;
        core::array::from_fn(|i| {
            let own = if i % 2 == axis { 0.5 } else { 0.0 };
            T::from(ANGLE_SIGN[i]) * scale - T::from(own)
        })
    };
    [PARITY_SIGN.map(T::from), turn(0), turn(1)]
}

#[cfg(test)]
mod tests {
    use super::*;

    const SPAN: f64 = 9.7e-3;
    const LEVER: [f64; 2] = [0.09, -0.02];
    const PLACE: [f64; 2] = [0.031, 0.017];
    const DISPLACEMENT: [f64; 2] = [1.3e-3, -0.7e-3];

    fn constraints(p: &[f64; SEGMENTS]) -> [f64; 3] {
        let angle = Angle::of_rad(theta(p, SPAN));
        let seen = beacon(middle(p), DISPLACEMENT, LEVER, PLACE, &angle);
        [parity(p), seen.g[0], seen.g[1]]
    }

    /// Equation (11) as the paper has it, with o' = b - l.
    fn as_printed(p: &[f64; SEGMENTS]) -> [f64; 2] {
        let (s, c) = theta(p, SPAN).sin_cos();
        let ([x, y], [cx, cy], [lx, ly]) = (middle(p), DISPLACEMENT, LEVER);
        [
            -x + c * cx - s * cy - ly * s + lx * c + (PLACE[0] - lx),
            -y + s * cx + c * cy + ly * c + lx * s + (PLACE[1] - ly),
        ]
    }

    #[test]
    fn the_beacons_constraints_are_those_that_are_printed() {
        let p = [0.0312, 0.0171, 0.0309, 0.0168];
        let [_, x, y] = constraints(&p);
        for (ours, printed) in [x, y].into_iter().zip(as_printed(&p)) {
            assert!((ours - printed).abs() < 1e-16, "{ours} {printed}");
        }
    }

    /// Equation (3) and its derivative as the paper has them, term by term.
    #[test]
    fn the_error_is_that_which_is_printed() {
        let k = [0.3, 1.0, -2.0, 0.7, 0.4, -0.9, 0.2, 0.05, -0.6];
        for step in 0..50 {
            let phase = 0.13 * f64::from(step) - 3.0;
            let printed = k[0]
                + k[1] * phase.sin()
                + k[2] * phase.cos()
                + k[3] * (2.0 * phase).sin()
                + k[4] * (2.0 * phase).cos()
                + k[5] * (4.0 * phase).sin()
                + k[6] * (4.0 * phase).cos()
                + k[7] * (6.0 * phase).sin()
                + k[8] * (6.0 * phase).cos();
            let functions = |phase: f64| own_functions(phase.sin_cos().into());
            let error = own_error(&k, &functions(phase));
            assert!(
                (error - printed).abs() < 1e-13,
                "{phase}: {error} {printed}"
            );
            // The error of a central difference is the third derivative times its square: 2e-9 here.
            let at = |by: f64| own_error(&k, &functions(phase + by));
            let slope = (at(1e-5) - at(-1e-5)) / 2e-5;
            let found = own_error_by_phase(&k, &functions(phase));
            assert!((found - slope).abs() < 1e-7, "{phase}: {found} {slope}");
        }
    }

    #[test]
    fn derivatives_by_the_lever_are_those_of_the_constraints() {
        let p = [0.0312, 0.0171, 0.0309, 0.0168];
        let angle = Angle::of_rad(theta(&p, SPAN));
        let at = |lever| beacon(middle(&p), DISPLACEMENT, lever, PLACE, &angle).g;
        for (k, by) in angle.by_lever().into_iter().enumerate() {
            let mut longer = LEVER;
            longer[k] += 1.0;
            // Linear: a step of any length will do.
            for axis in 0..2 {
                let slope = at(longer)[axis] - at(LEVER)[axis];
                assert!((slope - by[axis]).abs() < 1e-15, "{k} {axis}");
            }
        }
    }

    #[test]
    fn derivatives_are_those_of_the_constraints() {
        let p = [0.0312, 0.0171, 0.0309, 0.0168];
        let angle = Angle::of_rad(theta(&p, SPAN));
        let seen = beacon(middle(&p), DISPLACEMENT, LEVER, PLACE, &angle);
        let by = by_outputs(seen.by_theta, SPAN);
        // The error of a central difference is the third derivative times its square: 1e-10 here.
        let step = 1.0e-7;
        for i in 0..SEGMENTS {
            let moved = |by: f64| {
                let mut p = p;
                p[i] += by;
                constraints(&p)
            };
            let (more, less) = (moved(step), moved(-step));
            for row in 0..3 {
                let slope = (more[row] - less[row]) / (2.0 * step);
                assert!(
                    (slope - by[row][i]).abs() < 1e-7,
                    "{row} {i}: {slope} {}",
                    by[row][i]
                );
            }
        }
    }

    /// A courier that turns by theta about its middle: each segment reads the place of its own side.
    #[test]
    fn a_turn_alone_has_no_parity_and_its_own_angle() {
        let turn = 0.01;
        let p = outputs([0.0; 2], turn, SPAN);
        assert_eq!(
            p,
            ANGLE_SIGN.map(|sign| f64::from(sign) * 0.5 * SPAN * turn)
        );
        assert!(parity(&p).abs() < 1e-18);
        assert!((theta(&p, SPAN) - turn).abs() < 1e-15);
        assert_eq!(middle(&p), [0.0, 0.0]);
        let shifted = lateral_arguments(middle(&p), turn, 3.0e-3);
        assert_eq!(shifted, [-3.0e-5, 3.0e-5, 3.0e-5, -3.0e-5]);
        // Segments 1 and 3 are half a span to either side along y, 2 and 4 along x.
        let across = places(&p, &lateral_arguments([2.0, 3.0], 0.0, 1.0), SPAN).map(|at| at[1]);
        let half = 0.5 * SPAN;
        assert_eq!(across, [3.0 - half, 2.0 + half, 3.0 + half, 2.0 - half]);
    }
}
