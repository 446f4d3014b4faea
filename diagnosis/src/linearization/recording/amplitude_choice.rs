//! Which shape explains the amplitudes: the place as a gap does, time as a wandering pair does, or offsets that change with the place
//! as a field from outside makes them.
//!
//! Gap and wander are each pair's own. A field from outside comes to all pairs, so it is decided for all of them together: by what
//! it leaves on pieces that it has not seen, beside what the best of all other shapes leaves there.

use super::amplitude_shape::{AmplitudeShape, likeliest};
use super::mesh::Mesh;
use super::offsets::Places;
use super::sample::Sample;

/// Squares over the noise that a wander, a gap or offsets must explain. Derived from chi-square with the 42 amounts of offsets
/// (`offsets::COLUMNS`): by chance beyond 100 once in a million recordings.
const LEAST_SQUARES: f64 = 100.0;
/// Share of what time and own phase leave that the place must explain.
const EXPLAINED_BY_PLACE: f64 = 0.5;
/// Share of what the place leaves that a wander must explain.
const EXPLAINED_BY_TIME: f64 = 0.7;
/// Share of what the best other shapes leave over the noise, in all pairs together, that offsets which change with the place must
/// explain: as of the place.
const EXPLAINED_BY_OFFSETS: f64 = EXPLAINED_BY_PLACE;
/// No shape is exact: what it leaves of the squares at least.
const SHAPE_ERROR_SHARE: f64 = 1.0e-3;
/// Knots over the recording that are tried for a change of the whole: at most two a period of what changes within a tenth of it.
/// Derived from the sampling theorem: twenty intervals and three knots beyond the ends; then half and a quarter as many.
const CHANGE_KNOTS: [usize; 3] = [7, 12, 23];

/// One pair's amplitude, and what it may be told by.
pub(super) struct Prepared {
    pub(super) samples: Vec<Sample>,
    pub(super) meshes: Vec<Mesh>,
    /// Mean square of the noise.
    pub(super) noise: f64,
    /// The same as neighbours on a smooth path show it: nothing that changes smoothly is in it.
    pub(super) scatter: f64,
    /// The pair is known to wander.
    pub(super) wanders: bool,
}

/// What may explain a pair's amplitude.
pub(super) struct Candidates<'a> {
    /// Field or wander or both; none where neither is worth it.
    base: Option<AmplitudeShape<'a>>,
    /// Offsets that change with the place, and what they leave.
    shifted: Option<(AmplitudeShape<'a>, f64)>,
    /// The noise that shapes are fitted with.
    pub(super) loose: f64,
    /// What the best shape without such offsets leaves.
    unshifted: f64,
    /// Samples.
    count: f64,
}

impl<'a> Candidates<'a> {
    /// The shape that explains the amplitude. `shifted`: the pairs' offsets change with the place. A wander is told without them: where few places
    /// come back, the two are hard to tell apart, and what the wander takes of them is the smaller error.
    pub(super) fn shape(&self, shifted: bool) -> Option<AmplitudeShape<'a>> {
        let offsets = self.offsets(shifted).map(|(shape, _)| shape);
        offsets.filter(|shape| shape.wander.is_none()).or(self.base)
    }

    /// Whether this pair shows offsets that change with the place. `shifted`: all pairs together do.
    pub(super) fn shows_offsets(&self, shifted: bool) -> bool {
        self.offsets(shifted).is_some()
    }

    fn offsets(&self, shifted: bool) -> Option<(AmplitudeShape<'a>, f64)> {
        let offsets = self.shifted.filter(|_| shifted);
        offsets.filter(|(_, left)| self.gain(*left) > 0.0)
    }

    /// Squares over the noise that a shape which leaves this much explains beside the best one without offsets.
    fn gain(&self, left: f64) -> f64 {
        (self.unshifted - left) * self.count / self.loose
    }
}

/// Whether all pairs together show offsets that change with the place.
pub(super) fn are_shifted<'c>(all: impl Iterator<Item = &'c Candidates<'c>>) -> bool {
    let (mut gain, mut excess) = (0.0, 0.0);
    for one in all {
        let left = one.shifted.map_or(one.unshifted, |(_, left)| left);
        gain += one.gain(left);
        excess += one.gain(one.loose).max(0.0);
    }
    crate::trace::log(&format!(
        "offsets over the place explain {gain:.0} of {excess:.0}"
    ));
    gain > LEAST_SQUARES && gain > EXPLAINED_BY_OFFSETS * excess
}

