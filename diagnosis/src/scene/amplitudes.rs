//! What changes each pair's amplitude: the place on the platen as the air gap does, or time as a wandering pair does.
//!
//! A gap changes both channels alike and comes back with the place. An offset, a gain or an angle that wanders changes the
//! amplitude with the phase, and with time at one place: to first order of the amplitude by
//! `offset_s sin φ + offset_c cos φ - (gain/2) cos 2φ + (angle/2) sin 2φ`.

use super::Scene;
use super::mesh::{MESHES, Mesh, WAVE};
use super::moment::multiples;
use super::wander::{self, FLAW, STRAIGHT, knot_weights};
use crate::gram::folds;
use crate::smooth::{Bond, Pieces, Row};
use rayon::prelude::*;
use std::sync::Arc;

/// What place and time explain of the amplitudes, by segment and sample; empty where nothing is explained.
#[derive(Clone, Debug, Default)]
pub struct Amplitudes {
    /// Part of the logarithm that the place explains; `None` where that was not looked for.
    pub by_place: Option<[Vec<f64>; 4]>,
    /// Offset of sine and cosine, gain and angle, less their means over the time.
    pub pair_course: [Vec<[f64; 4]>; 4],
}

/// The same of one segment.
#[derive(Default)]
struct Explained {
    by_place: Vec<f64>,
    pair_course: Vec<[f64; 4]>,
}

/// Rows that are looked at: of more, every so many.
const MOST_ROWS: usize = 10_000;
/// Squares over the noise that a wander must explain, well past chance.
const BEYOND_CHANCE: f64 = 100.0;
/// Share of what time and own phase leave that the place must explain.
const BY_PLACE: f64 = 0.5;
/// Share of what the place leaves that a wander must explain.
const BY_TIME: f64 = 0.7;
/// No shape is exact: what it leaves of the squares at least.
const INEXACT: f64 = 1.0e-3;

/// One sample of a segment's amplitude.
pub(super) struct Sample {
    pub(super) place_m: [f64; 2],
    pub(super) theta_rad: f64,
    progress: f64,
    /// Sine and cosine of the phase and its multiples.
    phase: [(f64, f64); ORDERS],
    value: f64,
    fold: usize,
}

/// Columns of the flaws: what a unit of each adds to the amplitude.
fn by_flaw(sample: &Sample) -> [f64; 4] {
    flaw_shapes(sample.phase[1], sample.phase[2])
}

/// The same from sine and cosine of the phase and of twice the phase.
fn flaw_shapes(one: (f64, f64), two: (f64, f64)) -> [f64; 4] {
    [one.0, one.1, -0.5 * two.1, 0.5 * two.0]
}

/// Columns of a wander that is straight over some part of the recording, of a field, and of a slow change of the whole with so
/// many knots.
#[derive(Clone, Copy, Default)]
struct Shape<'a> {
    wander: Option<f64>,
    field: Option<&'a Mesh>,
    course: usize,
}

/// Orders of the phase from zero on, and columns of their sines and cosines.
const ORDERS: usize = 9;
/// See [`ORDERS`].
const PATTERN: usize = 2 * ORDERS;

/// Knots over the recording that are tried for a change of the whole: at most two a period of what changes within a tenth of it.
const KNOTS: [usize; 3] = [7, 12, 23];

impl<'a> Shape<'a> {
    /// Columns before those of the field.
    fn first(&self) -> usize {
        self.wander.map_or(0, |_| wander::COLUMNS)
    }

    fn columns(&self) -> usize {
        let pattern = self.wander.map_or(0, |_| PATTERN);
        self.first() + self.field.map_or(0, Mesh::columns) + self.course + pattern
    }

    fn row(&self, sample: &Sample) -> Row {
        let mut entries = Vec::new();
        if self.wander.is_some() {
            entries.extend(wander::entries(sample.progress, by_flaw(sample)));
        }
        let mut next = self.first();
        if let Some(mesh) = self.field {
            entries.extend(mesh.entries(sample, next));
            next += mesh.columns();
        }
        let course = knot_weights(self.course, sample.progress);
        entries.extend(course.map(|(knot, weight)| (next + knot, WAVE * weight)));
        if self.wander.is_some() {
            // The pattern was told while the pair wandered: it may be wrong by about as much.
            let orders = sample
                .phase
                .iter()
                .flat_map(|(sine, cosine)| [sine, cosine]);
            let pattern = (next + self.course..).zip(orders);
            entries.extend(pattern.map(|(column, shape)| (column, FLAW * shape)));
        }
        Row {
            entries,
            value: sample.value,
            fold: sample.fold,
        }
    }

