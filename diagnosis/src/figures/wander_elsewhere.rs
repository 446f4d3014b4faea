//! What is left on another recording of a pair that wanders and whose counts do not show how, or of a beacon whose vibration swells: the model is that of all effects
//! together, and the course of either is another one there.

use crate::inference::residuals::Residuals;
use crate::linearization::recording::ROWS;
use crate::linearization::relinearized::RelinearizedFit;
use crate::transfer::model::is_time_bound;
use effects::sensor::Covariates;

/// Derived from the golden section, whose multiples fill a unit evenly, however many there are.
const GOLDEN_SECTION: f64 = 0.618_033_988_749_895;

/// Residuals of short pieces and of folds that a fit has not seen, with the course that the wander had at another time in the
/// place of what is known of it: each sample at one, all of them evenly over the recording's time. A recording may take most of
/// its samples in a small part of its time, in which a wander hardly moves: what they have in common is not what another
/// recording has. Of a vibration, what swells is left. `None` where nothing does either.
pub(super) fn left(relinearized: &RelinearizedFit) -> Option<[Residuals; 2]> {
    let mut blocks = relinearized.columns.blocks.iter();
    let wander = blocks.find(|b| is_time_bound(&b.name, &relinearized.linearized.inputs));
    let wander = wander.map_or(0..0, |b| b.columns.clone());
    let swell = crate::spectra::resonance::amplitude_modulation(relinearized).time_bound;
    if wander.is_empty() && swell.is_empty() {
        return None;
    }
    let other = other_times(relinearized);
    let change = |i: usize| {
        let rows = relinearized.linearized.rows(i);
        let there = relinearized.linearized.covariates(other[i]);
        let covariates = Covariates {
            progress: there.progress,
            ..relinearized.linearized.covariates(i)
        };
        let mut out = [0.0; ROWS];
        let here = relinearized.linearized.covariates(i);
        let wandering = wander.clone().map(|c| (c, &covariates));
        for (c, covariates) in wandering.chain(swell.iter().map(|c| (*c, &here))) {
            let response = rows.response(&relinearized.columns.regressors[c], covariates);
            let added = out.iter_mut().zip(response);
            added.for_each(|(out, response)| *out -= relinearized.coefficient(c) * response);
        }
        out
    };
    let left = relinearized.left_out()?;
    Some([left, relinearized.residuals()].map(|r| r.changed(&relinearized.linearized, change)))
}

/// Residuals `left` with the beats of a vibration in them, as they are where another recording's are others; `None` without beats.
pub(super) fn without_beats(relinearized: &RelinearizedFit, left: &Residuals) -> Option<Residuals> {
    let beats = crate::spectra::resonance::amplitude_modulation(relinearized).beats;
    let change = |i: usize| {
        let (rows, covariates) = (
            relinearized.linearized.rows(i),
            relinearized.linearized.covariates(i),
        );
        let mut out = [0.0; ROWS];
        for c in &beats {
            let response = rows.response(&relinearized.columns.regressors[*c], &covariates);
            let added = out.iter_mut().zip(response);
            added.for_each(|(out, response)| *out -= relinearized.coefficient(*c) * response);
        }
        out
    };
    (!beats.is_empty()).then(|| left.changed(&relinearized.linearized, change))
}

/// For each sample one at another time.
fn other_times(relinearized: &RelinearizedFit) -> Vec<usize> {
    let t_s = &relinearized.linearized.observations.t_s;
    let mut order: Vec<usize> = (0..t_s.len()).collect();
    order.sort_by(|a, b| t_s[*a].total_cmp(&t_s[*b]));
    let (Some(&first), Some(&last)) = (order.first(), order.last()) else {
        return Vec::new();
    };
    let at = |k: usize| {
        let time = t_s[first] + (k as f64 * GOLDEN_SECTION).fract() * (t_s[last] - t_s[first]);
        let after = order
            .partition_point(|i| t_s[*i] < time)
            .min(order.len() - 1);
        let before = after.saturating_sub(1);
        let nearer = [before, after].map(|k| (t_s[order[k]] - time).abs());
        order[if nearer[0] < nearer[1] { before } else { after }]
    };
    (0..t_s.len()).map(at).collect()
}
