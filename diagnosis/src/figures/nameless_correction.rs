//! How far a correction without a name gets: shapes over the coordinates where a gap lies that nothing explains, fitted and judged on held-out
//! samples as effects are. What it leaves is what a table over these coordinates would leave on a motion of this kind.

use super::fitted_effects::FittedEffects;
use super::location::{Located, reported};
use crate::data::channel_names::CHANNEL_NAMES;
use crate::design::assembly::Design;
use crate::figures::limits::MINIMUM_SQUARES;
use crate::inference::cross_validation::CrossValidation;
use crate::inference::fit::solve;
use crate::inference::residuals::Residuals;
use crate::transfer::model::NamelessAmounts;
use crate::verdict::answer::{Correction, HeldOutChannel};
use effects::identity::{Factor, Identity, Wave};
use effects::sensor::READINGS;

/// Coordinates of one correction. A prior: that of the cause, and two that it shows in besides, as in [`crate::posterior::nameless`].
const MOST_COORDINATES: usize = 3;

/// A correction, and its held-out residuals by the stated noise.
pub(super) struct NamelessCorrection {
    /// Coordinates in the order in which they were taken.
    pub coordinates: Vec<String>,
    /// What it leaves.
    pub residuals: Residuals,
    /// What those of its shapes add that are waves.
    pub amounts: NamelessAmounts,
}

impl FittedEffects<'_> {
    /// The correction by the shapes of a design over the coordinates where its gap lies. None where none of them takes more than chance does.
    /// Cost: at most three passes over ten coordinates, and one over the samples.
    pub(super) fn nameless_correction(
        &self,
        design: &Design,
        validation: &mut CrossValidation,
        located: &[Located],
    ) -> Option<NamelessCorrection> {
        let (coordinates, columns) = chosen(design, validation, located);
        if columns.is_empty() {
            return None;
        }
        let list = [&design.list(&[])[..], &columns].concat();
        let linearized = &design.linearized;
        let residuals = Residuals::new(
            linearized,
            &design.columns,
            &design.gram,
            &design.folds,
            &list,
        );
        let residuals = if self.noise.is_some() {
            let mut stated =
                linearized.moved(linearized.baseline.clone(), linearized.displacement.clone());
            stated.noise = [1.0; READINGS];
            residuals.rewhitened(&stated)
        } else {
            residuals
        };
        let better = residuals.white_rms() < self.before.white_rms();
        let amounts = amounts(design, &columns, &coordinates);
        better.then_some(NamelessCorrection {
            coordinates,
            residuals,
            amounts: amounts?,
        })
    }

    /// A correction as it is told.
    pub(super) fn correction_told(&self, of: &NamelessCorrection) -> Correction {
        let channels = self.before.channels().into_iter().map(|c| HeldOutChannel {
            channel: CHANNEL_NAMES[c].into(),
            before_rms_m: self.before.channel_rms_m(c).0,
            after_rms_m: of.residuals.channel_rms_m(c).0,
            after_ci95_m: of.residuals.interval_m(c),
            floor_rms_m: self.floor.channel_rms_m[c],
        });
        Correction {
            coordinates: of.coordinates.clone(),
            whitened_after: of.residuals.white_rms() / self.floor.white_square.sqrt(),
            channels: channels.collect(),
        }
    }
}

/// The wave that a shape is, where it is one over tooth phases times a factor that other code knows.
fn wave(design: &Design, column: usize) -> Option<Wave> {
    match design.columns.regressors[column].identity {
        Some(Identity::Wave(wave)) if wave.factor != Factor::Other => Some(wave),
        _ => None,
    }
}

/// Amounts of those shapes that are waves, fitted together with the baseline to all samples in use. The others take no part: amounts of both
/// could nearly cancel, and who takes over the waves alone would have what the others were to take back. None where they are not told apart.
/// Cost: a third of the cube of the columns.
fn amounts(design: &Design, shapes: &[usize], coordinates: &[String]) -> Option<NamelessAmounts> {
    let waves = shapes.iter().filter_map(|c| Some((wave(design, *c)?, *c)));
    let (waves, columns): (Vec<Wave>, Vec<usize>) = waves.unzip();
    let base = design.list(&[]);
    let gram = &design.gram;
    let list = [&base[..], &columns].concat();
    let fit = solve(gram.training(None), &list, &gram.centre, 1.0)?;
    let in_units = list.iter().zip(fit.coefficient.iter());
    let in_units: Vec<f64> = in_units.map(|(c, v)| v * gram.scale[*c]).collect();
    let (step, amounts) = in_units.split_at(base.len());
    let linearized = &design.linearized;
    let mut baseline = linearized.baseline.clone();
    baseline.add(linearized.scope, step);
    Some(NamelessAmounts {
        coordinates: coordinates.to_vec(),
        baseline,
        other_shapes: shapes.len() - waves.len(),
        waves: waves.into_iter().zip(amounts.iter().copied()).collect(),
    })
}

/// Coordinates and their columns, one after the other: each time that which leaves least, as long as it takes more than chance.
fn chosen(
    design: &Design,
    validation: &mut CrossValidation,
    located: &[Located],
) -> (Vec<String>, Vec<usize>) {
    let base = design.list(&[]);
    let mut columns: Vec<usize> = Vec::new();
    let mut coordinates: Vec<String> = Vec::new();
    let mut left = validation.score_columns(&base).squares;
    while coordinates.len() < MOST_COORDINATES {
        let others = reported(located).filter(|l| !coordinates.contains(&l.coordinate));
        let with = others.map(|l| {
            let mut set = columns.clone();
            set.extend(l.columns().iter().filter(|c| !columns.contains(c)));
            let list = [&base[..], &set].concat();
            (validation.score_columns(&list).squares, &l.coordinate, set)
        });
        let best = with.min_by(|a, b| a.0.total_cmp(&b.0));
        let Some((squares, coordinate, set)) =
            best.filter(|(squares, ..)| left - squares > 2.0 * MINIMUM_SQUARES)
        else {
            break;
        };
        coordinates.push(coordinate.clone());
        (left, columns) = (squares, set);
    }
    (coordinates, columns)
}
