//! What changes each pair's amplitude: the place on the platen as the air gap does, or time as a wandering pair does.
//!
//! A gap changes both channels alike and comes back with the place. An offset, a gain or an angle that wanders changes the
//! amplitude with the phase, and with time at one place: to first order of the amplitude by
//! `offset_s sin φ + offset_c cos φ - (gain/2) cos 2φ + (angle/2) sin 2φ`.

use super::LinearizedRecording;
use super::amplitude_choice::{Prepared, are_shifted, candidates};
use super::amplitude_shape::AmplitudeShape;
use super::covariates::multiples;
use super::explained::Amplitudes;
use super::mesh::{GAP_MESHES_PITCHES, Mesh};
use super::sample::{PHASE_ORDERS, Sample};
use super::wander;
use crate::data::clip::tells_amplitude;
use crate::data::folds::folds;
use effects::sensor::CHANNELS;
use rayon::prelude::*;
use std::sync::Arc;

/// The same of one segment.
#[derive(Default)]
struct AmplitudeModel {
    by_place: Vec<f64>,
    by_offsets: Vec<f64>,
    pair_course: Vec<[f64; 4]>,
    mean_flaws: Vec<f64>,
}

/// Rows that are looked at: of more, every so many. A bound on the work: every so many rows tell an amplitude's course to a
/// hundredth of their scatter.
const MOST_ROWS: usize = 10_000;
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
        let prepared: Vec<(usize, Prepared)> = segments
            .filter_map(|s| Some((s, self.prepared(s, &folds)?)))
            .collect();
        let candidates: Vec<_> = prepared
            .par_iter()
            .map(|(_, prepared)| candidates(prepared))
            .collect();
        let shifted = are_shifted(candidates.iter().flatten());
        let both = prepared.par_iter().zip(&candidates);
        let all: Vec<(usize, AmplitudeModel)> = both
            .filter_map(|((s, prepared), candidates)| {
                let (shape, noise) = candidates
                    .as_ref()
                    .and_then(|c| Some((c.shape(shifted)?, c.loose)))?;
                let mut one = self.explain_one(*s, (shape, noise), &prepared.samples, &folds)?;
                let shows = candidates
                    .as_ref()
                    .is_some_and(|c| c.shows_offsets(shifted));
                if shows && one.by_offsets.is_empty() {
                    one.by_offsets = vec![0.0; self.len()];
                }
                Some((*s, one))
            })
            .collect();
        for (segment, one) in all {
            found.pair_course[segment] = one.pair_course;
            found.by_offsets[segment] = one.by_offsets;
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
        self.inputs.offsets_by_place =
            std::array::from_fn(|s| !amplitudes.by_offsets[s].is_empty());
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

    /// The samples of a segment's amplitude that are looked at, each less a wander as far as it is known.
    fn samples(
        &self,
        segment: usize,
        folds: &[u8],
        course: impl Fn(usize) -> [f64; 4],
    ) -> Vec<Sample> {
        let n = self.ln_amplitude[segment].len();
        let every = n.div_ceil(MOST_ROWS).max(1);
        let used = (0..n).step_by(every).filter(|&i| self.mask[i]);
        let used = used.filter(|&i| tells_amplitude(self.observations, segment, i));
        used.filter_map(|i| self.sample(segment, i, folds[i], course(i)))
            .collect()
    }

    /// A segment's amplitude and what it may be told by; none where there are too few samples.
    fn prepared(&self, segment: usize, folds: &[u8]) -> Option<Prepared> {
        let samples = self.samples(segment, folds, |_| [0.0; 4]);
        if samples.len() < MINIMUM_ROWS {
            return None;
        }
        let meshes = GAP_MESHES_PITCHES
            .iter()
            .filter_map(|step| Mesh::over(&samples, step * self.observations.pitch_m))
            .collect();
        Some(Prepared {
            samples,
            meshes,
            noise: self.amplitude_noise(segment),
            scatter: self.amplitude_scatter(segment),
            wanders: !self.normal.mean_flaws[segment].is_empty(),
        })
    }

    fn explain_one(
        &self,
        segment: usize,
        (shape, noise): (AmplitudeShape<'_>, f64),
        all: &[Sample],
        folds: &[u8],
    ) -> Option<AmplitudeModel> {
        let n = self.ln_amplitude[segment].len();
        let known = &self.normal.mean_flaws[segment];
        let mut coefficients = shape.coefficients(all, noise)?;
        let mut found = AmplitudeModel::default();
        if shape.wander.is_some() {
            found.pair_course = vec![[0.0; 4]; n];
            self.add_wander(&shape, &coefficients, known, &mut found);
            // The columns are those of small flaws: once more about the flaws that are known now.
            let again = self.samples(segment, folds, |i| found.pair_course[i]);
            coefficients = shape.coefficients(&again, noise)?;
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
        if let Some(places) = shape.offsets {
            let value = |s: Sample| {
                let entries = places.entries(&s, shape.before_offsets()).into_iter();
                entries.map(|(column, x)| x * coefficients[column]).sum()
            };
            let at = |i: usize| self.sample(segment, i, 0, [0.0; 4]).map_or(0.0, value);
            found.by_offsets = (0..n).map(at).collect();
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
            let offsets = self.amplitudes.by_offsets[segment].get(i);
            let offsets = offsets.copied().unwrap_or(0.0);
            (i, (list[i] - field - offsets - wander) / noise)
        };
        let used = (0..list.len()).filter(|i| self.mask[*i]);
        let used = used.filter(|&i| tells_amplitude(self.observations, segment, i));
        used.map(left).filter(|l| l.1.is_finite()).collect()
    }

    /// What a pair's amplitude has beside its own pattern, over its noise: (sample, channel, value), the channels of the four pairs coming behind the
    /// residual ones. What disturbs a pair's readings shows in its amplitude as it does in its phase, and where the phase is hardly off as well.
    pub fn amplitude_rows(&self) -> Vec<(usize, usize, f64)> {
        let of_segment = |segment: usize| {
            let noise = self.amplitude_noise(segment).sqrt();
            let told = move |i: &usize| {
                let amplitude = self.observations.amplitude_counts[segment][*i];
                amplitude.is_finite() && tells_amplitude(self.observations, segment, *i)
            };
            let list = &self.ln_amplitude[segment];
            let used = (0..list.len()).filter(told);
            used.map(move |i| (i, CHANNELS + segment, list[i] / noise))
        };
        (0..4).flat_map(of_segment).collect()
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
        let level = crate::algebra::statistics::rms(
            o.amplitude_counts[segment]
                .iter()
                .copied()
                .filter(|a| a.is_finite()),
        );
        let stated = o.pair_noise_counts / level.max(1e-9);
        let shown = self.amplitude_scatter(segment);
        stated.powi(2).max(shown).max(1e-12)
    }

    /// Mean square of the logarithm's noise as neighbours on a smooth path show it.
    fn amplitude_scatter(&self, segment: usize) -> f64 {
        let o = self.observations;
        let list = &self.ln_amplitude[segment];
        let whole = |i: usize| tells_amplitude(o, segment, i);
        let near = |i: &usize| o.stretch[i - 1] == o.stretch[i + 1] && (i - 1..=i + 1).all(whole);
        let mut bends: Vec<f64> = (1..list.len().saturating_sub(1))
            .filter(near)
            .map(|i| (list[i - 1] - 2.0 * list[i] + list[i + 1]) / 6f64.sqrt())
            .collect();
        let middle = crate::algebra::statistics::median_and_deviation(&mut bends);
        middle.map_or(0.0, |b| b.1.powi(2))
    }
}

/// Fewer samples tell nothing of an amplitude's course. Derived from the wander's 63 knots: five to each.
const MINIMUM_ROWS: usize = 300;
