//! Knots of a field over the platen: those that the recording passes often enough, or the rectangle that it stays within.

use crate::linearization::recording::LinearizedRecording;
use crate::transfer::support::places_m;
use rayon::prelude::*;
use std::collections::{BTreeMap, BTreeSet};
use tooth_field::{Lattice, Teeth};

/// Weight of samples that a knot must carry to be judged. Derived from the least squares that follow: with three readings of its
/// own a value is told to 0.58 of their noise, beside its prior.
const WEIGHT: f64 = 3.0;
/// Most knots of all fields. A bound on the work: beyond, the mesh gets coarser, and what it then misses is left and told.
const MOST_KNOTS: usize = 700;
/// Most values of all segments: each reaches far, so that the cost is that of all columns at every sample. A bound on the work:
/// beyond, the mesh gets coarser, and at last teeth are asked for in its place.
const MOST_KNOT_VALUES: usize = 200;
/// Pitches from value to value, the finest that is not too many. Where the teeth lie beside the marks that places are told from is
/// not known, nor how many an aperture holds, and a field bends where a tooth comes in or goes out: a mesh of half the width
/// misses half as much of a bend between two values.
const KNOT_STEPS_PITCHES: [f64; 3] = [0.25, 0.5, 1.0];
/// Pitches from knot to knot where each segment has a field of its own, in the order in which they are tried. A prior: the finest is a knot
/// for each tooth, and the others were compared on two couriers with fields of five to seven teeth. From 1.5 to 2 pitches the logarithm of
/// the evidence fell by 20 on one (courier 50 of seed 6059) and by 81 on the other (2 of 6063).
const SEGMENT_MESHES_PITCHES: [f64; 3] = [1.0, 1.5, 2.0];
/// The same where each channel has a field over the courier's centre, as if the courier did not turn: tried where no mesh of the segments has
/// few enough knots. A prior, by the first of those couriers: the logarithm of the evidence fell by 270 from the segments' coarsest mesh to
/// this finest one, by 284 to 2 pitches and by 1,240 to 3. A knot for each tooth has four times the knots of the finest one, and was less
/// likely by 192.
const CHANNEL_MESHES_PITCHES: [f64; 5] = [1.5, 2.0, 3.0, 4.0, 6.0];
/// The same where one segment reads single teeth beside a reference, derived from a north and a south pole being half a pole pair each, with
/// four knots for the wave of each. A coarser mesh than a pitch tells no tooth of a row.
const SINGLE_TEETH_PITCHES: [f64; 4] = [0.125, 0.25, 0.5, 1.0];
/// Fewest knots of all fields. A prior: a courier that went over fewer hardly moved.
const FEWEST_KNOTS: usize = 8;

/// Sets the mesh and the knots: a rectangle of values for each segment where that is few enough; else the first mesh whose knots
/// are; none where the courier hardly moves.
pub fn lay(linearized: &mut LinearizedRecording) {
    linearized.inputs.field_by_segment = true;
    let single = linearized.inputs.forms.single_teeth.is_some();
    linearized.inputs.field_by_value = !single;
    let mut passed = places(linearized);
    for pitches in KNOT_STEPS_PITCHES.into_iter().filter(|_| !single) {
        let step_m = pitches * linearized.observations.pitch_m;
        let corners = passed
            .each_ref()
            .map(|places_m| rectangle(places_m, step_m));
        let count: usize = corners.iter().flatten().map(values).sum();
        if (1..=MOST_KNOT_VALUES).contains(&count) {
            linearized.inputs.knot_step_m = step_m;
            linearized.inputs.knots = corners.map(|c| c.map_or(Vec::new(), Vec::from));
            return;
        }
    }
    linearized.inputs.field_by_value = false;
    let (of_segments, of_channels): (&[f64], &[f64]) = if single {
        (&SINGLE_TEETH_PITCHES, &[])
    } else {
        (&SEGMENT_MESHES_PITCHES, &CHANNEL_MESHES_PITCHES)
    };
    // Beside a reference a channel is a segment: there what was tried of the segments is not tried again.
    let reference = linearized.inputs.reference;
    let not_tried = |pitches: &&f64| !(reference && of_segments.contains(pitches));
    let of_channels = of_channels.iter().filter(not_tried);
    let of_segments = of_segments.iter().map(|pitches| (true, *pitches));
    let meshes = of_segments.chain(of_channels.map(|pitches| (false, *pitches)));
    for (by_segment, pitches) in meshes {
        if by_segment != linearized.inputs.field_by_segment {
            linearized.inputs.field_by_segment = by_segment;
            passed = places(linearized);
        }
        let step_m = pitches * linearized.observations.pitch_m;
        let list = at(linearized, &passed, step_m);
        let count: usize = list.iter().map(Vec::len).sum();
        crate::trace::log(&format!(
            "{count} knots, {pitches} pitches apart, a field of each segment: {by_segment}"
        ));
        if count < FEWEST_KNOTS {
            break;
        }
        if count <= MOST_KNOTS {
            (linearized.inputs.knot_step_m, linearized.inputs.knots) = (step_m, list);
            return;
        }
    }
    (linearized.inputs.knot_step_m, linearized.inputs.knots) = Default::default();
}

