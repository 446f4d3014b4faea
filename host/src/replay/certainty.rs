//! How well a recording tells equation (3): the batch fit with the covariance of its coefficients.
//!
//! Samples that follow each other see the same of what no term describes, so their residuals are not independent, and the usual covariance
//! is too small. The scores (rows times residuals) are summed over each stretch of the motion, and the squares of these sums held against
//! what independent residuals give: that ratio is the covariance's factor (the cluster sandwich of Liang and Zeger 1986, Biometrika 73,
//! 13, of which one number is taken, since some hundred stretches tell no matrix of 33 by 33).

use super::channel::Channel;
use super::fit::{Phase, Problem};
use super::observe::{Observer, Sample};
use super::report::{self, Seen};
use anyhow::{Result, ensure};
use courier_sensor::geometry::Geometry;
use indicatif::ProgressBar;
use nalgebra::{DMatrix, DVector};
use recording::Recording;

/// One channel's fit.
#[derive(Clone, Debug)]
pub struct Certain {
    /// `g_p`, or a segment against a reference.
    pub channel: Channel,
    /// Offset, then eight coefficients of each segment that enters, metres.
    pub coefficients_m: Vec<f64>,
    /// Their covariance, m^2.
    pub covariance_m2: DMatrix<f64>,
    /// Degrees of freedom of its scale: stretches less one.
    pub freedom: f64,
    /// By how much the covariance is larger than that of independent residuals.
    pub factor: f64,
    /// Rms of the residual that is left on samples that were held out, metres.
    pub held_out_rms_m: f64,
}

/// Fits each channel of a recording; the geometry as the firmware holds it.
///
/// # Errors
/// As [`super::replay`].
pub fn certain(recording: &Recording) -> Result<(Geometry, Vec<Certain>)> {
    let channels = Channel::of(recording);
    ensure!(
        !channels.is_empty(),
        "samples.csv: found neither four segments nor a reference, wanted one of them"
    );
    let observer = Observer::new(recording)?;
    let fits = channels
        .into_iter()
        .map(|channel| fit(recording, &observer, channel));
    Ok((observer.geometry, fits.collect::<Result<_>>()?))
}

fn fit(recording: &Recording, observer: &Observer, channel: Channel) -> Result<Certain> {
    let Seen { samples, split } =
        report::seen(recording, observer, channel, &ProgressBar::hidden());
    let problem = Problem::new(channel, observer.geometry, recording.meta.geometry.pitch_m);
    let chosen = || split.fitted.iter().map(|index| &samples[*index]);
    // The firmware's own estimator refuses what does not determine every unknown.
    problem.incremental(chosen())?;
    let batch = problem.batch(chosen(), Phase::Output)?;
    report::enough_held_out(channel, &split)?;
    let residual = |sample: &Sample| problem.batch_residual_m(&batch, sample, Phase::Output);
    let rows: Vec<f64> = chosen()
        .flat_map(|sample| problem.row_f64(sample, Phase::Output))
        .collect();
    let rows = DMatrix::from_row_slice(split.fitted.len(), problem.unknowns(), &rows);
    let residuals_m = DVector::from_iterator(split.fitted.len(), chosen().map(residual));
    let stretches = stretches(&split.fitted, &split.held_out);
    let (covariance_m2, factor) = sandwich(&rows, &residuals_m, &stretches);
    let held_out_rms_m = report::rms(
        split
            .held_out
            .iter()
            .map(|index| residual(&samples[*index])),
    );
    Ok(Certain {
        channel,
        coefficients_m: batch.coefficients_m,
        covariance_m2,
        freedom: (stretches.len() as f64 - 1.0).max(1.0),
        factor,
        held_out_rms_m,
    })
}

