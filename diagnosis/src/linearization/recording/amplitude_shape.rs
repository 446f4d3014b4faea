//! Shapes that an amplitude may have over place, phase and time: columns of a linear fit.
//!
//! An offset, a gain or an angle changes the amplitude to first order by
//! `offset_s sin φ + offset_c cos φ - (gain/2) cos 2φ + (angle/2) sin 2φ`.

use super::mesh::{GAP_WAVE_SIZE, Mesh};
use super::offsets::{self, Places};
use super::sample::{PHASE_ORDERS, Sample};
use super::wander::{self, FLAW_SIZE, FLAWS, STRAIGHT_PARTS, WanderLengths, knot_weights};
use crate::algebra::penalized::{Penalty, Pieces, Row};

/// Columns of the flaws: what a unit of each adds to the amplitude.
fn by_flaw(sample: &Sample) -> [f64; 4] {
    let [_, one, two, ..] = sample.phase;
    [one.0, one.1, -0.5 * two.1, 0.5 * two.0]
}

/// Columns of a wander whose flaws are straight over some parts of the recording, of a field, of a slow change of the whole with so
/// many knots, and of offsets that change with the place.
#[derive(Clone, Copy, Default)]
pub(super) struct AmplitudeShape<'a> {
    pub(super) wander: Option<WanderLengths>,
    pub(super) field: Option<&'a Mesh>,
    pub(super) course: usize,
    pub(super) offsets: Option<Places>,
}

/// See [`PHASE_ORDERS`].
const PATTERN_COLUMNS: usize = 2 * PHASE_ORDERS;

impl<'a> AmplitudeShape<'a> {
    /// Columns before those of the field.
    pub(super) fn first(&self) -> usize {
        self.wander.map_or(0, |_| wander::COLUMNS)
    }

    /// Columns before those of offsets.
    pub(super) fn before_offsets(&self) -> usize {
        self.first() + self.field.map_or(0, Mesh::columns) + self.course
    }

    fn columns(&self) -> usize {
        let pattern = self.wander.map_or(0, |_| PATTERN_COLUMNS);
        self.before_offsets() + self.offsets.map_or(0, |_| offsets::COLUMNS) + pattern
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
        if let Some(places) = self.offsets {
            // What is the same everywhere is the wander's.
            let same = self.wander.map_or(0, |_| offsets::SAME_EVERYWHERE);
            let varying = places.entries(sample, self.before_offsets()).into_iter();
            entries.extend(varying.skip(same));
        }
        if self.wander.is_some() {
            // The pattern was told while the pair wandered: it may be wrong by about as much.
            let orders = sample
                .phase
                .iter()
                .flat_map(|(sine, cosine)| [sine, cosine]);
            let pattern = (self.columns() - PATTERN_COLUMNS..).zip(orders);
            entries.extend(pattern.map(|(column, shape)| (column, FLAW_SIZE * shape)));
        }
        Row {
            entries,
            value: sample.value,
            fold: sample.fold,
        }
    }

    pub(super) fn pieces(&self, samples: &[Sample]) -> Pieces {
        Pieces::new(self.columns(), samples.iter().map(|s| self.row(s)))
    }

    /// Flaws that a fit found in the pattern.
    pub(super) fn flaws_in_pattern(&self, coefficients: &[f64]) -> [f64; 4] {
        let pattern = &coefficients[self.columns() - PATTERN_COLUMNS..];
        let [_, one, two] = [0, 1, 2].map(|order| [pattern[2 * order], pattern[2 * order + 1]]);
        [one[0], one[1], -2.0 * two[1], 2.0 * two[0]].map(|flaw| FLAW_SIZE * flaw)
    }

    /// Amounts of the columns. Those of a flaw that does not wander are zero and not nearly so.
    pub(super) fn coefficients(&self, samples: &[Sample], noise: f64) -> Option<Vec<f64>> {
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
    pub(super) fn held_out(self, pieces: &Pieces, noise: f64) -> Option<(Self, f64)> {
        Some((self, pieces.held_out(noise, &self.penalties())?))
    }

    /// The same of the best wander beside this shape, of flaws that are all alike.
    pub(super) fn wandering(self, all: &[Sample], noise: f64) -> Option<(Self, f64)> {
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
    pub(super) fn each_flaw(self, all: &[Sample], noise: f64) -> Option<Self> {
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

/// A shape with the logarithm of how likely the amplitudes are under it, and what it leaves on pieces that it has not seen.
pub(super) struct Likeliest<'a> {
    pub(super) shape: AmplitudeShape<'a>,
    pub(super) log_evidence: f64,
    pub(super) left: f64,
}

/// The shape under which the amplitudes are likeliest. What a shape leaves on pieces that it has not seen is no way to choose it: where a motion
/// comes to each place once, a fine mesh has to foretell places far from all others, and errs there by as much as it expects to.
pub(super) fn likeliest<'a>(
    shapes: impl Iterator<Item = AmplitudeShape<'a>>,
    all: &[Sample],
    noise: f64,
) -> Option<Likeliest<'a>> {
    let each = shapes.filter_map(|shape| {
        let pieces = shape.pieces(all);
        let log_evidence = pieces.log_evidence(noise)?;
        Some((log_evidence, shape, pieces))
    });
    let (log_evidence, shape, pieces) = each.max_by(|a, b| a.0.total_cmp(&b.0))?;
    let (shape, left) = shape.held_out(&pieces, noise)?;
    Some(Likeliest {
        shape,
        log_evidence,
        left,
    })
}
