//! Teeth of the platen as unknown amounts: what a unit displacement of each adds to the readings.

use crate::covariates::Covariates;
use crate::over::{Over, Seat};
use crate::sensor::{READINGS, Regressor};
use tooth_field::Teeth;

/// One amount a tooth and a line, m.
#[must_use]
pub fn tooth_regressors(teeth: &Teeth, pitch_m: f64, size_m: f64) -> Vec<Regressor> {
    let mut list = Vec::new();
    let (lattice, step) = (teeth.lattice(), teeth.step_pitches);
    let place = move |m: &Covariates, segment: usize| m.place_m[segment].map(|p| p / pitch_m);
    let reach_m = teeth.aperture.half_pitches.map(|half| half * pitch_m);
    let (tooth, lines) = if step == [1.0; 2] {
        ("tooth", "line")
    } else {
        ("teeth about", "lines about")
    };
    for (direction, axis) in ["x", "y"].into_iter().enumerate() {
        let over = |place: [f64; 2]| {
            Over::about(Seat::Pair(direction), place.map(|p| p * pitch_m), reach_m)
        };
        for &node in &teeth.posts[direction] {
            let share =
                move |m: &Covariates, segment: usize| lattice.weight(node, place(m, segment));
            let [along, across] = lattice.place_of(node);
            let name = format!(
                "{tooth} {} along, {} across, displaced along {axis}",
                told(along),
                told(across)
            );
            list.push(
                both(name, size_m, teeth.deviation_m[0], direction, share)
                    .only_over(over([along, across])),
            );
        }
        for &line in &teeth.lines[direction] {
            let share =
                move |m: &Covariates, segment: usize| lattice.line_weight(line, place(m, segment));
            let [along, _] = lattice.place_of([line, 0]);
            let name = format!("{lines} {}, displaced along {axis}", told(along));
            let along_m = along * pitch_m;
            let reach_m = [reach_m[0], f64::INFINITY];
            list.push(
                both(name, size_m, teeth.deviation_m[1], direction, share).only_over(Over::about(
                    Seat::Pair(direction),
                    [along_m, 0.0],
                    reach_m,
                )),
            );
        }
    }
    list
}

/// Amounts lie a pitch apart or more: a tenth of one tells them from each other.
fn told(at: f64) -> String {
    format!("{}", (10.0 * at).round() / 10.0)
}

/// Adds to both segments of a pair.
fn both(
    name: String,
    size_m: f64,
    deviation_m: f64,
    direction: usize,
    share: impl Fn(&Covariates, usize) -> f64 + Send + Sync + 'static,
) -> Regressor {
    let add = move |m: &Covariates, out: &mut [f64; READINGS]| {
        out[direction] += share(m, direction);
        out[direction + 2] += share(m, direction + 2);
    };
    Regressor::readings(name, "m", size_m, add).of_deviation(deviation_m)
}
