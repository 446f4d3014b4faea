//! What changes each pair's amplitude: the place on the platen as the air gap does, or time as a wandering pair does.
//!
//! A gap changes both channels alike and comes back with the place. An offset, a gain or an angle that wanders changes the
//! amplitude with the phase, and with time at one place: to first order of the amplitude by
//! `offset_s sin φ + offset_c cos φ - (gain/2) cos 2φ + (angle/2) sin 2φ`.

use super::LinearizedRecording;
use super::covariates::multiples;
use super::explained::Amplitudes;
use super::mesh::{GAP_MESHES_PITCHES, GAP_WAVE_SIZE, Mesh};
use super::sample::{PHASE_ORDERS, Sample};
use super::wander::{self, FLAW_SIZE, FLAWS, STRAIGHT_PARTS, WanderLengths, knot_weights};
use crate::algebra::penalized::{Penalty, Pieces, Row};
use crate::data::folds::folds;
use rayon::prelude::*;
use std::sync::Arc;

/// The same of one segment.
#[derive(Default)]
struct AmplitudeModel {
    by_place: Vec<f64>,
    pair_course: Vec<[f64; 4]>,
    mean_flaws: Vec<f64>,
}

/// Rows that are looked at: of more, every so many.
const MOST_ROWS: usize = 10_000;
/// Squares over the noise that a wander must explain, well past chance.
const WANDER_SQUARES: f64 = 100.0;
/// Share of what time and own phase leave that the place must explain.
const EXPLAINED_BY_PLACE: f64 = 0.5;
/// Share of what the place leaves that a wander must explain.
const EXPLAINED_BY_TIME: f64 = 0.7;
/// No shape is exact: what it leaves of the squares at least.
const SHAPE_ERROR_SHARE: f64 = 1.0e-3;

/// Columns of the flaws: what a unit of each adds to the amplitude.
fn by_flaw(sample: &Sample) -> [f64; 4] {
    let [_, one, two, ..] = sample.phase;
    [one.0, one.1, -0.5 * two.1, 0.5 * two.0]
}

/// Columns of a wander whose flaws are straight over some parts of the recording, of a field, and of a slow change of the whole with so
/// many knots.
#[derive(Clone, Copy, Default)]
struct AmplitudeShape<'a> {
    wander: Option<WanderLengths>,
    field: Option<&'a Mesh>,
    course: usize,
}

/// See [`PHASE_ORDERS`].
const PATTERN_COLUMNS: usize = 2 * PHASE_ORDERS;

/// Knots over the recording that are tried for a change of the whole: at most two a period of what changes within a tenth of it.
const CHANGE_KNOTS: [usize; 3] = [7, 12, 23];

impl<'a> AmplitudeShape<'a> {
    /// Columns before those of the field.
    fn first(&self) -> usize {
        self.wander.map_or(0, |_| wander::COLUMNS)
    }