/// Places of each field, m, at the samples in use.
fn places(linearized: &LinearizedRecording) -> [Vec<[f64; 2]>; 4] {
    let mut out: [Vec<[f64; 2]>; 4] = Default::default();
    for i in (0..linearized.len()).filter(|&i| linearized.mask[i]) {
        for (s, place_m) in places_m(linearized, i) {
            out[s].push(place_m);
        }
    }
    out
}

/// Two opposite corners of the mesh about some places; none without any.
fn rectangle(places_m: &[[f64; 2]], step_m: f64) -> Option<[[i32; 2]; 2]> {
    let low = |place_m: &[f64; 2]| place_m.map(|p| (p / step_m).floor() as i32);
    let corners = places_m.iter().map(low).map(|low| [low, low]);
    let [from, to] = corners.reduce(|[from, to], [low, _]| {
        [
            [0, 1].map(|d| from[d].min(low[d])),
            [0, 1].map(|d| to[d].max(low[d])),
        ]
    })?;
    Some([from, to.map(|t| t.saturating_add(1))])
}

/// Values on a rectangle.
fn values([from, to]: &[[i32; 2]; 2]) -> usize {
    let side = |d: usize| to[d].saturating_sub(from[d]).saturating_add(1) as usize;
    side(0).saturating_mul(side(1))
}

/// Knots of a mesh that each field's places are read by often enough.
fn at(
    linearized: &LinearizedRecording,
    places_m: &[Vec<[f64; 2]>; 4],
    step_m: f64,
) -> [Vec<[i32; 2]>; 4] {
    let pitch_m = linearized.observations.pitch_m;
    let step_pitches = step_m / pitch_m;
    let lattice = Lattice {
        kernel: linearized.inputs.forms.field_kernel(step_pitches),
        step_pitches: [step_pitches; 2],
    };
    let row = linearized.inputs.forms.single_teeth.is_some();
    let mut out: [Vec<[i32; 2]>; 4] = Default::default();
    out.par_iter_mut()
        .zip(places_m)
        .for_each(|(knots, places_m)| {
            let places = places_m.iter().map(|place_m| place_m.map(|p| p / pitch_m));
            let passed = lattice.passed(places).into_iter();
            let often = passed.filter(|(knot, weight)| *weight > WEIGHT && !(row && knot[1] != 0));
            *knots = often.map(|(knot, _)| knot).collect();
        });
    out
}

/// Most teeth and lines: the cost is that of all unknowns together. A bound on the work: beyond, teeth are not asked for one by
/// one and the mesh stays, with what it leaves.
const MOST_TEETH: usize = 2400;
/// Share of a reading that all samples together must give to a tooth, for it to be asked for. Derived from sizes: a tooth that is
/// off by 3 µm is then seen by 0.06 µm in all, a fifth of the noise floor of 0.3 µm.
const SEEN: f64 = 0.02;

/// Lists the teeth and lines under the segments' apertures. False where they are too many, or none.
pub fn list_teeth(linearized: &LinearizedRecording, teeth: &mut Teeth) -> bool {
    let pitch_m = linearized.observations.pitch_m;
    let mut posts: [BTreeMap<[i32; 2], f64>; 2] = Default::default();
    let mut lines: [BTreeSet<i32>; 2] = Default::default();
    let lattice = teeth.lattice();
    for i in (0..linearized.len()).filter(|&i| linearized.mask[i]) {
        let covariates = linearized.covariates(i);
        for s in (0..4).filter(|s| linearized.scope.segments[*s]) {
            let place = covariates.place_m[s].map(|p| p / pitch_m);
            lines[s % 2].extend(lattice.lines(place).map(|(line, _)| line));
            for (tooth, weight) in lattice.nodes(place) {
                *posts[s % 2].entry(tooth).or_default() += weight;
            }
        }
    }
    teeth.posts = posts.map(|all| {
        let seen = all.into_iter().filter(|(_, share)| *share > SEEN);
        seen.map(|(tooth, _)| tooth).collect()
    });
    teeth.lines = lines.map(|all| all.into_iter().collect());
    if teeth.deviation_m[1] <= 0.0 {
        teeth.lines = Default::default();
    }
    let posts = teeth.posts.iter().map(Vec::len).sum::<usize>();
    let count = posts + teeth.lines.iter().map(Vec::len).sum::<usize>();
    crate::trace::log(&format!(
        "{count} teeth and lines, steps {:.2?}",
        teeth.step_pitches
    ));
    (1..=MOST_TEETH).contains(&count)
}
