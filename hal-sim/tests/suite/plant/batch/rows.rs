//! The rows of 3.1.2 and 3.2.1, computed by the paper's method from a simulated courier's recordings.

use super::*;

/// A row: name, the paper's value, ours.
pub type Row = (&'static str, f64, f64);

fn residual(readings: &[Reading], platen: &Platen, geometry: &Geometry) -> f64 {
    1e6 * deviation(
        readings
            .iter()
            .map(|r| pose(&calibrated(r, platen, geometry), geometry)[4]),
    )
}

/// Errors of y (um), theta_x and theta_y (mrad) against the reference.
pub fn errors(readings: &[Reading], platen: &Platen, geometry: &Geometry) -> [f64; 3] {
    let poses: Vec<_> = readings
        .iter()
        .map(|r| {
            (
                pose(&calibrated(r, platen, geometry), geometry),
                r.reference,
            )
        })
        .collect();
    let of = |column: usize, reference: usize, unit: f64| {
        unit * deviation(poses.iter().map(|(p, r)| p[column] - r[reference]))
    };
    [of(1, 1, 1e6), of(2, 2, 1e3), of(3, 2, 1e3)]
}

/// 3.1.2: scatter and a fly-by in y.
pub fn platen_rows(
    scatter: &[Reading],
    flyby: &[Reading],
    geometry: &Geometry,
) -> (Platen, Vec<Row>) {
    let (platen, condition) = fit_parity(scatter, geometry);
    let none = Platen::NONE;
    let (before, after) = (
        errors(flyby, &none, geometry),
        errors(flyby, &platen, geometry),
    );
    let rows = vec![
        ("condition number", 8.0, condition),
        (
            "scatter residual before, um",
            29.3,
            residual(scatter, &none, geometry),
        ),
        (
            "scatter residual after, um",
            4.1,
            residual(scatter, &platen, geometry),
        ),
        (
            "fly-by residual before, um",
            12.1,
            residual(flyby, &none, geometry),
        ),
        (
            "fly-by residual after, um",
            5.5,
            residual(flyby, &platen, geometry),
        ),
        ("fly-by position before, um", 8.9, before[0]),
        ("fly-by position after, um", 6.5, after[0]),
        ("theta_x before, mrad", 0.4, before[1]),
        ("theta_x after, mrad", 0.4, after[1]),
        ("theta_y before, mrad", 1.2, before[2]),
        ("theta_y after, mrad", 0.4, after[2]),
    ];
    (platen, rows)
}

/// 3.2.1: still poses and a sweep in y under the beacon.
pub fn joint_rows(
    beacon: &[Reading],
    sweep: &[Reading],
    geometry: &Geometry,
) -> (Platen, Mount, Vec<Row>) {
    let (separate, _) = fit_parity(beacon, geometry);
    let mount = fit_mount(beacon, &separate, geometry);
    let (joint, joint_mount) = fit_joint(beacon, &separate, &mount, geometry);
    let residuals = |platen: &Platen, mount: &Mount| {
        let g = |axis: usize| {
            1e6 * deviation(
                beacon
                    .iter()
                    .map(|r| constraint(r, platen, mount, geometry)[axis]),
            )
        };
        [g(0), g(1), residual(beacon, platen, geometry)]
    };
    let (initial, last) = (
        residuals(&separate, &mount),
        residuals(&joint, &joint_mount),
    );
    let [none, apart, together] =
        [&Platen::NONE, &separate, &joint].map(|platen| errors(sweep, platen, geometry));
    let rows = vec![
        ("g_x initial, um", 8.4, initial[0]),
        ("g_y initial, um", 31.6, initial[1]),
        ("g_p initial, um", 4.2, initial[2]),
        ("g_x joint, um", 8.06, last[0]),
        ("g_y joint, um", 25.2, last[1]),
        ("g_p joint, um", 5.19, last[2]),
        ("position uncalibrated, um", 7.3, none[0]),
        ("position separate, um", 4.4, apart[0]),
        ("position joint, um", 2.9, together[0]),
        ("theta_y uncalibrated, mrad", 1.4, none[2]),
        ("theta_y separate, mrad", 0.40, apart[2]),
        ("theta_y joint, mrad", 0.43, together[2]),
        ("theta_x uncalibrated, mrad", 0.13, none[1]),
        ("theta_x separate, mrad", 0.17, apart[1]),
        ("theta_x joint, mrad", 0.30, together[1]),
    ];
    (joint, joint_mount, rows)
}