    fn columns(&self) -> usize {
        let pattern = self.wander.map_or(0, |_| PATTERN_COLUMNS);
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
        entries.extend(course.map(|(knot, weight)| (next + knot, GAP_WAVE_SIZE * weight)));
        if self.wander.is_some() {
            // The pattern was told while the pair wandered: it may be wrong by about as much.
            let orders = sample
                .phase
                .iter()
                .flat_map(|(sine, cosine)| [sine, cosine]);
            let pattern = (next + self.course..).zip(orders);
            entries.extend(pattern.map(|(column, shape)| (column, FLAW_SIZE * shape)));
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

    /// Flaws that a fit found in the pattern.
    fn flaws_in_pattern(&self, coefficients: &[f64]) -> [f64; 4] {
        let pattern = &coefficients[self.columns() - PATTERN_COLUMNS..];
        let [_, one, two] = [0, 1, 2].map(|order| [pattern[2 * order], pattern[2 * order + 1]]);
        [one[0], one[1], -2.0 * two[1], 2.0 * two[0]].map(|flaw| FLAW_SIZE * flaw)
    }

    /// Amounts of the columns. Those of a flaw that does not wander are zero and not nearly so.
    fn coefficients(&self, samples: &[Sample], noise: f64) -> Option<Vec<f64>> {
        let mut coefficients = self
            .pieces(samples)
            .coefficients(noise, &self.penalties())?;
        let straights = self.wander.unwrap_or_default();
        for flaw in (0..FLAWS).filter(|f| self.wander.is_some() && straights[*f].is_none()) {
            let columns = coefficients[..wander::COLUMNS].iter_mut().skip(flaw);
            columns
                .step_by(FLAWS)
                .for_each(|coefficient| *coefficient = 0.0);
        }
        Some(coefficients)
    }

    fn penalties(&self) -> Vec<Penalty> {
        self.wander.map_or_else(Vec::new, wander::penalties)
    }

    /// The shape, and what it leaves on pieces that it has not seen.
    fn held_out(self, pieces: &Pieces, noise: f64) -> Option<(Self, f64)> {
        Some((self, pieces.held_out(noise, &self.penalties())?))
    }

    /// The same of the best wander beside this shape, of flaws that are all alike.
    fn wandering(self, all: &[Sample], noise: f64) -> Option<(Self, f64)> {
        let with = |straight: f64| Self {
            wander: Some([Some(straight); FLAWS]),
            ..self
        };
        let pieces = with(STRAIGHT_PARTS[0]).pieces(all);
        let tried = STRAIGHT_PARTS.into_iter();
        least(tried.filter_map(|straight| with(straight).held_out(&pieces, noise)))
    }

    /// The best wander beside this shape, of which each flaw is as straight as it is or does not wander at all: what stands still
    /// takes no part of what another does where a rest shows both alike.
    fn each_flaw(self, all: &[Sample], noise: f64) -> Option<Self> {
        let pieces = self.pieces(all);
        let (mut found, mut left) = self.held_out(&pieces, noise)?;
        for flaw in 0..FLAWS {
            let with = |straight: Option<f64>| {
                let mut straights = found.wander?;
                straights[flaw] = straight;
                let wander = Some(straights);
                Self { wander, ..found }.held_out(&pieces, noise)
            };
            let tried = STRAIGHT_PARTS.into_iter().map(Some).chain([None]);
            if let Some(better) = least(tried.filter_map(with)).filter(|t| t.1 < left) {
                (found, left) = better;
            }
        }
        Some(found)
    }
}

fn least<T>(list: impl Iterator<Item = (T, f64)>) -> Option<(T, f64)> {
    list.min_by(|a, b| a.1.total_cmp(&b.1))
}

/// The shape that leaves least on pieces that it has not seen, and what that is.
fn best<'a>(
    shapes: impl Iterator<Item = AmplitudeShape<'a>>,
    all: &[Sample],
    noise: f64,
) -> Option<(AmplitudeShape<'a>, f64)> {
    least(shapes.filter_map(|shape| shape.held_out(&shape.pieces(all), noise)))
}

impl LinearizedRecording<'_> {
    /// What explains the amplitudes.
    pub fn amplitudes_explained(&self) -> Amplitudes {
        let mut found = Amplitudes {
            by_place: Some(Default::default()),
            ..Amplitudes::default()
        };
        let folds = folds(&self.observations.stretch);
        let segments = [0, 1, 2, 3].into_par_iter();
        let segments = segments.filter(|s| self.scope.segments[*s]);
        let all: Vec<(usize, AmplitudeModel)> = segments
            .filter_map(|s| Some((s, self.explain_one(s, &folds)?)))
            .collect();
        for (segment, one) in all {
            found.pair_course[segment] = one.pair_course;
            found.mean_flaws[segment] = one.mean_flaws;
            if let Some(by_place) = &mut found.by_place {
                by_place[segment] = one.by_place;
            }
        }
        found
    }

