//! Whether a field is one of the teeth: four segments read other teeth each, and errors of those have nothing to do with each other. What
//! comes with the courier's place, a cable that bends it or air that tilts it, moves all readings together.

use super::ModelSelection;
use crate::linearization::recording::LinearizedRecording;
use crate::trace::log;
use effects::Detection;
use effects::sensor::{READINGS, Regressor};
use nalgebra::{Matrix3, SMatrix, SVector, Vector3};
use rayon::prelude::*;
use std::collections::HashMap;

/// Least variance along an axis of the three channels, of the largest. Independent errors over six patches of teeth fall below it once in
/// seventy, over seven once in 450; fields of 22 recordings of two simulators have 0.016 to 0.44, what comes with the place 0.0002 to 0.008, and 0.03 once.
const FLAT_VARIANCE_RATIO: f64 = 0.006;

/// One sample's noise along that axis must be less, or the amounts there are shrunk to nothing by what nobody measured.
const AXIS_NOISE_RATIO: f64 = 0.1;

/// The same of what is rough of a field. As was measured, it is 0.02 to 0.18 with 3 fields that had taken in a smooth effect, and
/// 1.6 with a tether that strains.
const ROUGH_AXIS_NOISE_RATIO: f64 = 0.5;

/// What a field does to the three channels where a beacon is seen.
pub(super) struct CommonField {
    whole: Axes,
    /// About what is smooth over the platen.
    rough: Axes,
}

impl CommonField {
    /// True if that has fewer dimensions than the channels: something else is in it.
    pub(super) fn is_flat(&self) -> bool {
        self.whole.least < FLAT_VARIANCE_RATIO && self.whole.noise < AXIS_NOISE_RATIO
    }

    /// True if what is rough of it has as many: teeth are in it as well.
    fn has_teeth(&self) -> bool {
        self.rough.least >= FLAT_VARIANCE_RATIO && self.rough.noise < ROUGH_AXIS_NOISE_RATIO
    }
}

impl ModelSelection<'_> {
    /// True if a field that is found is none of the teeth.
    pub(super) fn errs_together(&self) -> bool {
        self.common_field()
            .is_some_and(|common_field| common_field.is_flat() && !common_field.has_teeth())
    }

    /// Of the field that is found; none without one or without a beacon.
    pub(super) fn common_field(&self) -> Option<CommonField> {
        let relinearized = &self.relinearized;
        let field = relinearized
            .columns
            .blocks
            .iter()
            .find(|b| effects::is(&b.name, Detection::AsField))?;
        let acting: Vec<(&Regressor, f64)> = field
            .columns
            .clone()
            .map(|c| {
                (
                    &relinearized.columns.regressors[c],
                    relinearized.coefficient(c),
                )
            })
            .filter(|(_, amount)| *amount != 0.0)
            .collect();
        let noise = self.noise.unwrap_or([1.0; READINGS]);
        let seen: Vec<FieldSample> = (0..relinearized.linearized.len())
            .into_par_iter()
            .filter(|i| relinearized.linearized.mask[*i])
            .filter_map(|i| FieldSample::of(&relinearized.linearized, i, &acting, &noise))
            .collect();
        if seen.is_empty() {
            return None;
        }
        let [whole, rough] = [Terms::Mean, Terms::Smooth].map(|terms| Axes::of(&seen, terms));
        log(&format!(
            "a field's variances along its axes {whole:?}, of what is rough of it {rough:?}"
        ));
        Some(CommonField { whole, rough })
    }
}

/// What a field does at one sample, in units in which independent errors of one size of the four readings do as much to each channel, and
/// to none with another.
struct FieldSample {
    /// Half a tooth of the platen that the courier's centre is over.
    cell: [i64; 2],
    channels_m: Vector3<f64>,
    /// Covariance of the readings' noise there.
    noise_m2: Matrix3<f64>,
}

