//! Amounts that are arbitrary from one recording to the next, as columns: zeros of tooth counts and angle, and what a segment brought
//! along from a way that is not recorded.

use crate::data::channel_names::CHANNEL_NAMES;
use crate::linearization::recording::LinearizedRecording;
use crate::linearization::unknown_angle;
use courier_signal::equations::ANGLE_SIGN;
use effects::identity::Identity;
use effects::sensor::Regressor;

/// Samples that what was brought along is kept for: of fewer, it would be most of what they tell.
const LONG: f64 = 10.0;
/// Prior size of what is arbitrary, m: three hundred pitches, so that it holds nothing.
const FREE_M: f64 = 0.3;

/// Mounts that have drifted by some micrometres have turned the sensor: against the coordination sensor by as much as that over the
/// span, and at another temperature by what nothing told.
pub(super) fn zero_of_the_angle() -> Regressor {
    Regressor::readings("zero of the angle", "m", FREE_M, |_, out| {
        for (out, sign) in out.iter_mut().zip(ANGLE_SIGN.map(f64::from)) {
            *out += sign;
        }
    })
}

/// What is arbitrary from recording to recording.
pub(super) fn zeros(linearized: &LinearizedRecording) -> Vec<Regressor> {
    let mut list = Vec::new();
    if linearized.scope.reference {
        for s in (0..4).filter(|s| linearized.scope.segments[*s]) {
            list.push(Regressor::reading(
                format!("zero of segment {}", s + 1),
                "m",
                FREE_M,
                s,
                |_| 1.0,
            ));
        }
        // How the courier turned where nothing tells it is its own on each recording as well.
        list.extend(unknown_angle::regressors(linearized));
        return list;
    }
    for channel in 0..if linearized.scope.beacon { 3 } else { 1 } {
        list.push(Regressor::channel(
            format!("zero of {}", CHANNEL_NAMES[channel]),
            "m",
            FREE_M,
            channel,
            |_| 1.0,
        ));
    }
    list
}

/// What the segments brought along to each stretch but the first, which the effect has itself, where they keep it for long.
pub(super) fn between_stretches(linearized: &LinearizedRecording) -> Vec<Regressor> {
    let stretch = &linearized.observations.stretch;
    let mut kept = vec![[0.0; 4]; stretch.last().map_or(0, |last| last + 1)];
    for (s, before) in linearized.motion.before.iter().enumerate() {
        let samples = before
            .iter()
            .enumerate()
            .filter(|(i, _)| linearized.mask[*i]);
        samples.for_each(|(i, before)| kept[stretch[i]][s] += before);
    }
    let kept = kept.iter().enumerate().skip(1);
    let long = kept.flat_map(|(k, kept)| {
        let segments = (0..4).filter(|s| kept[*s] > LONG);
        segments.map(move |s| (s, k))
    });
    let mut remembering = effects::EFFECTS.iter().filter(|e| e.card().remembers);
    let effect = remembering.next();
    long.filter_map(|(s, k)| effect?.brought_along(s, k))
        .collect()
}

/// True for what a segment brought along to a stretch from a way that is not recorded: another recording has another.
pub(super) fn is_brought_along(regressor: &Regressor) -> bool {
    regressor.identity == Some(Identity::BroughtAlong)
}