    /// Mean flaws of the pairs that wander.
    pub fn mean_flaws(&self) -> [Vec<f64>; 4] {
        self.amplitudes.mean_flaws.clone()
    }

    /// Takes over what explains the amplitudes.
    pub fn take_amplitudes(&mut self, amplitudes: Arc<Amplitudes>) {
        let some = |list: &[Vec<f64>; 4]| std::array::from_fn(|s| !list[s].is_empty());
        self.inputs.amplitude_by_place = amplitudes.by_place.as_ref().map_or([true; 4], some);
        self.inputs.pair_wanders = std::array::from_fn(|s| !amplitudes.pair_course[s].is_empty());
        self.amplitudes = amplitudes;
    }

    /// A sample of a pair's amplitude, less a wander as far as it is known.
    fn sample(&self, segment: usize, i: usize, fold: u8, course: [f64; 4]) -> Option<Sample> {
        if self.ln_amplitude[segment].is_empty() {
            return None;
        }
        let (place_m, theta_rad) = self.place(segment, i)?;
        let left = self.without(segment, i, course);
        Some(Sample {
            place_m,
            theta_rad,
            progress: self.progress(i),
            phase: multiples::<PHASE_ORDERS>(left[0].atan2(left[1])),
            value: self.excess_of(segment, left),
            fold: usize::from(fold),
        })
    }

    fn explain_one(&self, segment: usize, folds: &[u8]) -> Option<AmplitudeModel> {
        let n = self.ln_amplitude[segment].len();
        let every = n.div_ceil(MOST_ROWS).max(1);
        let used = || (0..n).step_by(every).filter(|&i| self.mask[i]);
        let sample = |i: usize, course: [f64; 4]| self.sample(segment, i, folds[i], course);
        let all: Vec<Sample> = used().filter_map(|i| sample(i, [0.0; 4])).collect();
        if all.len() < MINIMUM_ROWS {
            return None;
        }
        let noise = self.amplitude_noise(segment);
        let meshes: Vec<Mesh> = GAP_MESHES_PITCHES
            .iter()
            .filter_map(|step| Mesh::over(&all, step * self.observations.pitch_m))
            .collect();
        let known = &self.normal.mean_flaws[segment];
        let (shape, noise) = chosen(&all, &meshes, noise, !known.is_empty())?;
        let mut coefficients = shape.coefficients(&all, noise)?;
        let mut found = AmplitudeModel::default();
        if shape.wander.is_some() {
            found.pair_course = vec![[0.0; 4]; n];
            self.add_wander(&shape, &coefficients, known, &mut found);
            // The columns are those of small flaws: once more about the flaws that are known now.
            let again = used().filter_map(|i| sample(i, found.pair_course[i]));
            coefficients = shape.coefficients(&again.collect::<Vec<_>>(), noise)?;
            self.add_wander(&shape, &coefficients, known, &mut found);
        }
        if let Some(mesh) = shape.field {
            let value = |s: Sample| {
                let entries = mesh.entries(&s, shape.first()).into_iter();
                entries.map(|(column, x)| x * coefficients[column]).sum()
            };
            let at = |i: usize| self.sample(segment, i, 0, [0.0; 4]).map_or(0.0, value);
            found.by_place = (0..n).map(at).collect();
        }
        Some(found)
    }

