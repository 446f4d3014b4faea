//! Coordination sensor: beacon and pose to deflection of the diode, equations (10) and (11) solved for `c`.

use effects::motion::Pose;
use effects::plant::Geometry;

/// Normalised deflection (1 is full scale) at a pose.
///
/// Equation (11) at zero residual is `p = R(theta) (c + l) + o'`, so `c = R(-theta) (p - o') - l`; equation (10) gives
/// `tan psi = c / h`. `origin_m` is `o'`.
#[must_use]
pub fn deflection(geometry: &Geometry, origin_m: [f64; 2], pose: Pose) -> [f64; 2] {
    let (sine, cosine) = pose.theta_rad.sin_cos();
    let (x, y) = (pose.x_m - origin_m[0], pose.y_m - origin_m[1]);
    let c = [
        cosine * x + sine * y - geometry.lever_m[0],
        cosine * y - sine * x - geometry.lever_m[1],
    ];
    c.map(|c| c / (geometry.height_m * geometry.tan_full_scale))
}

/// `o'` of a beacon that stands over the coordination sensor at a pose.
#[must_use]
pub fn origin_under(geometry: &Geometry, pose: Pose) -> [f64; 2] {
    let lever = turned(geometry.lever_m, pose.theta_rad);
    [pose.x_m - lever[0], pose.y_m - lever[1]]
}

/// Pose at which the sensor is displaced by `offset_m` (platen frame) from the beacon, at an angle: what a turn about the
/// coordination sensor commands.
#[must_use]
pub fn pose_under(
    geometry: &Geometry,
    origin_m: [f64; 2],
    offset_m: [f64; 2],
    theta_rad: f64,
) -> Pose {
    let lever = turned(geometry.lever_m, theta_rad);
    Pose::new(
        origin_m[0] + lever[0] + offset_m[0],
        origin_m[1] + lever[1] + offset_m[1],
        theta_rad,
    )
}

fn turned([x, y]: [f64; 2], angle_rad: f64) -> [f64; 2] {
    let (sine, cosine) = angle_rad.sin_cos();
    [cosine * x - sine * y, sine * x + cosine * y]
}

/// Currents of the electrodes in counts: each axis' two sum to `sum_counts`.
#[must_use]
pub fn electrodes(normalised: [f64; 2], sum_counts: f64) -> [f64; 4] {
    let [x, y] = normalised.map(|u| 0.5 * sum_counts * u);
    let half = 0.5 * sum_counts;
    [half + x, half - x, half + y, half - y]
}
