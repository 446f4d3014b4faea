//! All that is compared on a recording: columns of the baseline, of the effects and of free shapes, and their products.

use crate::data::clip;
use crate::data::folds::folds;
use crate::data::prepare::Prepared;
use crate::design::coordinate_basis::coordinate_bases;
use crate::design::errors_in_variables::ErrorsInVariables;
use crate::design::gram::{Columns, Gram};
use crate::design::thinned::thinned;
use crate::design::unlisted::unlisted;
use crate::inference::cross_validation::CrossValidation;
use crate::inference::residuals::Residuals;
use crate::linearization::calibrate::baseline_columns;
use crate::linearization::point::LinearizationPoint;
use crate::linearization::recording::LinearizedRecording;
use crate::noise::simulated::{Floor, floor};
use crate::spectra::flicker::flicker_hz;
use crate::spectra::lines::{add_lines, lines_of};
use effects::Detection;
use effects::sensor::{BasisInputs, READINGS, SingleTeeth};
use std::sync::Arc;

/// What a caller may change.
#[derive(Clone, Debug, Default)]
pub struct Options {
    /// Effects taken out of the catalogue.
    pub without: Vec<String>,
    /// The answer tells the likeliest sets as well. Cost: twenty cross-validations.
    pub explain: bool,
}

/// A block of the comparison.
#[derive(Clone, Debug, PartialEq)]
pub enum BlockKind {
    /// A catalogued effect.
    Effect(String),
    /// The shapes of an effect that may not be named: they tell where a gap lies, and nothing else.
    WithheldEffect(String),
    /// Free shapes over a coordinate.
    Coordinate(String),
}

/// Everything that the judgement needs.
pub struct Design<'a> {
    /// The linearised recording.
    pub linearized: LinearizedRecording<'a>,
    /// Columns: baseline, effects, places.
    pub columns: Columns,
    /// What each block after the baseline is.
    pub kinds: Vec<BlockKind>,
    /// Their products.
    pub gram: Gram,
    /// Noise that they carry.
    pub errors_in_variables: ErrorsInVariables,
    /// Fold of each sample.
    pub folds: Vec<u8>,
    /// Simulator's scatter.
    pub floor: Floor,
}

impl Design<'_> {
    /// What it is linearised about.
    pub fn point(&self) -> LinearizationPoint {
        let linearized = &self.linearized;
        LinearizationPoint {
            baseline: linearized.baseline.clone(),
            displacement: linearized.displacement.clone(),
            noise: self.measured_noise(),
        }
    }

    /// Noise of each reading over the stated one that it is whitened by, where it is not the stated one.
    pub fn measured_noise(&self) -> Option<[f64; READINGS]> {
        (!self.linearized.is_by_stated_noise()).then_some(self.linearized.noise)
    }

    /// For the comparison of sets of blocks.
    pub fn cross_validation(&self) -> CrossValidation<'_> {
        CrossValidation::new(&self.gram, &self.columns, &self.errors_in_variables)
    }

    /// Blocks of the catalogue.
    pub fn effects(&self) -> Vec<usize> {
        (1..self.columns.blocks.len())
            .filter(|b| matches!(self.kinds[b - 1], BlockKind::Effect(_)))
            .collect()
    }

    /// Held-out residuals of the baseline with some blocks.
    pub fn residuals(&self, blocks: &[usize]) -> Residuals {
        let list = self.list(blocks);
        Residuals::new(
            &self.linearized,
            &self.columns,
            &self.gram,
            &self.folds,
            &list,
        )
    }

    /// Columns of the baseline and some blocks.
    pub fn list(&self, blocks: &[usize]) -> Vec<usize> {
        let mut list: Vec<usize> = self.columns.blocks[0].columns.clone().collect();
        for &b in blocks {
            list.extend(self.columns.blocks[b].columns.clone());
        }
        list
    }
}