    /// Adds the wander that a fit found to the course that it was found about. Unless means of the flaws are known, those over this
    /// recording's time become them.
    fn add_wander(
        &self,
        shape: &AmplitudeShape<'_>,
        coefficients: &[f64],
        known: &[f64],
        to: &mut AmplitudeModel,
    ) {
        let pattern = shape.flaws_in_pattern(coefficients);
        to.mean_flaws = if known.is_empty() {
            let mean = wander::mean(coefficients).into_iter().zip(pattern);
            mean.map(|(mean, pattern)| mean + pattern).collect()
        } else {
            known.to_vec()
        };
        for (i, course) in to.pair_course.iter_mut().enumerate() {
            let flaws = wander::flaws(self.progress(i), coefficients);
            for (f, flaw) in course.iter_mut().enumerate() {
                *flaw += flaws[f] + pattern[f] - to.mean_flaws[f];
            }
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
            let course = self.amplitudes.pair_course[segment].get(i);
            let wander = course.map_or(0.0, |course| {
                let left = self.without(segment, i, *course);
                list[i] - self.excess_of(segment, left)
            });
            let field = place.and_then(|p| p.get(i)).copied().unwrap_or(0.0);
            (i, (list[i] - field - wander) / noise)
        };
        let used = (0..list.len()).filter(|i| self.mask[*i]);
        used.map(left).filter(|l| l.1.is_finite()).collect()
    }

    /// Part of the recording's time that has passed.
    fn progress(&self, i: usize) -> f64 {
        let t_s = &self.observations.t_s;
        (t_s[i] - t_s[0]) / self.inputs.duration_s.max(1e-12)
    }

    /// Place of a segment on the platen and the courier's angle.
    fn place(&self, segment: usize, i: usize) -> Option<([f64; 2], f64)> {
        let covariates = self.covariates(i);
        let place = covariates.place_m[segment];
        place
            .iter()
            .all(|p| p.is_finite())
            .then_some((place, covariates.theta_rad))
    }

    /// Mean square of the logarithm's noise: what is stated, or what neighbours on a smooth path show where that is more.
    fn amplitude_noise(&self, segment: usize) -> f64 {
        let o = self.observations;
        let list = &self.ln_amplitude[segment];
        let level = crate::algebra::statistics::rms(
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
        let shown =
            crate::algebra::statistics::median_and_deviation(&mut bends).map_or(0.0, |b| b.1);
        stated.max(shown).powi(2).max(1e-12)
    }
}

/// Fewer samples tell nothing of an amplitude's course.
const MINIMUM_ROWS: usize = 300;

/// What explains a pair's amplitude, field or wander or both, and the noise that it was fitted with. A pair that is known to wander does.
fn chosen<'a>(
    all: &[Sample],
    meshes: &'a [Mesh],
    noise: f64,
    wanders: bool,
) -> Option<(AmplitudeShape<'a>, f64)> {
    let count = all.len() as f64;
    let nothing = all.iter().map(|s| s.value * s.value).sum::<f64>() / count;
    let loose = noise.max(SHAPE_ERROR_SHARE * nothing);
    let fields = || {
        meshes.iter().map(|mesh| AmplitudeShape {
            field: Some(mesh),
            ..AmplitudeShape::default()
        })
    };
    let courses = CHANGE_KNOTS.into_iter().map(|course| AmplitudeShape {
        course,
        ..AmplitudeShape::default()
    });
    let (field, place) = best(fields(), all, loose)?;
    let (course, time) = best(courses, all, loose)?;
    let (_, wandering) = AmplitudeShape::default().wandering(all, loose)?;
    let beside = field.wandering(all, loose)?;
    let together = beside.1;
    // Beside a wander that explains nothing the field stands alone.
    let (before, after) = if wandering < nothing {
        (wandering, together)
    } else {
        (nothing, place)
    };
    let beyond_chance = |gain: f64| gain * count / noise > WANDER_SQUARES;
    let worth = |before: f64, after: f64, share: f64| {
        beyond_chance(before - after) && before - after > share * (before - noise)
    };
    let by_place = place < time && worth(before, after.min(place), EXPLAINED_BY_PLACE);
    let (timed, slow) = if by_place {
        beside
    } else {
        course.wandering(all, loose)?
    };
    let left = if by_place { place } else { time.min(nothing) };
    let by_time = wanders || worth(left, slow, EXPLAINED_BY_TIME);
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
        (_, true) => Some((timed.each_flaw(all, loose)?, loose)),
    }
}