/// Ranges of the fitted samples between those that were held out.
fn stretches(fitted: &[usize], held_out: &[usize]) -> Vec<std::ops::Range<usize>> {
    let mut list = Vec::new();
    let mut begin = 0;
    for end in 1..=fitted.len() {
        let parted = fitted.get(end).is_none_or(|next| {
            let before = held_out.partition_point(|held| *held < fitted[end - 1]);
            held_out.get(before).is_some_and(|held| held < next)
        });
        if parted {
            list.push(begin..end);
            begin = end;
        }
    }
    list
}

/// Covariance of the solution, and the factor over that of independent residuals: not below one, as neighbours that cancel are chance.
fn sandwich(
    rows: &DMatrix<f64>,
    residuals: &DVector<f64>,
    stretches: &[std::ops::Range<usize>],
) -> (DMatrix<f64>, f64) {
    let (count, unknowns) = rows.shape();
    let variance = residuals.norm_squared() / (count.saturating_sub(unknowns)).max(1) as f64;
    let triangle = rows.clone().qr().unpack_r();
    let inverse = triangle
        .try_inverse()
        .unwrap_or_else(|| DMatrix::zeros(unknowns, unknowns));
    let (mut found, mut independent) = (0.0, 0.0);
    for stretch in stretches {
        // Rows of a stretch in the triangle's coordinates: the covariance of independent residuals is then the unit matrix.
        let own = rows.rows(stretch.start, stretch.len()) * &inverse;
        let score = own.tr_mul(&residuals.rows(stretch.start, stretch.len()));
        found += score.norm_squared();
        // Fitted residuals are smaller than the noise, by what each stretch draws the solution to itself.
        let products = own.tr_mul(&own);
        independent += variance * (products.trace() - products.norm_squared());
    }
    let factor = if independent > 0.0 {
        (found / independent).max(1.0)
    } else {
        1.0
    };
    (&inverse * inverse.transpose() * (variance * factor), factor)
}

#[cfg(test)]
mod tests {
    use super::*;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    #[test]
    fn held_out_samples_part_stretches() {
        assert_eq!(
            stretches(&[0, 1, 2, 5, 6, 9], &[3, 4, 7]),
            [0..3, 3..5, 5..6]
        );
        assert_eq!(stretches(&[0, 3, 9], &[6]), [0..2, 2..3]);
        assert!(stretches(&[], &[1]).is_empty());
    }

    /// Mean squared error of a fit over its covariance, by 60 draws of residuals in which each keeps `memory` of the one before.
    fn honesty(memory: f64) -> f64 {
        const ROWS: usize = 2400;
        const UNKNOWNS: usize = 5;
        let mut rng = ChaCha8Rng::seed_from_u64(5);
        let row = |k: usize, j: usize| match j {
            0 => 1.0,
            j => (0.05 * k as f64 * j.div_ceil(2) as f64 + 1.57 * (j % 2) as f64).sin(),
        };
        let rows = DMatrix::from_fn(ROWS, UNKNOWNS, row);
        let stretches: Vec<std::ops::Range<usize>> =
            (0..80).map(|k| 30 * k..30 * (k + 1)).collect();
        let solve = (rows.transpose() * &rows).try_inverse().unwrap() * rows.transpose();
        const DRAWS: usize = 60;
        let mut sum = 0.0;
        for _ in 0..DRAWS {
            let mut last = 0.0;
            let noise = DVector::from_fn(ROWS, |_, _| {
                let new: f64 = StandardNormal.sample(&mut rng);
                last = memory * last + new;
                last
            });
            let solution = &solve * &noise;
            let (covariance, _) = sandwich(&rows, &(&noise - &rows * &solution), &stretches);
            sum += (solution.transpose() * covariance.try_inverse().unwrap() * &solution)[(0, 0)];
        }
        sum / (DRAWS * UNKNOWNS) as f64
    }

    /// Of 300 squares the mean is known to 8 %: three of that, and what a factor that is never below one adds.
    #[test]
    fn a_covariance_is_right_with_and_without_memory() {
        for memory in [0.0, 0.8] {
            let found = honesty(memory);
            assert!((0.72..1.25).contains(&found), "memory {memory}: {found}");
        }
    }
}
