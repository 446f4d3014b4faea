//! How far an effect's form is from what a sensor does, measured on a recording in which that effect acts alone.

use super::diagnosed::{Decided, decided};
use super::discrepancy::excess;
use super::evidence::fitted;
use super::look::design;
use super::noise_scale::Left;
use super::trial::has_knots;
use super::weighing::Weighing;
use crate::Insufficient;
use crate::data::prepare::{Prepared, prepare};
use crate::design::assembly::{Design, DesignOptions, Options};
use crate::progress::unwatched;
use recording::Recording;

/// What an effect alone makes of a recording. Squares are whitened, over the noise.
#[derive(Clone, Debug, PartialEq)]
pub struct FormError {
    /// Squares that it explains.
    pub explained: f64,
    /// Squares that it leaves beyond the noise.
    pub left: f64,
    /// The same to first order about where it was found, with what all other blocks take of it; none where the fit fails.
    pub beside: Option<LeftBy>,
}

/// What an effect leaves to first order. Squares are whitened, over the noise.
#[derive(Clone, Debug, PartialEq)]
pub struct LeftBy {
    /// Squares beyond the noise.
    pub squares: f64,
    /// What each other block takes of them.
    pub taken: Vec<Taken>,
}

/// What one block takes of what an effect leaves.
#[derive(Clone, Debug, PartialEq)]
pub struct Taken {
    /// Its name.
    pub block: String,
    /// Its columns.
    pub columns: usize,
    /// Those of them that the data tell beside the effect.
    pub told: f64,
    /// Whitened squares over the noise.
    pub squares: f64,
}

/// Fits one effect, with all others taken out of the catalogue, and asks what of the rest the others would take. Causes that are in no
/// catalogue may be found beside it, as in every comparison. None where nothing was found: then nothing is learned of its form. Cost: a
/// diagnosis, and a fit for each other block.
///
/// # Errors
/// [`Insufficient`] where the recording cannot answer.
pub fn form_error(recording: &Recording, effect: &str) -> Result<Option<FormError>, Insufficient> {
    let prepared = prepare(recording)?;
    let others = effects::cards().map(|card| card.name);
    let alone = Options {
        without: others
            .filter(|other| *other != effect)
            .map(String::from)
            .collect(),
        ..Options::default()
    };
    Ok(decided(prepared, &alone, &unwatched, |prepared, found| {
        (found.answer.explained > 0.0).then(|| FormError {
            explained: found.answer.explained,
            left: found.answer.excess,
            beside: left_by(&with_all(prepared, &found), effect),
        })
    }))
}

/// All columns, linearised about what was found.
fn with_all<'a>(prepared: &'a Prepared, found: &Decided) -> Design<'a> {
    let inputs = &found.design.linearized.inputs;
    let told = DesignOptions {
        previous_inputs: Some(inputs),
        field: has_knots(inputs),
        ..DesignOptions::default()
    };
    design(prepared, &Options::default(), &found.design.point(), told)
}

/// What one effect leaves of a design, and what each other block takes of it.
fn left_by(design: &Design, effect: &str) -> Option<LeftBy> {
    let weighing = Weighing::before(design);
    let (problem, names) = (weighing.problem(), weighing.names());
    let own = names.iter().position(|name| name == effect)?;
    let of = |set: &[usize]| {
        let start = vec![0.0; set.len()];
        let fitted = fitted(problem.reduced, set, &start, problem.noise)?;
        let left = Left::of(problem.reduced, &fitted, problem.noise, problem.stated);
        Some((excess(&left), fitted.given.told))
    };
    let (squares, told_alone) = of(&[own])?;
    let others = (0..names.len()).filter(|other| *other != own);
    let taken = others.filter_map(|other| {
        let (left, told) = of(&[own, other])?;
        Some(Taken {
            block: names[other].clone(),
            columns: problem.reduced.blocks[other].len(),
            told: told - told_alone,
            squares: squares - left,
        })
    });
    Some(LeftBy {
        squares,
        taken: taken.collect(),
    })
}
