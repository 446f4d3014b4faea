//! What is left on another recording of a pair that wanders and whose counts do not show how, or of a beacon whose vibration swells: the model is that of all effects
//! together, and the course of either is another one there.

use crate::inference::residuals::Residuals;
use crate::linearization::relinearized::RelinearizedFit;
use crate::linearization::scene::ROWS;
use crate::transfer::model::is_of_its_time;
use effects::sensor::Covariates;

/// Golden section: its multiples fill a unit evenly, however many there are.
const GOLDEN: f64 = 0.618_033_988_749_895;

/// Residuals of short pieces and of folds that a fit has not seen, with the course that the wander had at another time in the
/// place of what is known of it: each sample at one, all of them evenly over the recording's time. A recording may take most of
/// its samples in a small part of its time, in which a wander hardly moves: what they have in common is not what another
/// recording has. Of a vibration, what swells is left. `None` where nothing does either.
pub(super) fn left(fine: &RelinearizedFit) -> Option<[Residuals; 2]> {
    let mut blocks = fine.columns.blocks.iter();
    let wander = blocks.find(|b| is_of_its_time(&b.name, &fine.scene.inputs));
    let wander = wander.map_or(0..0, |b| b.columns.clone());
    let swell = crate::spectra::resonance::breath(fine).of_its_time;
    if wander.is_empty() && swell.is_empty() {
        return None;
    }
    let other = other_times(fine);
    let change = |i: usize| {
        let rows = fine.scene.rows(i);
        let there = fine.scene.covariates(other[i]);
        let covariates = Covariates {
            progress: there.progress,
            ..fine.scene.covariates(i)
        };
        let mut out = [0.0; ROWS];
        let here = fine.scene.covariates(i);
        let wandering = wander.clone().map(|c| (c, &covariates));
        for (c, covariates) in wandering.chain(swell.iter().map(|c| (*c, &here))) {
            let response = rows.response(&fine.columns.regressors[c], covariates);
            let added = out.iter_mut().zip(response);
            added.for_each(|(out, response)| *out -= fine.amount(c) * response);
        }
        out
    };
    let left = fine.left_out()?;
    Some([left, fine.residuals()].map(|r| r.changed(&fine.scene, change)))
}

/// Residuals `left` with the beats of a vibration in them, as they are where another recording's are others; `None` without beats.
pub(super) fn without_beats(fine: &RelinearizedFit, left: &Residuals) -> Option<Residuals> {
    let beats = crate::spectra::resonance::breath(fine).beats;
    let change = |i: usize| {
        let (rows, covariates) = (fine.scene.rows(i), fine.scene.covariates(i));
        let mut out = [0.0; ROWS];
        for c in &beats {
            let response = rows.response(&fine.columns.regressors[*c], &covariates);
            let added = out.iter_mut().zip(response);
            added.for_each(|(out, response)| *out -= fine.amount(*c) * response);
        }
        out
    };
    (!beats.is_empty()).then(|| left.changed(&fine.scene, change))
}

/// For each sample one at another time.
fn other_times(fine: &RelinearizedFit) -> Vec<usize> {
    let t_s = &fine.scene.observations.t_s;
    let mut order: Vec<usize> = (0..t_s.len()).collect();
    order.sort_by(|a, b| t_s[*a].total_cmp(&t_s[*b]));
    let (Some(&first), Some(&last)) = (order.first(), order.last()) else {
        return Vec::new();
    };
    let at = |k: usize| {
        let time = t_s[first] + (k as f64 * GOLDEN).fract() * (t_s[last] - t_s[first]);
        let after = order
            .partition_point(|i| t_s[*i] < time)
            .min(order.len() - 1);
        let before = after.saturating_sub(1);
        let nearer = [before, after].map(|k| (t_s[order[k]] - time).abs());
        order[if nearer[0] < nearer[1] { before } else { after }]
    };
    (0..t_s.len()).map(at).collect()
}
