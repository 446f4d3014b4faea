//! What changes each pair's amplitude: the place on the platen as the air gap does, or time as a wandering pair does.
//!
//! A gap changes both channels alike and comes back with the place. An offset, a gain or an angle that wanders changes the
//! amplitude with the phase, and with time at one place: to first order of the amplitude by
//! `offset_s sin φ + offset_c cos φ - (gain/2) cos 2φ + (angle/2) sin 2φ`.

use super::Scene;
use super::moment::multiples;
use crate::gram::folds;
use crate::smooth::{Fit, Row, fit};
use effects::quadrature_drift::sensor_side::spline;
use std::collections::HashMap;
use std::sync::Arc;

/// What place and time explain of the amplitudes, by segment and sample; empty where nothing is explained.
#[derive(Clone, Debug, Default)]
pub struct Amplitudes {
    /// Part of the logarithm that the place explains; `None` where that was not looked for.
    pub by_place: Option<[Vec<f64>; 4]>,
    /// Offset of sine and cosine, gain and angle, less their means.
    pub pair_course: [Vec<[f64; 4]>; 4],
}

/// Rows that are looked at: of more, every so many.
const MOST_ROWS: usize = 10_000;
/// Squares over the noise that a wander must explain, well past chance.
const BEYOND_CHANCE: f64 = 100.0;
/// Share of what time and own phase leave that the place must explain.
const BY_PLACE: f64 = 0.5;
/// Share of what the place leaves that a wander must explain.
const BY_TIME: f64 = 0.7;
/// Expected size of a gap's logarithm by tilt and bow, by waves, and of a pair's flaws.
const GAP: f64 = 0.3;
/// See [`GAP`].
const WAVE: f64 = 0.1;
/// See [`GAP`].
const FLAW: f64 = 0.01;
/// No shape is exact: what it leaves of the squares at least.
const INEXACT: f64 = 1.0e-3;

/// Mesh of cubic B-splines over the places that were passed, beside a tilt and a bow.
#[derive(Default)]
struct Mesh {
    middle_m: [f64; 2],
    /// Distance of the nodes; without a mesh zero.
    step_m: f64,
    nodes: HashMap<[i32; 2], usize>,
}

/// Meshes that are tried, pitches: a gap is smooth over teeth. Zero: none.
const MESHES: [f64; 4] = [0.0, 6.0, 3.0, 1.5];
/// Most nodes of a mesh.
const MOST_NODES: usize = 240;
/// Terms of a tilt, a bow, the angle and its square: a courier that turns tilts.
const LOW_TERMS: usize = 8;
/// Lengths and angles that those are counted in, m and rad.
const LENGTH_M: f64 = 5.0e-3;
/// See [`LENGTH_M`].
const ANGLE_RAD: f64 = 0.02;

impl Mesh {
    /// None where there would be too many nodes.
    fn over(samples: &[Sample], step_m: f64) -> Option<Self> {
        let count = samples.len() as f64;
        let middle_m = [0, 1].map(|k| samples.iter().map(|s| s.place_m[k]).sum::<f64>() / count);
        let mut nodes = HashMap::new();
        for sample in samples.iter().filter(|_| step_m > 0.0) {
            for (node, _) in around(sample.place_m, step_m) {
                let next = nodes.len();
                nodes.entry(node).or_insert(next);
            }
            if nodes.len() > MOST_NODES {
                return None;
            }
        }
        Some(Self {
            middle_m,
            step_m,
            nodes,
        })
    }

    fn columns(&self) -> usize {
        LOW_TERMS + self.nodes.len()
    }

    /// Columns and their entries at a sample, counted from `first`.
    fn entries(&self, sample: &Sample, first: usize) -> Vec<(usize, f64)> {
        let [x, y] = [0, 1].map(|k| (sample.place_m[k] - self.middle_m[k]) / LENGTH_M);
        let turned = sample.theta_rad / ANGLE_RAD;
        let low = [1.0, x, y, x * x, x * y, y * y, turned, turned * turned];
        let mut list: Vec<(usize, f64)> = (first..).zip(low.map(|l| GAP * l)).collect();
        if self.step_m > 0.0 {
            let known =
                |(node, weight)| Some((first + LOW_TERMS + self.nodes.get(&node)?, WAVE * weight));
            list.extend(around(sample.place_m, self.step_m).filter_map(known));
        }
        list
    }
}

