//! Whether a field is one of the teeth: four segments read other teeth each, and errors of those have nothing to do with each other. What
//! comes with the courier's place, a cable that bends it or air that tilts it, moves all readings together.

use super::Judge;
use crate::scene::Scene;
use crate::study::FIELD;
use crate::trace::log;
use effects::sensor::{READINGS, Regressor};
use nalgebra::{Matrix3, Vector3};
use rayon::prelude::*;
use std::collections::HashMap;

/// Least variance along an axis of the three channels, of the largest. Independent errors over six patches of teeth fall below it once in
/// seventy, over seven once in 450; fields of 22 recordings of two simulators have 0.016 to 0.44, what comes with the place 0.0002 to 0.008, and 0.03 once.
const FLAT: f64 = 0.006;

/// One sample's noise along that axis must be less, or the amounts there are shrunk to nothing by what nobody measured.
const MEASURED: f64 = 0.1;

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
        let noise = self.noise.unwrap_or([1.0; READINGS]);
        let seen: Vec<Seen> = (0..fine.scene.len())
            .into_par_iter()
            .filter(|i| fine.scene.keep[*i])
            .filter_map(|i| Seen::of(&fine.scene, i, &acting, &noise))
            .collect();
        if seen.is_empty() {
            return false;
        }
        let axes = Axes::of(&seen);
        log(&format!("a field's variances along its axes {axes:?}"));
        axes.least < FLAT && axes.noise < MEASURED
    }
}

/// What a field does at one sample, in units in which independent errors of one size of the four readings do as much to each channel, and
/// to none with another.
struct Seen {
    /// Half a tooth of the platen that the courier's centre is over.
    cell: [i64; 2],
    channels_m: Vector3<f64>,
    /// Covariance of the readings' noise there.
    noise_m2: Matrix3<f64>,
}

impl Seen {
    /// None where not all three channels are seen.
    fn of(
        scene: &Scene,
        i: usize,
        acting: &[(&Regressor, f64)],
        noise: &[f64; READINGS],
    ) -> Option<Self> {
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
        let stated = scene.reading_variance(i);
        let both = |variance: &dyn Fn(usize) -> f64| {
            Matrix3::from_fn(|a, b| {
                let product =
                    |r: usize| rows.by_reading[a][r] * variance(r) * rows.by_reading[b][r];
                (0..READINGS).map(product).sum::<f64>()
            })
        };
        let segments = both(&|r| if r < 4 { 1.0 } else { 0.0 });
        let noise = both(&|r| stated[r] * noise[r].powi(2));
        let mixed = segments.cholesky()?.l();
        let half = mixed.solve_lower_triangular(&noise)?;
        let half_m = 0.5 * scene.observations.pitch_m;
        Some(Self {
            cell: moment.centre_m.map(|m| (m / half_m).floor() as i64),
            channels_m: mixed.solve_lower_triangular(&sum)?,
            noise_m2: mixed.solve_lower_triangular(&half.transpose())?,
        })
    }
}

/// Variances of a field along the channels' own axes, over the largest; each place counts once.
#[derive(Debug)]
struct Axes {
    least: f64,
    /// Of one sample's noise, along the axis of the least.
    noise: f64,
}

impl Axes {
    fn of(seen: &[Seen]) -> Self {
        let mut counts: HashMap<[i64; 2], f64> = HashMap::new();
        seen.iter()
            .for_each(|s| *counts.entry(s.cell).or_default() += 1.0);
        let all = counts.len() as f64;
        let weight = |s: &Seen| 1.0 / (all * counts[&s.cell]);
        let mean: Vector3<f64> = seen.iter().map(|s| s.channels_m * weight(s)).sum();
        let spread = |s: &Seen| {
            let off = s.channels_m - mean;
            off * off.transpose() * weight(s)
        };
        let spread = seen
            .iter()
            .map(spread)
            .sum::<Matrix3<f64>>()
            .symmetric_eigen();
        let noise: Matrix3<f64> = seen.iter().map(|s| s.noise_m2 * weight(s)).sum();
        let largest = spread.eigenvalues.max().max(f64::MIN_POSITIVE);
        let axis = spread.eigenvectors.column(spread.eigenvalues.imin());
        Self {
            least: spread.eigenvalues.min() / largest,
            noise: axis.dot(&(noise * axis)) / largest,
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::random::{ChaCha8Rng, SeedableRng, normal};

    /// Errors of all three channels by as many numbers a place, each place seen as often as chance has it.
    fn of(numbers: usize) -> f64 {
        let mut rng = ChaCha8Rng::seed_from_u64(3);
        let mut seen = Vec::new();
        for place in 0..200 {
            let drawn = Vector3::from_fn(|k, _| if k < numbers { normal(&mut rng) } else { 0.0 });
            let channels_m = Matrix3::new(1.0, 0.5, 0.0, 0.0, 1.0, -0.5, 0.3, 0.0, 1.0) * drawn;
            seen.extend((0..1 + place % 7).map(|_| Seen {
                cell: [place, 0],
                channels_m,
                noise_m2: Matrix3::identity(),
            }));
        }
        let axes = Axes::of(&seen);
        assert!((0.1..1.0).contains(&axes.noise), "{axes:?}");
        axes.least
    }

    #[test]
    fn three_numbers_a_place_fill_three_channels_and_fewer_do_not() {
        assert!(of(3) > 0.1);
        assert!(of(2) < 1e-9);
        assert!(of(1) < 1e-9);
    }
}
