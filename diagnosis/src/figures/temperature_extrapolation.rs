//! Whether the bend of a drift with temperature goes on beyond the temperatures that were measured. A body that warms through late
//! looks bent as well, and no bend of its own is there elsewhere: what the milder temperatures of the recording foretell of its
//! coldest and of its warmest ones, with the bend carried on or not, decides.

use crate::algebra::normal_equations::Sums;
use crate::linearization::relinearized::RelinearizedFit;
use effects::Card;
use effects::sensor::Regressor;
use nalgebra::DVector;

/// Share of the range of temperatures that is taken for its coldest end, and for its warmest.
/// By definition: its outer quarters.
const EXTREME_RANGE_SHARE: f64 = 0.25;
/// Fewest residuals at an end that decide anything. Derived from their mean: of fifty it is known to 0.14 of the noise.
const FEWEST_AT_AN_END: usize = 50;

/// Parts of the range of temperatures: coldest, in the middle, warmest. By definition of what is asked: an end by the two others.
const TEMPERATURE_CLASSES: usize = 3;

/// True if the bend foretells the coldest and the warmest samples better than the drift's mean slope does.
pub(super) fn goes_on(relinearized: &RelinearizedFit) -> bool {
    let block = relinearized
        .columns
        .blocks
        .iter()
        .find(|b| effects::has(&b.name, Card::follows_temperature));
    let (Some(block), Some(left)) = (block, relinearized.left_out()) else {
        return false;
    };
    let [coldest, warmest] = relinearized.linearized.inputs.warmths_k;
    let end = EXTREME_RANGE_SHARE * (warmest - coldest);
    let inner = [coldest + end, warmest - end];
    let part_of = |i: usize| {
        let warmth_k = relinearized.linearized.covariates(i).warmth_k;
        usize::from(warmth_k > inner[0]) + usize::from(warmth_k > inner[1])
    };
    let mut residuals = [0; TEMPERATURE_CLASSES];
    left.sample.iter().for_each(|i| residuals[part_of(*i)] += 1);
    let drift: Vec<usize> = block.columns.clone().collect();
    let prediction = |goes_on: bool| {
        let ends = [(0, [inner[0], warmest]), (2, [coldest, inner[1]])];
        let selected = ends
            .iter()
            .filter(|(part, _)| residuals[*part] >= FEWEST_AT_AN_END);
        let left = selected.map(|(part, known)| {
            let columns = columns(relinearized, *known, goes_on);
            left_at(relinearized, &drift, &columns, *part, part_of)
        });
        left.sum::<f64>()
    };
    residuals[1] >= FEWEST_AT_AN_END && prediction(true) < prediction(false)
}

/// The baseline's columns and the drift's, where only some temperatures are known.
fn columns(relinearized: &RelinearizedFit, known: [f64; 2], goes_on: bool) -> Vec<Regressor> {
    let mut inputs = relinearized.linearized.inputs.clone();
    inputs.warmths_k = known;
    inputs.bend_goes_on = goes_on;
    let sides = effects::sensor_sides();
    let side = sides.iter().find(|side| side.card().follows_temperature());
    let drift = side.map_or_else(Vec::new, |side| side.regressors(&inputs));
    let mut columns =
        crate::linearization::calibrate::baseline_columns(&relinearized.linearized).regressors;
    columns.extend(drift);
    columns
}

/// Whitened squares that are left at one end of the temperatures, by amounts of the rest. `columns`: the baseline's, then those of
/// the drift, which are `drift` in the model; what else the model knows stays.
fn left_at(
    relinearized: &RelinearizedFit,
    drift: &[usize],
    columns: &[Regressor],
    end: usize,
    part_of: impl Fn(usize) -> usize,
) -> f64 {
    let Some(left) = relinearized.left_out() else {
        return f64::INFINITY;
    };
    let first = columns.len() - drift.len();
    let known: Vec<usize> = (0..first).chain(drift.iter().copied()).collect();
    let mut parts = [0; 2].map(|_| Sums::new(columns.len(), 1.0));
    let mut start = 0;
    while start < left.sample.len() {
        let i = left.sample[start];
        let (rows, covariates) = (
            relinearized.linearized.rows(i),
            relinearized.linearized.covariates(i),
        );
        let here: Vec<_> = columns
            .iter()
            .map(|c| rows.response(c, &covariates))
            .collect();
        let model = |c: usize| rows.response(&relinearized.columns.regressors[c], &covariates);
        let there: Vec<_> = known.iter().map(|c| model(*c)).collect();
        let part = &mut parts[usize::from(part_of(i) == end)];
        for row in 0..rows.count {
            let k = start + row;
            let weight = 1.0 / left.noise_m[k].max(1e-12);
            let scaled = known.iter().zip(&here);
            let scaled = scaled.map(|(c, r)| weight * relinearized.gram.scale[*c] * r[row]);
            let regressor = DVector::from_iterator(columns.len(), scaled);
            let added = known.iter().zip(&there);
            let added: f64 = added
                .map(|(c, r)| relinearized.coefficient(*c) * r[row])
                .sum();
            part.add(&regressor, weight * (left.value_m[k] - added));
        }
        start += rows.count.max(1);
    }
    let all: Vec<usize> = (0..columns.len()).collect();
    let [unexplained_fraction, end] = &parts;
    end.left_with(&all, unexplained_fraction.coefficients(&all))
}