/// The sixteen nodes about a place with their weights.
fn around(place_m: [f64; 2], step_m: f64) -> impl Iterator<Item = ([i32; 2], f64)> {
    let at = place_m.map(|p| p / step_m);
    let low = at.map(|a| a.floor() as i32 - 1);
    (0..16).map(move |k| {
        let node = [low[0] + k % 4, low[1] + k / 4];
        (
            node,
            spline(at[0] - f64::from(node[0])) * spline(at[1] - f64::from(node[1])),
        )
    })
}

/// One sample of a segment's amplitude.
struct Sample {
    place_m: [f64; 2],
    theta_rad: f64,
    progress: f64,
    /// Sine and cosine of the phase, and of twice the phase.
    phase: [(f64, f64); 3],
    value: f64,
    fold: usize,
}

/// Columns of the flaws: what a unit of each adds to the amplitude.
fn by_flaw(sample: &Sample) -> [f64; 4] {
    let [_, one, two] = sample.phase;
    flaw_shapes(one, two)
}

/// The same from sine and cosine of the phase and of twice the phase.
fn flaw_shapes(one: (f64, f64), two: (f64, f64)) -> [f64; 4] {
    [one.0, one.1, -0.5 * two.1, 0.5 * two.0]
}

/// Columns of a wander with so many knots, of a field, and of a slow change of the whole with so many knots.
#[derive(Clone, Copy, Default)]
struct Shape<'a> {
    wander: usize,
    field: Option<&'a Mesh>,
    course: usize,
}

/// Knots over the recording that are tried: at most two a period of what changes within a tenth of it.
const KNOTS: [usize; 3] = [7, 12, 23];

/// Weight of one of `knots` at a part of the recording: uniform cubic B-splines that reach one knot past both ends.
fn knot_weights(knots: usize, progress: f64) -> impl Iterator<Item = (usize, f64)> {
    let at = move |k: usize| {
        (
            k,
            spline(progress * (knots as f64 - 3.0) - (k as f64 - 1.0)),
        )
    };
    (0..knots).map(at).filter(|k| k.1 > 0.0)
}

impl Shape<'_> {
    fn columns(&self) -> usize {
        4 * self.wander + self.field.map_or(0, Mesh::columns) + self.course
    }

    fn row(&self, sample: &Sample) -> Row {
        let mut entries = Vec::new();
        let flaws = by_flaw(sample);
        for (knot, weight) in knot_weights(self.wander, sample.progress) {
            entries.extend((0..4).map(|f| (4 * knot + f, FLAW * weight * flaws[f])));
        }
        let mut next = 4 * self.wander;
        if let Some(mesh) = self.field {
            entries.extend(mesh.entries(sample, next));
            next += mesh.columns();
        }
        let course = knot_weights(self.course, sample.progress);
        entries.extend(course.map(|(knot, weight)| (next + knot, WAVE * weight)));
        Row {
            entries,
            value: sample.value,
            fold: sample.fold,
        }
    }

    fn fit(&self, samples: &[Sample], noise: f64) -> Option<Fit> {
        let rows: Vec<Row> = samples.iter().map(|s| self.row(s)).collect();
        fit(self.columns(), &rows, noise)
    }
}

/// The shape that leaves least on pieces that it has not seen, and what that is.
fn best<'a>(
    shapes: impl Iterator<Item = Shape<'a>>,
    all: &[Sample],
    noise: f64,
) -> Option<(Shape<'a>, f64)> {
    shapes
        .filter_map(|shape| Some((shape, shape.fit(all, noise)?.held_out)))
        .min_by(|a, b| a.1.total_cmp(&b.1))
}

