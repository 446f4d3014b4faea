//! Whether a field is one of the teeth: four segments read other teeth each, and errors of those have nothing to do with each other. What
//! comes with the courier's place, a cable that bends it or air that tilts it, moves all readings together.

use super::Judge;
use crate::scene::Scene;
use crate::study::FIELD;
use crate::trace::log;
use effects::sensor::Regressor;
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use std::collections::HashMap;

/// Least variance along an axis of the three channels, of the largest. Independent errors over six patches of teeth fall below it once in
/// seventy, over seven once in 450; fields of 22 recordings of two simulators have 0.016 to 0.44, what comes with the place 0.0002 to 0.008, and 0.03 once.
const FLAT: f64 = 0.006;

impl Judge<'_> {
    /// True if what a field that is found does to the three channels has fewer dimensions than they have, where a beacon is seen.
    pub(super) fn errs_together(&self) -> bool {
        let fine = &self.fine;
        let Some(field) = fine.columns.blocks.iter().find(|b| b.name == FIELD) else {
            return false;
        };
        let acting: Vec<(&Regressor, f64)> = field
            .columns
            .clone()
            .map(|c| (&fine.columns.regressors[c], fine.amount(c)))
            .filter(|(_, amount)| *amount != 0.0)
            .collect();
        let seen: Vec<([i64; 2], Vector3<f64>)> = (0..fine.scene.len())
            .into_par_iter()
            .filter(|i| fine.scene.keep[*i])
            .filter_map(|i| Some((cell(&fine.scene, i), unmixed(&fine.scene, i, &acting)?)))
            .collect();
        let variances = variances(&seen);
        log(&format!(
            "a field's variances along its axes {variances:.4?}"
        ));
        variances[2] < FLAT
    }
}

/// Half a tooth of the platen that the courier's centre is over.
fn cell(scene: &Scene, i: usize) -> [i64; 2] {
    let half_m = 0.5 * scene.observations.pitch_m;
    scene
        .moment(i)
        .centre_m
        .map(|m| (m / half_m).floor() as i64)
}

/// What a field does to the three channels, in units in which independent errors of one size of the four readings do as much to each, and
/// to none with another.
fn unmixed(scene: &Scene, i: usize, acting: &[(&Regressor, f64)]) -> Option<Vector3<f64>> {
    let rows = scene.rows(i);
    if rows.count < 3 {
        return None;
    }
    let moment = scene.moment(i);
    let mut sum = Vector3::zeros();
    for (regressor, amount) in acting.iter().filter(|(r, _)| r.acts(&moment)) {
        let response = rows.response(regressor, &moment);
        sum += Vector3::from_fn(|row, _| amount * response[row]);
    }
    let slopes = |row: usize| rows.by_reading[row];
    let both = |a: usize, b: usize| (0..4).map(|s| slopes(a)[s] * slopes(b)[s]).sum::<f64>();
    let mixed = Matrix3::from_fn(both).cholesky()?;
    mixed.l().solve_lower_triangular(&sum)
}

/// Variances along their own axes, largest first, over the largest; each place counts once.
fn variances(seen: &[([i64; 2], Vector3<f64>)]) -> [f64; 3] {
    let mut counts: HashMap<[i64; 2], f64> = HashMap::new();
    seen.iter()
        .for_each(|(cell, _)| *counts.entry(*cell).or_default() += 1.0);
    let weight = |cell: &[i64; 2]| 1.0 / counts[cell];
    let all: f64 = counts.len() as f64;
    let mean = seen
        .iter()
        .map(|(cell, v)| v * weight(cell))
        .sum::<Vector3<f64>>()
        / all;
    let off = |v: &Vector3<f64>| v - mean;
    let spread = seen
        .iter()
        .map(|(cell, v)| off(v) * off(v).transpose() * weight(cell));
    let mut along: Vec<f64> = spread
        .sum::<Matrix3<f64>>()
        .symmetric_eigenvalues()
        .iter()
        .copied()
        .collect();
    along.sort_by(|a, b| b.total_cmp(a));
    std::array::from_fn(|k| along[k] / along[0].max(f64::MIN_POSITIVE))
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::random::{ChaCha8Rng, SeedableRng, normal};

    /// Errors of all three channels by as many numbers a place, each place seen as often as chance has it.
    fn of(numbers: usize) -> [f64; 3] {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut seen = Vec::new();
        for place in 0..200 {
            let drawn = Vector3::from_fn(|k, _| if k < numbers { normal(&mut rng) } else { 0.0 });
            let mixed = Matrix3::new(1.0, 0.5, 0.0, 0.0, 1.0, -0.5, 0.3, 0.0, 1.0) * drawn;
            seen.extend((0..1 + place % 7).map(|_| ([place, 0], mixed)));
        }
        variances(&seen)
    }

    #[test]
    fn three_numbers_a_place_fill_three_channels_and_fewer_do_not() {
        assert!(of(3)[2] > 0.1);
        assert!(of(2)[2] < 1e-9 && of(2)[1] > 0.1);
        assert!(of(1)[1] < 1e-9);
    }
}
