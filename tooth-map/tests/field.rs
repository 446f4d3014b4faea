//! A platen with a known field of displaced teeth: the map is that field.

use courier_sensor::equations::{self, Angle, beacon, lateral_arguments, middle, outputs, theta};
use courier_sensor::geometry::Geometry;
use courier_sensor::teeth::Grid;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, StandardNormal, Uniform};
use std::f64::consts::TAU;
use tooth_map::{Mapped, Setup, TeethPose, estimate};

/// Noise of the readings: what a standstill's average of some frames has.
const SEGMENT_M: f64 = 0.05e-6;
const DISPLACEMENT_M: f64 = 0.1e-6;
/// Travel either way, pitches, and angle either way.
const TRAVEL: f64 = 2.0;
const TURN_RAD: f64 = 0.048;
const POSES: usize = 800;

/// The displacement of the teeth along x or y, m, at a place along and across, pitches: waves that are long beside a pitch, as a mean
/// over several teeth leaves them.
fn field_m(direction: usize, [along, across]: [f64; 2]) -> f64 {
    let lean = [0.3, 1.1][direction];
    let bent = (TAU * along / 5.0 + lean).sin() * (TAU * across / 7.0 - lean).cos();
    3.0e-6 * bent + 1.5e-6 * (TAU * (along + across) / 9.0 + 2.0 * lean).sin()
}

/// Places of the segments in their fields, pitches.
fn places(setup: &Setup, p: &[f64; 4]) -> [[f64; 2]; 4] {
    let lateral = lateral_arguments(middle(p), theta(p, setup.span_m), setup.lateral_m);
    let places_m = equations::places(p, &lateral, setup.span_m);
    places_m.map(|place| place.map(|p| p / setup.pitch_m))
}

/// Readings at a true place: the teeth hide part of it.
fn pose(setup: &Setup, rng: &mut ChaCha8Rng) -> TeethPose {
    let travel = Uniform::new(-TRAVEL, TRAVEL).unwrap();
    let centre_m = [0, 1].map(|_| setup.pitch_m * travel.sample(rng));
    let turn_rad = Uniform::new(-TURN_RAD, TURN_RAD).unwrap().sample(rng);
    let truth = outputs(centre_m, turn_rad, setup.span_m);
    let mut outputs_m = truth;
    for _ in 0..4 {
        let places = places(setup, &outputs_m);
        outputs_m = std::array::from_fn(|i| truth[i] - field_m(i % 2, places[i]));
    }
    // Equation (11) is linear in the displacement: what is left without one is turned back.
    let angle = Angle::of_rad(turn_rad);
    let without = beacon(centre_m, [0.0; 2], setup.lever_m, [0.0; 2], &angle).g;
    let [c, s] = [angle.cosine, angle.sine];
    let displacement_m = [
        -c * without[0] - s * without[1],
        s * without[0] - c * without[1],
    ];
    let mut noise = |size_m: f64| {
        let unit: f64 = StandardNormal.sample(rng);
        size_m * unit
    };
    let scale_m = setup.height_m * setup.tan_full_scale;
    TeethPose {
        outputs_m: outputs_m.map(|p| p + noise(SEGMENT_M)),
        deflection: displacement_m.map(|d| (d + noise(DISPLACEMENT_M)) / scale_m),
    }
}

/// The map's field at a place, by the definition of the B-spline (Cox and de Boor's recursion), and its predicted deviation; none where it
/// is not trusted.
fn mapped_m(mapped: &Mapped, direction: usize, place: [f64; 2]) -> Option<[f64; 2]> {
    fn bspline(degree: i32, x: f64) -> f64 {
        if degree == 0 {
            return f64::from(u8::from((0.0..1.0).contains(&x)));
        }
        let d = f64::from(degree);
        x / d * bspline(degree - 1, x) + (d + 1.0 - x) / d * bspline(degree - 1, x - 1.0)
    }
    let grid = mapped.header.grids[direction];
    let from_first = [0, 1].map(|k| place[k] - f64::from(grid.first_teeth[k]));
    let row = usize::from(grid.nodes[1]);
    let before: usize = mapped.header.grids[..direction]
        .iter()
        .map(Grid::count)
        .sum();
    let [i, j] = from_first.map(|p| p.floor() as usize - 1);
    let cell = before + i * row + j;
    let trusted = mapped.header.trusted[cell / 32] >> (cell % 32) & 1 == 1;
    let deviation_m = mapped.deviations_m[cell].filter(|_| trusted)?;
    let node = |n: usize| {
        let at = [n / row, n % row];
        let weight = |k: usize| bspline(3, from_first[k] - at[k] as f64 + 2.0);
        1.0e-9 * f64::from(mapped.nodes_nm[before + n]) * weight(0) * weight(1)
    };
    Some([(0..grid.count()).map(node).sum(), deviation_m])
}

/// Rms about the straight line of best fit over the place along: a field's mean and slope are gauge, and a prior's.
fn rms_about_a_line(points: &[[f64; 2]]) -> f64 {
    let count = points.len() as f64;
    let mean = [0, 1].map(|k| points.iter().map(|p| p[k]).sum::<f64>() / count);
    let sum = |f: &dyn Fn(f64, f64) -> f64| -> f64 {
        points
            .iter()
            .map(|[x, y]| f(x - mean[0], y - mean[1]))
            .sum()
    };
    let slope = sum(&|x, y| x * y) / sum(&|x, _| x * x);
    (sum(&|x, y| (y - slope * x).powi(2)) / count).sqrt()
}

#[test]
fn a_known_field_is_found() {
    let setup = Setup::entered(&Geometry::PAPER, SEGMENT_M, DISPLACEMENT_M);
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let poses: Vec<TeethPose> = (0..POSES).map(|_| pose(&setup, &mut rng)).collect();
    let mapped = estimate(&setup, &poses, &mut || ()).unwrap();
    for direction in 0..2 {
        let (mut left, mut was, mut variances_m2) = (Vec::new(), Vec::new(), Vec::new());
        for k in 0..400 {
            let step = |k: usize, irrational: f64| (k as f64 * irrational).fract() - 0.5;
            let along = 2.0 * TRAVEL * step(k, 0.618_034);
            // The segments of a pair are half a span to either side.
            let side = if k % 2 == 0 { 0.5 } else { -0.5 } * setup.span_m / setup.pitch_m;
            let place = [along, side + 2.0 * TRAVEL * step(k, 0.754_878)];
            if let Some([found_m, deviation_m]) = mapped_m(&mapped, direction, place) {
                let truth_m = field_m(direction, place);
                left.push([along, found_m - truth_m]);
                was.push([along, truth_m]);
                variances_m2.push(deviation_m.powi(2));
            }
        }
        let [left_m, was_m] = [&left, &was].map(|points| rms_about_a_line(points));
        let predicted_m = (variances_m2.iter().sum::<f64>() / left.len() as f64).sqrt();
        println!(
            "{} places: {was_m:.2e} m, left {left_m:.2e}, predicted {predicted_m:.2e}",
            left.len()
        );
        assert!(left.len() > 150, "trusted at {} places", left.len());
        assert!(left_m < 0.5 * was_m, "{left_m} of {was_m}");
        // Errors go together over many cells: few of them are independent, and chance is left half of the deviation.
        assert!(left_m < 1.5 * predicted_m, "{left_m}, {predicted_m}");
    }
}
