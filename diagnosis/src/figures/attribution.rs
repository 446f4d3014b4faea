//! Which channel shows most of what lies over a coordinate, and which segments make it.

use crate::design::assembly::Design;
use crate::inference::cross_validation::CrossValidation;
use crate::inference::residuals::Residuals;
use effects::sensor::{CHANNELS, Regressor};

/// A segment is told if without its shapes this share of what all of them take is lost.
const OWN_SHAPES_SHARE: f64 = 0.1;
/// Samples that tell which segments a shape moves. Cost alone: a shape moves a segment at nearly all samples or at none.
const SAMPLES_LOOKED_AT: usize = 50;

/// Whose a share is.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Attribution {
    /// Channel whose residual shrinks most.
    pub channel: Option<usize>,
    /// Segments that cannot be left out; none where others do as well, or where all are needed.
    pub segments: [bool; 4],
}

/// Owners of what `columns` take beyond `known` (the baseline's among them), whose held-out residuals are `before`. Cost: one pass over the
/// samples, and up to four solutions.
pub(super) fn attribution(
    design: &Design,
    validation: &mut CrossValidation,
    (known, before): (&[usize], &Residuals),
    columns: &[usize],
) -> Attribution {
    let all = [known, columns].concat();
    let after = Residuals::new(
        &design.linearized,
        &design.columns,
        &design.gram,
        &design.folds,
        &all,
    );
    Attribution {
        channel: shrunk_most(before, &after),
        segments: needed(design, validation, known, columns),
    }
}

/// The channel that loses the most squares, over its noise.
fn shrunk_most(before: &Residuals, after: &Residuals) -> Option<usize> {
    let squares = |of: &Residuals| {
        let mut sum = [0.0; CHANNELS];
        for (k, channel) in of.channel.iter().enumerate() {
            sum[*channel] += (of.value_m[k] / of.noise_m[k].max(1e-12)).powi(2);
        }
        sum
    };
    let (before, after) = (squares(before), squares(after));
    let gains = before.iter().zip(&after).map(|(b, a)| b - a).enumerate();
    let best = gains.max_by(|a, b| a.1.total_cmp(&b.1));
    best.filter(|(_, gain)| *gain > 0.0)
        .map(|(channel, _)| channel)
}

fn needed(
    design: &Design,
    validation: &mut CrossValidation,
    known: &[usize],
    columns: &[usize],
) -> [bool; 4] {
    let moved: Vec<[bool; 4]> = columns
        .iter()
        .map(|c| moved(design, &design.columns.regressors[*c]))
        .collect();
    let mut squares = |mask: &dyn Fn(usize) -> bool| {
        let some = (0..columns.len()).filter(|k| mask(*k)).map(|k| columns[k]);
        let list: Vec<usize> = known.iter().copied().chain(some).collect();
        validation.score_columns(&list).squares
    };
    let (none, all) = (squares(&|_| false), squares(&|_| true));
    let mut lost = |s: usize| {
        if moved.iter().all(|m| m[s]) {
            none - all
        } else if moved.iter().any(|m| m[s]) {
            squares(&|k| !moved[k][s]) - all
        } else {
            0.0
        }
    };
    let segments = [0, 1, 2, 3].map(|s| lost(s) > OWN_SHAPES_SHARE * (none - all).max(0.0));
    if segments == design.linearized.inputs.segments {
        [false; 4]
    } else {
        segments
    }
}

/// Segments whose reading a shape moves at some moment.
fn moved(design: &Design, regressor: &Regressor) -> [bool; 4] {
    let mut out = [false; 4];
    if !regressor.action.is_on_readings() {
        return out;
    }
    let step = (design.linearized.len() / SAMPLES_LOOKED_AT).max(1);
    for i in (0..design.linearized.len()).step_by(step) {
        let covariates = design.linearized.covariates(i);
        if regressor.acts(&covariates) {
            let readings = regressor.action.on_readings(&covariates);
            out.iter_mut()
                .zip(readings)
                .for_each(|(o, r)| *o |= r != 0.0);
        }
    }
    out
}