/// What to look at besides the catalogue and the places.
#[derive(Clone, Copy, Default)]
pub struct DesignOptions<'o, 'a> {
    /// Residuals of the best model so far, in which lines of the spectrum are looked for.
    pub line_residuals: Option<&'o Residuals>,
    /// Waves over the coordination sensor's deflection are looked for in those residuals as well.
    pub search_deflection_waves: bool,
    /// Basis inputs whose lines and whose phase of free harmonics are kept.
    pub previous_inputs: Option<&'o BasisInputs>,
    /// A field over the platen is judged.
    pub field: bool,
    /// The field is of teeth that are read one at a time.
    pub single_teeth: Option<SingleTeeth>,
    /// Only the blocks named here are compared: a field has hundreds of unknowns.
    pub only: Option<&'o [String]>,
    /// Finer shapes are laid over the coordinates, and nothing else.
    pub fine_basis: bool,
    /// Causes that are in no catalogue compete as well: where it is decided on the answer.
    pub unlisted: bool,
    /// No more than so many samples are compared, spread over the recording; all where none is told.
    pub samples: Option<usize>,
    /// The recording in another comparison: where that is about the same point, it is not linearised again. Cost alone.
    pub like: Option<&'o LinearizedRecording<'a>>,
}

/// Builds all columns and their products.
pub fn assemble<'a>(
    prepared: &'a Prepared,
    options: &Options,
    point: &LinearizationPoint,
    design_options: DesignOptions<'_, 'a>,
) -> Design<'a> {
    let LinearizationPoint {
        baseline,
        displacement,
        ..
    } = point;
    let mut linearized = match design_options.like {
        Some(like) if like.is_about(baseline, displacement) => like.anew(prepared.mask.clone()),
        _ => LinearizedRecording::new(
            &prepared.observations,
            baseline.clone(),
            prepared.mask.clone(),
        )
        .moved(baseline.clone(), displacement.clone()),
    };
    linearized.noise = point.noise.unwrap_or([1.0; READINGS]);
    linearized.take_amplitudes(Arc::clone(&prepared.amplitudes));
    for segment in 0..4 {
        let other = || clip::against_reference(&linearized, segment);
        linearized.inputs.clip[segment] = prepared.clips[segment].or_else(other);
    }
    linearized.inputs.beneath = prepared.beneath;
    let (mut beacon, mut segments) =
        design_options
            .previous_inputs
            .map_or(Default::default(), |inputs| {
                let lines = (&inputs.beacon_lines_hz, &inputs.segment_lines_hz);
                (lines.0.clone(), lines.1.clone())
            });
    if let Some(residuals) = design_options.line_residuals {
        // What is explained by lines that are known leaves none: they stay.
        let more = lines_of(&linearized, residuals);
        add_lines(&mut beacon, more.0);
        add_lines(&mut segments, more.1);
    }
    (
        linearized.inputs.beacon_lines_hz,
        linearized.inputs.segment_lines_hz,
    ) = (beacon, segments);
    if let Some(inputs) = design_options.previous_inputs {
        linearized.inputs.pair_lines_hz = inputs.pair_lines_hz.clone();
        linearized.inputs.flicker_hz = inputs.flicker_hz.clone();
        linearized.inputs.deflection_waves = inputs.deflection_waves.clone();
    }
    let residuals = design_options
        .line_residuals
        .filter(|_| design_options.search_deflection_waves);
    if let Some(residuals) = residuals.filter(|_| linearized.inputs.deflection_waves.is_empty()) {
        linearized.inputs.deflection_waves =
            crate::spectra::deflection_waves::waves(&linearized, residuals);
    }
    if let Some(residuals) = design_options.line_residuals {
        let flickers = flicker_hz(&linearized, residuals);
        add_lines(&mut linearized.inputs.flicker_hz, flickers);
        linearized.inputs.pair_lines_hz =
            std::array::from_fn(|s| crate::spectra::hum::hum_hz(&linearized, s));
    }
    linearized.inputs.unmodified = design_options
        .previous_inputs
        .is_some_and(|inputs| inputs.unmodified);
    linearized.inputs.forms = design_options
        .previous_inputs
        .map_or_else(Default::default, |inputs| inputs.forms);
    if let Some(inputs) = design_options.previous_inputs {
        linearized.inputs.gap_told = inputs.gap_told;
        linearized.inputs.growth_told = inputs.growth_told;
    }
    linearized.inputs.lines_wind = design_options
        .previous_inputs
        .is_some_and(|inputs| inputs.lines_wind);
    if design_options.single_teeth.is_some() {
        linearized.inputs.forms.single_teeth = design_options.single_teeth;
    }
    if design_options.field {
        crate::design::knots::lay(&mut linearized);
    }
    if let Some(most) = design_options.samples {
        linearized.mask = thinned(&linearized.mask, most);
    }
    let listed = |name: &str| {
        design_options
            .only
            .is_none_or(|list| list.iter().any(|k| k == name))
    };
    let wanted =
        |name: &str| listed(name) || design_options.field && effects::is(name, Detection::AsField);
    let (mut columns, mut kinds) = if design_options.fine_basis {
        finer_columns(&linearized)
    } else {
        all_columns(&linearized, options, &wanted)
    };
    if design_options.unlisted {
        for (name, regressors) in unlisted(&linearized.inputs) {
            let kind = BlockKind::Coordinate(name.into());
            add(&mut columns, &mut kinds, kind, regressors);
        }
    }
    let folds = folds(&prepared.observations.stretch);
    let gram = Gram::new(&linearized, &columns, &folds);
    let errors_in_variables = ErrorsInVariables::new(&linearized, &columns, &gram.scale);
    let floor = floor(&linearized);
    Design {
        linearized,
        columns,
        kinds,
        gram,
        errors_in_variables,
        folds,
        floor,
    }
}