/// Offsets that change with the place, beside a gap where that is worth it; and what they leave.
fn shifted<'a>(
    all: &[Sample],
    field: AmplitudeShape<'a>,
    noise: f64,
) -> Option<(AmplitudeShape<'a>, f64)> {
    let alone = AmplitudeShape {
        offsets: Some(Places::of(all)?),
        ..AmplitudeShape::default()
    };
    let (alone, left) = alone.held_out(&alone.pieces(all), noise)?;
    let beside = AmplitudeShape {
        field: field.field,
        ..alone
    };
    let both = beside.held_out(&beside.pieces(all), noise);
    let is_gap = |both: &f64| is_worth(left, *both, EXPLAINED_BY_PLACE, noise, all.len() as f64);
    Some(
        both.filter(|(_, both)| is_gap(both))
            .unwrap_or((alone, left)),
    )
}

/// Offsets that change with the place, beside a wander; and what both leave.
fn beside_wander<'a>(
    all: &[Sample],
    wander: AmplitudeShape<'a>,
    noise: f64,
) -> Option<(AmplitudeShape<'a>, f64)> {
    let beside = AmplitudeShape {
        offsets: Some(Places::of(all)?),
        ..wander
    };
    beside.held_out(&beside.pieces(all), noise)
}

/// Whether leaving `after` instead of `before` is past chance and this share of what is over the noise.
fn is_worth(before: f64, after: f64, share: f64, noise: f64, count: f64) -> bool {
    let beyond_chance = (before - after) * count / noise > LEAST_SQUARES;
    beyond_chance && before - after > share * (before - noise)
}