    fn pieces(&self, samples: &[Sample]) -> Pieces {
        Pieces::new(self.columns(), samples.iter().map(|s| self.row(s)))
    }

    fn bonds(&self) -> Vec<Bond> {
        self.wander.map_or_else(Vec::new, wander::bonds)
    }

    /// The shape, and what it leaves on pieces that it has not seen.
    fn held_out(self, pieces: &Pieces, noise: f64) -> Option<(Self, f64)> {
        Some((self, pieces.held_out(noise, &self.bonds())?))
    }

    /// The same of the best wander beside this shape.
    fn wandering(self, all: &[Sample], noise: f64) -> Option<(Self, f64)> {
        let with = |straight: f64| Self {
            wander: Some(straight),
            ..self
        };
        let pieces = with(STRAIGHT[0]).pieces(all);
        let tried = STRAIGHT.into_iter();
        least(tried.filter_map(|straight| with(straight).held_out(&pieces, noise)))
    }
}

fn least<T>(list: impl Iterator<Item = (T, f64)>) -> Option<(T, f64)> {
    list.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The shape that leaves least on pieces that it has not seen, and what that is.
fn best<'a>(
    shapes: impl Iterator<Item = Shape<'a>>,
    all: &[Sample],
    noise: f64,
) -> Option<(Shape<'a>, f64)> {
    least(shapes.filter_map(|shape| shape.held_out(&shape.pieces(all), noise)))
}

impl Scene<'_> {
    /// What explains the amplitudes.
    pub fn amplitudes_explained(&self) -> Amplitudes {
        let mut found = Amplitudes {
            by_place: Some(Default::default()),
            ..Amplitudes::default()
        };
        let folds = folds(&self.observations.stretch);
        let segments = [0, 1, 2, 3].into_par_iter();
        let segments = segments.filter(|s| self.scope.segments[*s]);
        let all: Vec<(usize, Explained)> = segments
            .filter_map(|s| Some((s, self.explain_one(s, &folds)?)))
            .collect();
        for (segment, one) in all {
            found.pair_course[segment] = one.pair_course;
            if let Some(by_place) = &mut found.by_place {
                by_place[segment] = one.by_place;
            }
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
            phase: multiples::<ORDERS>(sine.atan2(cosine)),
            value,
            fold: usize::from(fold),
        })
    }

    fn explain_one(&self, segment: usize, folds: &[u8]) -> Option<Explained> {
        let n = self.ln_amplitude[segment].len();
        let every = n.div_ceil(MOST_ROWS).max(1);
        let all: Vec<Sample> = (0..n)
            .step_by(every)
            .filter(|&i| self.keep[i])
            .filter_map(|i| self.sample(segment, i, folds[i]))
            .collect();
        if all.len() < MINIMUM_ROWS {
            return None;
        }
        let noise = self.amplitude_noise(segment);
        let meshes: Vec<Mesh> = MESHES
            .iter()
            .filter_map(|step| Mesh::over(&all, step * self.observations.pitch_m))
            .collect();
        let (shape, noise) = chosen(&all, &meshes, noise)?;
        let amounts = shape.pieces(&all).amounts(noise, &shape.bonds())?;
        let mut found = Explained::default();
        if let Some(mesh) = shape.field {
            let value = |s: Sample| {
                let entries = mesh.entries(&s, shape.first()).into_iter();
                entries.map(|(column, x)| x * amounts[column]).sum()
            };
            let at = |i: usize| self.sample(segment, i, 0).map_or(0.0, value);
            found.by_place = (0..n).map(at).collect();
        }
        if shape.wander.is_some() {
            let mean = wander::mean(&amounts);
            let course = |i: usize| {
                let flaws = wander::flaws(self.progress(i), &amounts);
                std::array::from_fn(|f| flaws[f] - mean[f])
            };
            found.pair_course = (0..n).map(course).collect();
        }
        Some(found)
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
    let courses = KNOTS.into_iter().map(|course| Shape {
        course,
        ..Shape::default()
    });
    let (field, place) = best(fields(), all, loose)?;
    let (course, time) = best(courses, all, loose)?;
    let (_, wandering) = Shape::default().wandering(all, loose)?;
    let beside = field.wandering(all, loose)?;
    let together = beside.1;
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
    let (timed, slow) = if by_place {
        beside
    } else {
        course.wandering(all, loose)?
    };
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
