//! Clips: in the counts where there are any, else in the shape of the error against a reference.

mod bend;
mod counts;
mod figure;
mod rails;
mod reference;

use crate::data::observations::Observations;
use crate::linearization::baseline::Baseline;
use crate::linearization::point::LinearizationPoint;
use crate::linearization::recording::LinearizedRecording;
use crate::linearization::relinearized::RelinearizedFit;
use effects::Detection;
use effects::sensor::Clip;
pub use figure::{CutFigure, Figure};
pub use rails::Rails;
use rails::WHOLE;

/// Each segment's pair that is cut by hard rails, which its readings pile up at.
#[must_use]
pub fn cut_figures(observations: &Observations) -> [Option<CutFigure>; 4] {
    counts::cut_figures(observations)
}

/// Whether a pair's sine and cosine stand at a hard rail: such a reading tells nothing of its channel but that the wave lies beyond.
#[must_use]
pub fn at_rails(observations: &Observations, segment: usize, i: usize) -> [bool; 2] {
    let cut = observations.cut_figures[segment];
    let pair = observations.pair_counts[segment].get(i);
    let noise = observations.pair_noise_counts;
    cut.zip(pair).map_or([false; 2], |(cut, pair)| {
        counts::stand_at(&cut.rails_counts, *pair, noise)
    })
}

/// Whether neither channel of a pair stands at a hard rail: only such a reading tells the pair's amplitude.
#[must_use]
pub fn tells_amplitude(observations: &Observations, segment: usize, i: usize) -> bool {
    at_rails(observations, segment, i) == [false; 2]
}

/// The clips of the segments' pairs that their counts show, where they were logged and do.
#[must_use]
pub fn in_counts(observations: &Observations) -> [Option<Clip>; 4] {
    counts::find(observations)
}

/// The clip of a segment of which no counts were logged, if its error against a reference has that shape.
#[must_use]
pub fn against_reference(linearized: &LinearizedRecording, segment: usize) -> Option<Clip> {
    let counts = !linearized.observations.pair_counts[segment].is_empty();
    if counts || !linearized.scope.reference || !linearized.scope.segments[segment] {
        return None;
    }
    reference::find(linearized, segment)
}

/// Equation (3)'s orders, m, of segments with a soft clip that the counts show: fitted about it, and not about what it makes of them.
#[must_use]
pub fn beneath(
    observations: &Observations,
    baseline: &Baseline,
    mask: &[bool],
    clips: &[Option<Clip>; 4],
) -> [Option<[f64; 8]>; 4] {
    let soft = clips.map(|clip| clip.is_some_and(|c| c.knee >= Clip::HARD));
    if soft == [false; 4] {
        return [None; 4];
    }
    let mut linearized = LinearizedRecording::new(observations, baseline.clone(), mask.to_vec());
    linearized.inputs.clip = *clips;
    let point = LinearizationPoint {
        baseline: baseline.clone(),
        ..LinearizationPoint::default()
    };
    let point = RelinearizedFit::new(
        &linearized,
        point,
        &[effects::name_of(Detection::ByRails).into()],
    )
    .point;
    let orders = |s: usize| std::array::from_fn(|j| point.baseline.k_m[s][1 + j]);
    std::array::from_fn(|s| soft[s].then(|| orders(s)))
}

/// Noise of a pair within which a reading is at a corner, in standard deviations. Derived from the normal tail: one reading in
/// 16,000 that stands there is beyond.
const AT_CORNER: f64 = 4.0;

/// Share of a rail to which the corners tell it. A prior: poses fall unevenly over the turn, which moves the share of readings at the corners, and
/// the rail that it tells, by some hundredths.
const RAIL_KNOWN_TO: f64 = 0.05;

/// Samples at which both channels of a pair stand at hard rails, or as near to them as these are known. Rails below the amplitude over the root of two leave such corners: all
/// phases between the two rails read alike, and nothing tells them apart.
#[must_use]
pub fn stuck(observations: &Observations, clips: &[Option<Clip>; 4]) -> Vec<bool> {
    let mut stuck = vec![false; observations.len()];
    for (pairs, clip) in observations.pair_counts.iter().zip(clips) {
        let Some(clip) = clip.filter(|c| c.knee < Clip::HARD) else {
            continue;
        };
        let [sines, cosines] = clip.rails;
        let all = sines.iter().flat_map(|s| cosines.map(|c| [*s, c]));
        let corners: Vec<f64> = all
            .filter(|[s, c]| s.hypot(*c) < WHOLE)
            .map(|[s, c]| s.atan2(c))
            .collect();
        for (stuck, [sine, cosine]) in stuck.iter_mut().zip(pairs) {
            // Where one channel is a share of its rail below it, the phase is half of that share beside the corner.
            let by_noise = AT_CORNER * observations.pair_noise_counts / sine.hypot(*cosine);
            let near = by_noise.max(0.5 * RAIL_KNOWN_TO);
            let phase = sine.atan2(*cosine);
            *stuck |= corners.iter().any(|c| (phase - c).abs() < near);
        }
    }
    stuck
}