/// What may explain a pair's amplitude.
pub(super) fn candidates(prepared: &Prepared) -> Option<Candidates<'_>> {
    let Prepared {
        samples: all,
        meshes,
        noise,
        scatter,
        wanders,
    } = prepared;
    let (noise, scatter, wanders) = (*noise, *scatter, *wanders);
    let count = all.len() as f64;
    let nothing = all.iter().map(|s| s.value * s.value).sum::<f64>() / count;
    let loose = noise.max(SHAPE_ERROR_SHARE * nothing);
    // All that is not noise is less than any shape must explain.
    if !wanders && (nothing - scatter) * count / noise <= LEAST_SQUARES {
        return Some(Candidates {
            base: None,
            shifted: None,
            loose,
            unshifted: nothing,
            count,
        });
    }
    let fields = meshes.iter().map(|mesh| AmplitudeShape {
        field: Some(mesh),
        ..AmplitudeShape::default()
    });
    let courses = CHANGE_KNOTS.into_iter().map(|course| AmplitudeShape {
        course,
        ..AmplitudeShape::default()
    });
    let over_places = likeliest(fields, all, loose)?;
    let over_time = likeliest(courses, all, loose)?;
    let (field, place) = (over_places.shape, over_places.left);
    let (course, time) = (over_time.shape, over_time.left);
    let alone = AmplitudeShape::default().wandering(all, loose)?;
    let wandering = alone.1;
    let beside = field.wandering(all, loose)?;
    let together = beside.1;
    // Beside a wander that explains nothing the field stands alone.
    let (before, after) = if wandering < nothing {
        (wandering, together)
    } else {
        (nothing, place)
    };
    let worth = |before, after, share| is_worth(before, after, share, noise, count);
    let by_place = over_places.log_evidence > over_time.log_evidence
        && worth(before, after.min(place), EXPLAINED_BY_PLACE);
    // A change of the whole beside a wander is told where it foretells: between runs that lie far apart its knots follow the noise.
    let (timed, slow) = if by_place {
        beside
    } else {
        let with_change = course.wandering(all, loose)?;
        if wandering < with_change.1 {
            alone
        } else {
            with_change
        }
    };
    let left = if by_place { place } else { time.min(nothing) };
    let by_time = wanders || worth(left, slow, EXPLAINED_BY_TIME);
    crate::trace::log(&format!(
        "amplitude over its noise: {:.2}; place {:.2}, time {:.2}, wander {:.2}, both {:.2}, {:.2}; gap {by_place}, wander {by_time}; logarithm of the \
         evidence: place {:.0}, time {:.0}",
        nothing / noise,
        place / noise,
        time / noise,
        wandering / noise,
        together / noise,
        slow / noise,
        over_places.log_evidence,
        over_time.log_evidence
    ));
    let base = match (by_place, by_time) {
        (false, false) => None,
        (true, false) => Some(field),
        (_, true) => Some(timed.each_flaw(all, loose)?),
    };
    let least = [nothing, place, time, wandering, together, slow].into_iter();
    let unshifted = least.fold(f64::INFINITY, f64::min);
    // A pair that is known to wander does so here.
    let shifted = match base.filter(|_| by_time) {
        _ if wanders => None,
        Some(wander) => beside_wander(all, wander, loose),
        None => shifted(all, field, loose),
    };
    Some(Candidates {
        base,
        shifted,
        loose,
        unshifted,
        count,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::data::folds::FOLDS;
    use crate::linearization::recording::mesh::GAP_MESHES_PITCHES;
    use effects::random::{ChaCha8Rng, SeedableRng, normal};

    /// A round value near the paper's 1.016 mm.
    const PITCH_M: f64 = 1.0e-3;
    /// Poses far apart after some sweeps: a hundred over 50 mm.
    const POSES: usize = 100;
    const SWEEPS: usize = 4;
    const OF_A_SWEEP: usize = 400;

    /// The amplitude of sweeps along four lines, and of poses that are scattered over all of the platen once.
    fn prepared(mut value: impl FnMut([f64; 2], f64) -> f64) -> Prepared {
        let mut samples = Vec::new();
        let all = (SWEEPS * OF_A_SWEEP + POSES) as f64;
        let mut add = |place_m: [f64; 2], fold: usize| {
            let progress = samples.len() as f64 / all;
            let phase_rad = core::f64::consts::TAU * place_m[0] / PITCH_M;
            samples.push(Sample {
                progress,
                value: value(place_m, progress),
                fold: fold % FOLDS,
                ..Sample::at(place_m, phase_rad)
            });
        };
        for sweep in 0..SWEEPS {
            for k in 0..OF_A_SWEEP {
                let along_m = 2.0e-3 * k as f64 / OF_A_SWEEP as f64;
                add([1.0e-3 * sweep as f64, along_m], k / 20 + 2 * sweep);
            }
        }
        // The golden ratio and its like fill a square evenly (Roberts 2018).
        let share = |k: usize, part: f64| 50.0e-3 * (k as f64 * part).fract();
        for k in 0..POSES {
            add([share(k, 0.754_877_666), share(k, 0.569_840_291)], k / 6);
        }
        let mesh = |step: &f64| Mesh::over(&samples, step * PITCH_M);
        let meshes = GAP_MESHES_PITCHES.iter().filter_map(mesh).collect();
        Prepared {
            samples,
            meshes,
            noise: 1.0e-6,
            scatter: 1.0e-6,
            wanders: false,
        }
    }

    /// Whether a gap explains it.
    fn is_gap(value: fn([f64; 2], f64) -> f64) -> bool {
        let prepared = prepared(value);
        let found = candidates(&prepared).expect("regular");
        let shape = found.shape(false);
        shape.is_some_and(|s| s.field.is_some())
    }

    /// Waves of 17 and 14 mm, which the poses meet three times each, and the sweeps show a part of.
    #[test]
    fn what_follows_the_place_is_a_gap() {
        let waves =
            |[x, y]: [f64; 2], _| 0.02 * ((370.0 * x).sin() + (273.0 * y + 370.0 * x).cos());
        assert!(is_gap(waves));
    }

    /// The same motion, and an amplitude that follows the time.
    #[test]
    fn what_follows_the_time_is_no_gap() {
        let course = |_, progress: f64| 0.03 * (9.0 * progress).sin();
        assert!(!is_gap(course));
    }

    /// A millionth is the noise's mean square, and 1,700 samples of a wave of half that are 850 squares.
    #[test]
    fn shapes_are_looked_for_where_more_than_noise_may_be() {
        let looked_for = |wave: f64, seed: u64| {
            let mut rng = ChaCha8Rng::seed_from_u64(seed);
            let prepared =
                prepared(|_, progress| 1.0e-3 * normal(&mut rng) + wave * (9.0 * progress).sin());
            let found = candidates(&prepared).expect("regular");
            let all = prepared.samples.iter().map(|s| s.value * s.value);
            found.unshifted < all.sum::<f64>() / prepared.samples.len() as f64
        };
        assert!(looked_for(1.0e-3, 1));
        assert!(!looked_for(0.0, 1) && !looked_for(1.0e-4, 2));
    }
}