fn all_columns(
    linearized: &LinearizedRecording,
    options: &Options,
    wanted: &dyn Fn(&str) -> bool,
) -> (Columns, Vec<BlockKind>) {
    let mut columns = baseline_columns(linearized);
    let mut kinds = Vec::new();
    let sides = effects::sensor_sides();
    for effect in sides.iter().filter(|e| wanted(e.name())) {
        // An effect that is taken out of the catalogue loses its name; the coordinate that it acts on stays to be looked at.
        let taken_out = options.without.iter().any(|w| w == effect.name());
        let kind = if taken_out {
            BlockKind::WithheldEffect(effect.name().into())
        } else {
            BlockKind::Effect(effect.name().into())
        };
        let regressors = effect.regressors(&linearized.inputs);
        add(&mut columns, &mut kinds, kind, regressors);
    }
    for place in coordinate_bases(&linearized.inputs)
        .into_iter()
        .filter(|p| wanted(&p.coordinate))
    {
        let kind = BlockKind::Coordinate(place.coordinate);
        add(&mut columns, &mut kinds, kind, place.regressors);
    }
    (columns, kinds)
}

fn finer_columns(linearized: &LinearizedRecording) -> (Columns, Vec<BlockKind>) {
    let mut columns = baseline_columns(linearized);
    let mut kinds = Vec::new();
    for place in crate::design::fine_basis::fine_basis(linearized) {
        let kind = BlockKind::Coordinate(place.coordinate);
        add(&mut columns, &mut kinds, kind, place.regressors);
    }
    (columns, kinds)
}

fn add(
    columns: &mut Columns,
    kinds: &mut Vec<BlockKind>,
    kind: BlockKind,
    regressors: Vec<effects::sensor::Regressor>,
) {
    if !regressors.is_empty() {
        let name = match &kind {
            BlockKind::Effect(name)
            | BlockKind::Coordinate(name)
            | BlockKind::WithheldEffect(name) => name.clone(),
        };
        columns.push(name, regressors);
        kinds.push(kind);
    }
}