impl Scene<'_> {
    /// What explains the amplitudes.
    pub fn amplitudes_explained(&self) -> Amplitudes {
        let mut found = Amplitudes {
            by_place: Some(Default::default()),
            ..Amplitudes::default()
        };
        let folds = folds(&self.observations.stretch);
        for segment in (0..4).filter(|s| self.scope.segments[*s]) {
            self.explain_one(segment, &folds, &mut found);
        }
        found
    }

    /// Takes over what explains the amplitudes.
    pub fn take_amplitudes(&mut self, amplitudes: Arc<Amplitudes>) {
        let some = |list: &[Vec<f64>; 4]| std::array::from_fn(|s| !list[s].is_empty());
        self.survey.amplitude_by_place = amplitudes.by_place.as_ref().map_or([true; 4], some);
        self.survey.pair_wanders = std::array::from_fn(|s| !amplitudes.pair_course[s].is_empty());
        self.amplitudes = amplitudes;
    }

    fn sample(&self, segment: usize, i: usize, fold: u8) -> Option<Sample> {
        let o = self.observations;
        let value = *self.ln_amplitude[segment].get(i)?;
        let [sine, cosine] = *o.pair_counts[segment].get(i)?;
        let (place_m, theta_rad) = self.place(segment, i)?;
        Some(Sample {
            place_m,
            theta_rad,
            progress: self.progress(i),
            phase: multiples::<3>(sine.atan2(cosine)),
            value,
            fold: usize::from(fold),
        })
    }

    fn explain_one(&self, segment: usize, folds: &[u8], found: &mut Amplitudes) {
        let n = self.ln_amplitude[segment].len();
        let every = n.div_ceil(MOST_ROWS).max(1);
        let all: Vec<Sample> = (0..n)
            .step_by(every)
            .filter(|&i| self.keep[i])
            .filter_map(|i| self.sample(segment, i, folds[i]))
            .collect();
        if all.len() < MINIMUM_ROWS {
            return;
        }
        let noise = self.amplitude_noise(segment);
        let meshes: Vec<Mesh> = MESHES
            .iter()
            .filter_map(|step| Mesh::over(&all, step * self.observations.pitch_m))
            .collect();
        let Some((shape, noise)) = chosen(&all, &meshes, noise) else {
            return;
        };
        let Some(fit) = shape.fit(&all, noise) else {
            return;
        };
        if let (Some(mesh), Some(by_place)) = (shape.field, &mut found.by_place) {
            let value = |s: Sample| {
                let entries = mesh.entries(&s, 4 * shape.wander).into_iter();
                entries.map(|(column, x)| x * fit.amounts[column]).sum()
            };
            let at = |i: usize| self.sample(segment, i, 0).map_or(0.0, value);
            by_place[segment] = (0..n).map(at).collect();
        }
        if shape.wander > 0 {
            let flaw = |i: usize, f: usize| {
                let knots = knot_weights(shape.wander, self.progress(i));
                FLAW * knots
                    .map(|(k, weight)| weight * fit.amounts[4 * k + f])
                    .sum::<f64>()
            };
            let course = |i: usize| std::array::from_fn(|f| flaw(i, f));
            found.pair_course[segment] = (0..n).map(course).collect();
        }
    }

    /// What neither place nor a slow wander explains of a segment's amplitude, over its noise, by sample.
    pub fn amplitude_left(&self, segment: usize) -> Vec<(usize, f64)> {
        let list = &self.ln_amplitude[segment];
        if list.is_empty() {
            return Vec::new();
        }
        let noise = self.amplitude_noise(segment).sqrt();
        let place = self.amplitudes.by_place.as_ref().map(|p| &p[segment]);
        let left = |i: usize| {
            let [sine, cosine] = self.observations.pair_counts[segment][i];
            let [_, one, two] = multiples::<3>(sine.atan2(cosine));
            let flaws = flaw_shapes(one, two);
            let course = self.amplitudes.pair_course[segment].get(i);
            let wander = course.map_or(0.0, |c| c.iter().zip(flaws).map(|(c, f)| c * f).sum());
            let field = place.and_then(|p| p.get(i)).copied().unwrap_or(0.0);
            (i, (list[i] - field - wander) / noise)
        };
        let used = (0..list.len()).filter(|i| self.keep[*i]);
        used.map(left).filter(|l| l.1.is_finite()).collect()
    }

    /// Part of the recording's time that has passed.
    fn progress(&self, i: usize) -> f64 {
        let t_s = &self.observations.t_s;
        (t_s[i] - t_s[0]) / self.survey.duration_s.max(1e-12)
    }

    /// Place of a segment on the platen and the courier's angle.
    fn place(&self, segment: usize, i: usize) -> Option<([f64; 2], f64)> {
        let moment = self.moment(i);
        let place = moment.place_m[segment];
        place
            .iter()
            .all(|p| p.is_finite())
            .then_some((place, moment.theta_rad))
    }

    /// Mean square of the logarithm's noise: what is stated, or what neighbours on a smooth path show where that is more.
    fn amplitude_noise(&self, segment: usize) -> f64 {
        let o = self.observations;
        let list = &self.ln_amplitude[segment];
        let level = crate::statistics::rms(
            o.amplitude_counts[segment]
                .iter()
                .copied()
                .filter(|a| a.is_finite()),
        );
        let stated = o.pair_noise_counts / level.max(1e-9);
        let near = |i: &usize| o.stretch[i - 1] == o.stretch[i + 1];
        let mut bends: Vec<f64> = (1..list.len().saturating_sub(1))
            .filter(near)
            .map(|i| (list[i - 1] - 2.0 * list[i] + list[i + 1]) / 6f64.sqrt())
            .collect();
        let shown = crate::statistics::median_and_deviation(&mut bends).map_or(0.0, |b| b.1);
        stated.max(shown).powi(2).max(1e-12)
    }
}