impl FieldSample {
    /// None where not all three channels are seen.
    fn of(
        linearized: &LinearizedRecording,
        i: usize,
        acting: &[(&Regressor, f64)],
        noise: &[f64; READINGS],
    ) -> Option<Self> {
        let rows = linearized.rows(i);
        if rows.count < 3 {
            return None;
        }
        let covariates = linearized.covariates(i);
        let mut sum = Vector3::zeros();
        for (regressor, amount) in acting.iter().filter(|(r, _)| r.acts(&covariates)) {
            let response = rows.response(regressor, &covariates);
            sum += Vector3::from_fn(|row, _| amount * response[row]);
        }
        let stated = linearized.reading_variance(i);
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
        let half_m = 0.5 * linearized.observations.pitch_m;
        Some(Self {
            cell: covariates.centre_m.map(|m| (m / half_m).floor() as i64),
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
    fn of(seen: &[FieldSample], terms: Terms) -> Self {
        let mut counts: HashMap<[i64; 2], f64> = HashMap::new();
        seen.iter()
            .for_each(|s| *counts.entry(s.cell).or_default() += 1.0);
        let all = counts.len() as f64;
        let weight = |s: &FieldSample| 1.0 / (all * counts[&s.cell]);
        let smooth = Smooth::of(seen, terms, &weight);
        let spread = |s: &FieldSample| {
            let off = s.channels_m - smooth.at(s);
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

/// What a field's variances are about.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Terms {
    /// Its mean.
    Mean,
    /// What is smooth of it.
    Smooth,
}

/// Terms of a polynomial of third degree of the place. A definition: (3 + 1)(3 + 2) / 2 of two coordinates.
const CUBIC_TERMS: usize = 10;

/// What the channels have of a smooth shape over the platen: what a field takes in of another effect for want of it, a diode's
/// nonlinearity or rulings that are askew. Teeth are rough, and it says nothing of them.
struct Smooth {
    kept: Terms,
    middle: [f64; 2],
    half: [f64; 2],
    amounts: SMatrix<f64, CUBIC_TERMS, 3>,
}

impl Smooth {
    fn of(seen: &[FieldSample], kept: Terms, weight: &impl Fn(&FieldSample) -> f64) -> Self {
        let range = |axis: usize| {
            let coordinate_blocks = seen.iter().map(|s| s.cell[axis] as f64);
            coordinate_blocks.fold((f64::INFINITY, f64::NEG_INFINITY), |(l, h), p| {
                (l.min(p), h.max(p))
            })
        };
        let ranges = [range(0), range(1)];
        let mut this = Self {
            kept,
            middle: ranges.map(|(low, high)| 0.5 * (low + high)),
            half: ranges.map(|(low, high)| (0.5 * (high - low)).max(0.5)),
            amounts: SMatrix::zeros(),
        };
        let mut normal = SMatrix::<f64, CUBIC_TERMS, CUBIC_TERMS>::identity() * 1e-9;
        let mut right = SMatrix::<f64, CUBIC_TERMS, 3>::zeros();
        for s in seen {
            let terms = this.terms(s);
            normal += terms * terms.transpose() * weight(s);
            right += terms * s.channels_m.transpose() * weight(s);
        }
        if let Some(factor) = normal.cholesky() {
            this.amounts = factor.solve(&right);
        }
        this
    }

    fn at(&self, s: &FieldSample) -> Vector3<f64> {
        self.amounts.transpose() * self.terms(s)
    }

    fn terms(&self, s: &FieldSample) -> SVector<f64, CUBIC_TERMS> {
        if self.kept == Terms::Mean {
            return SVector::ith(0, 1.0);
        }
        let [x, y] = [0, 1].map(|a| (s.cell[a] as f64 - self.middle[a]) / self.half[a]);
        SVector::from([
            1.0,
            x,
            y,
            x * x,
            x * y,
            y * y,
            x * x * x,
            x * x * y,
            x * y * y,
            y * y * y,
        ])
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
            seen.extend((0..1 + place % 7).map(|_| FieldSample {
                cell: [place, 0],
                channels_m,
                noise_m2: Matrix3::identity(),
            }));
        }
        let axes = Axes::of(&seen, Terms::Mean);
        assert!((0.1..1.0).contains(&axes.noise), "{axes:?}");
        axes.least
    }

    #[test]
    fn three_numbers_a_place_fill_three_channels_and_fewer_do_not() {
        assert!(of(3) > 0.1);
        assert!(of(2) < 1e-9);
        assert!(of(1) < 1e-9);
    }

    /// A tilt of the courier that grows over the platen, with what single teeth do beside it.
    #[test]
    fn teeth_are_seen_beside_what_is_smooth_and_greater() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut common_field = |teeth: f64| {
            let mut seen = Vec::new();
            for place in 0..225 {
                let cell = [place % 15, place / 15];
                let [x, y] = cell.map(|c| (c - 7) as f64 / 7.0);
                let tilt = 20.0 * (x * x - 0.5 * x * y + 0.3 * y);
                let rough = Vector3::from_fn(|_, _| teeth * normal(&mut rng));
                seen.extend((0..3).map(|_| FieldSample {
                    cell,
                    channels_m: Vector3::new(1.0, -0.4, 0.2) * tilt + rough,
                    noise_m2: Matrix3::identity() * 0.01,
                }));
            }
            let [whole, rough] = [Terms::Mean, Terms::Smooth].map(|terms| Axes::of(&seen, terms));
            CommonField { whole, rough }
        };
        let beside = common_field(0.5);
        assert!(beside.is_flat() && beside.has_teeth());
        let alone = common_field(0.01);
        assert!(alone.is_flat() && !alone.has_teeth());
        assert!(!common_field(10.0).is_flat());
    }
}
