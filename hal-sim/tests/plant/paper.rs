//! The `paper` preset: the paper's own method on it gives the paper's rows, for poses and noise of any seed.

use crate::batch::rows::{Row, joint_rows, platen_rows};
use crate::batch::{Reading, reading};
use effects::motion::Pose;
use effects::plant::Geometry;
use hal_sim::coordination::origin_under;
use hal_sim::courier::Courier;
use hal_sim::presets::paper;
use hal_sim::record::observe;
use hal_sim::trajectory::{BEACON_ANGLE_RAD, OpenLoop, Plan, SCATTER_ANGLE_RAD};

const GEOMETRY: Geometry = Geometry::PAPER;
const POSES: usize = 1000;

/// Still poses and a sweep along y of a length about a place.
fn readings(
    stills: impl FnOnce(Plan) -> Plan,
    middle: Pose,
    length_m: f64,
    speed: f64,
    seed: u64,
) -> Vec<Reading> {
    let half = Pose::new(0.0, 0.5 * length_m, 0.0);
    let plan = stills(Plan::new(middle, GEOMETRY, OpenLoop::COURIER, seed));
    let plan = plan.sweep(
        "y",
        [middle.plus(half, -1.0), middle.plus(half, 1.0)],
        speed,
    );
    let mut courier = Courier::new(paper(), seed).unwrap();
    observe(&mut courier, &plan)
        .iter()
        .map(|o| reading(o, &GEOMETRY))
        .collect()
}

fn rows(seed: u64) -> [Vec<Row>; 2] {
    let places = paper().places;
    let origin = origin_under(&GEOMETRY, places.beacon);
    let scatter = |plan: Plan| {
        plan.scatter(
            POSES,
            places.scatter_corner,
            10.0 * GEOMETRY.pitch_m,
            SCATTER_ANGLE_RAD,
        )
    };
    let first = readings(scatter, places.flyby, 40e-3, 50e-3, seed);
    let beacon = |plan: Plan| plan.beacon(POSES, origin, BEACON_ANGLE_RAD);
    let second = readings(beacon, places.beacon_sweep, 8e-3, 20e-3, seed);
    let (_, platen) = platen_rows(&first[..POSES], &first[POSES..], &GEOMETRY);
    let (_, _, joint) = joint_rows(&second[..POSES], &second[POSES..], &GEOMETRY);
    [platen, joint]
}

/// Rows of 3.1.2 within 25 % for every seed. Rows of 3.2.1 within 30 % on average over the seeds, and within 40 % for each:
/// theta_x before calibration, 1.3 um over the span, also has what the sweep's sideways drift makes of the error's slope.
#[test]
fn the_papers_method_gives_the_papers_rows() {
    let tables: Vec<[Vec<Row>; 2]> = (0..6).map(|seed| rows(1000 + 17 * seed)).collect();
    let mut misses = Vec::new();
    for (table, [mean_tolerance, tolerance]) in [[0.25, 0.25], [0.30, 0.40]].into_iter().enumerate()
    {
        for row in 0..tables[0][table].len() {
            let (name, paper, _) = tables[0][table][row];
            let here: Vec<f64> = tables.iter().map(|t| t[table][row].2).collect();
            let mean = here.iter().sum::<f64>() / here.len() as f64;
            println!("{name:30} {paper:8.2} {mean:8.2} {here:8.2?}");
            let off = |value: f64| (value / paper - 1.0).abs();
            if off(mean) > mean_tolerance || here.iter().any(|v| off(*v) > tolerance) {
                misses.push(format!("{name}: {here:.3?}, the paper's {paper}"));
            }
        }
    }
    assert!(misses.is_empty(), "{misses:#?}");
}