/// Fewer samples tell nothing of an amplitude's course.
const MINIMUM_ROWS: usize = 300;

/// What explains a pair's amplitude, field or wander or both, and the noise that it was fitted with.
fn chosen<'a>(all: &[Sample], meshes: &'a [Mesh], noise: f64) -> Option<(Shape<'a>, f64)> {
    let count = all.len() as f64;
    let nothing = all.iter().map(|s| s.value * s.value).sum::<f64>() / count;
    let loose = noise.max(INEXACT * nothing);
    let fields = || {
        meshes.iter().map(|mesh| Shape {
            field: Some(mesh),
            ..Shape::default()
        })
    };
    let wanders = |with: Shape<'a>| {
        KNOTS
            .into_iter()
            .map(move |wander| Shape { wander, ..with })
    };
    let courses = KNOTS.into_iter().map(|course| Shape {
        course,
        ..Shape::default()
    });
    let (field, place) = best(fields(), all, loose)?;
    let (course, time) = best(courses, all, loose)?;
    let (_, wandering) = best(wanders(Shape::default()), all, loose)?;
    let (_, together) = best(wanders(field), all, loose)?;
    // Beside a wander that explains nothing the field stands alone.
    let (before, after) = if wandering < nothing {
        (wandering, together)
    } else {
        (nothing, place)
    };
    let beyond_chance = |gain: f64| gain * count / noise > BEYOND_CHANCE;
    let worth = |before: f64, after: f64, share: f64| {
        beyond_chance(before - after) && before - after > share * (before - noise)
    };
    let by_place = place < time && worth(before, after.min(place), BY_PLACE);
    let (timed, slow) = best(wanders(if by_place { field } else { course }), all, loose)?;
    let left = if by_place { place } else { time.min(nothing) };
    let by_time = worth(left, slow, BY_TIME);
    crate::trace::log(&format!(
        "amplitude over its noise: {:.2}; place {:.2}, time {:.2}, wander {:.2}, both {:.2}, {:.2}; gap {by_place}, wander {by_time}",
        nothing / noise,
        place / noise,
        time / noise,
        wandering / noise,
        together / noise,
        slow / noise
    ));
    match (by_place, by_time) {
        (false, false) => None,
        (true, false) => Some((field, loose)),
        (_, true) => Some((timed, loose)),
    }
}
