//! Segments whose readings come so late that it shows before anything is fitted: by a good part of a tooth while the courier is fast.
//!
//! Such a delay is no small displacement, proportional to the speed: during it the courier speeds up, stops and passes teeth. The reading
//! that belongs to a sample is the one that comes a delay later; it is interpolated here between the readings. The delay is the one that
//! leaves the smallest residual: the parity g_p, or a segment's position less the reference's where there is a reference.

mod alignment;

use crate::algebra::statistics::{median, quantile};
use crate::data::late_segment::LateSegment;
use crate::data::motion::SMOOTH_M;
use crate::data::observations::Observations;
use crate::linearization::baseline::Baseline;
use crate::trace::log;
use alignment::{Alignment, Beside, stretches};

/// Longest delay that is looked for, s. A prior: 34 ms over a field bus is the longest that was met (Encoder Signal Simulation's
/// rotary drive), and half as much again.
const LONGEST_S: f64 = 51.0e-3;
/// Delays that are tried first. Derived from steps of half a millisecond: at 0.2 m/s, a survey's fastest, a step is a tenth of a
/// tooth, so that one of them is nearer than that to the truth.
const TRIED: usize = 102;
/// Rounds in which the place of the least is found more finely, each to a third: to a microsecond in the end. Derived from
/// thirds: half a millisecond over 3^6 is 0.7 µs.
const FINER: usize = 6;
/// Steps of Gauss-Newton from there. Derived from their quadratic convergence: each doubles the digits of what a search to 0.7 µs
/// leaves open, so that the last two change nothing.
const STEPS: usize = 4;
/// The residual beside equation (3) must fall to this share of its mean size, or the segment is not late. A prior: a delay alone
/// leaves a hundredth of it; one that is as large as all other gaps together leaves about half.
const LEFT: f64 = 0.5;
/// A delay moves a segment by at least this share of a pitch at its highest speed: the sine of a phase that is off by less is off
/// by less than a tenth of it, so that smaller ones are told by the speed. Derived from the sine's series: 2π 0.05 is 0.31 rad,
/// whose sine is off by 0.005 rad.
const LEAST_PITCHES: f64 = 0.05;
/// Where the residual's mean size is below this share of that, no segment is late: the fastest run of a survey is twenty times as
/// fast as the slowest, which has most of the samples. Derived from those speeds, 0.2 and 0.01 m/s.
const LEAST_MEAN: f64 = 0.05;
/// An interpolated reading is used if the parabolas by the readings before and after it agree to so many times the stated noise.
/// Derived from the normal tail: by chance one in 16,000 does not.
const ALIKE_NOISES: f64 = 4.0;
/// Readings that tell what lies between them to no better than this follow no path, m: as in [`crate::data::motion`].
const POSES_M: f64 = SMOOTH_M;

/// Late segments of a recording. Cost: about a thousand sums over 1,500 samples where the residual is large, else four.
pub fn late(o: &Observations) -> [Option<LateSegment>; 4] {
    let mut found = Alignment::new(o);
    while let Some(next) = one_more(&found) {
        found = next;
    }
    std::array::from_fn(|s| {
        (found.delays_s[s] > 0.0).then(|| LateSegment {
            delay_s: found.delays_s[s],
            ahead_m: ahead_m(&found, s, f64::INFINITY, &|_| 0.0),
        })
    })
}

/// Aligns late segments once more, now that equation (3) is known. A fast courier passes a period of equation (3) within a sample, so that
/// readings are interpolated better without it.
pub fn realign(o: &mut Observations, baseline: &Baseline) {
    let late: [Option<LateSegment>; 4] = std::mem::take(&mut o.late);
    o.align_in_time(&late, -1.0);
    let pitch_m = o.pitch_m;
    let error_m = |s: usize, position_m: f64| baseline.error_m(s, position_m, pitch_m).0;
    let place_m: [Vec<f64>; 4] = std::array::from_fn(|s| {
        let read_m = o.position_m[s].iter();
        read_m.map(|read_m| read_m + error_m(s, *read_m)).collect()
    });
    let mut found = Alignment {
        observations: o,
        delays_s: late
            .each_ref()
            .map(|late| late.as_ref().map_or(0.0, |late| late.delay_s)),
        place_m: &place_m,
    };
    for s in (0..4).filter(|s| late[*s].is_some()) {
        let beside = found.beside(s);
        let of = |delay_s: f64| mean_residual_m(&beside, delay_s);
        found.delays_s[s] = finer(of, found.delays_s[s]);
    }
    let late = std::array::from_fn(|s| {
        late[s].as_ref().map(|_| LateSegment {
            delay_s: found.delays_s[s],
            ahead_m: ahead_m(&found, s, ALIKE_NOISES, &|place_m| error_m(s, place_m)),
        })
    });
    o.align_in_time(&late, 1.0);
    o.late = late;
}

/// The alignment with one more late segment, if there is one.
fn one_more<'a>(known: &Alignment<'a>) -> Option<Alignment<'a>> {
    let o = known.observations;
    let least_m = LEAST_MEAN * LEAST_PITCHES * o.pitch_m;
    let one = |segment: usize| {
        let beside = known.beside(segment);
        let of = |delay_s: f64| mean_residual_m(&beside, delay_s);
        let first_m = of(0.0);
        if first_m < least_m {
            return None;
        }
        let tried = (0..=TRIED).map(|k| k as f64 * LONGEST_S / TRIED as f64);
        let best = tried.map(|d| (segment, d, of(d) / first_m));
        best.min_by(|a, b| a.2.total_cmp(&b.2))
    };
    let candidates = (0..4).filter(|s| o.has_segment(*s) && known.delays_s[*s] == 0.0);
    let (segment, delay_s, _) = candidates
        .filter_map(one)
        .min_by(|a, b| a.2.total_cmp(&b.2))?;
    let beside = known.beside(segment);
    let of = |delay_s: f64| mean_residual_m(&beside, delay_s);
    let mut next = known.with(segment, finer(of, delay_s));
    for _ in 0..STEPS {
        let delay_s = next.delays_s[segment] + next.fit(segment, true)?.more_s;
        next = next.with(segment, delay_s.clamp(0.0, LONGEST_S));
    }
    let delay_s = next.delays_s[segment];
    let [before_m, left_m] = [known, &next].map(|of| of.fit(segment, false).map(|fit| fit.left_m));
    let (before_m, left_m) = (before_m?, left_m?);
    log(&format!(
        "segment {} late by {:.3} ms: a residual of {:.3} of {:.3} µm is left",
        segment + 1,
        1e3 * delay_s,
        1e6 * left_m,
        1e6 * before_m
    ));
    (left_m < LEFT * before_m && is_far(&next, segment)).then_some(next)
}

/// True if a delay moves a segment far enough at its highest speed.
fn is_far(found: &Alignment, segment: usize) -> bool {
    let moved =
        |i: usize| (found.later_m(segment, i).0 - found.observations.position_m[segment][i]).abs();
    let all = found.sample_numbers().map(moved);
    let mut all: Vec<f64> = all.filter(|m| m.is_finite()).collect();
    let far = LEAST_PITCHES * found.observations.pitch_m;
    quantile(&mut all, 0.99).is_some_and(|moved| moved > far)
}

/// The least of a function of a delay about some delay, more and more finely.
fn finer(of: impl Fn(f64) -> f64, about_s: f64) -> f64 {
    let mut half_s = LONGEST_S / TRIED as f64;
    let mut best = (about_s, of(about_s));
    for _ in 0..FINER {
        let nearer = [-2.0, -1.0, 1.0, 2.0].map(|k| (best.0 + k * half_s / 3.0).max(0.0));
        let nearer = nearer.into_iter().map(|d| (d, of(d)));
        best = nearer.fold(best, |best, next| if next.1 < best.1 { next } else { best });
        half_s /= 3.0;
    }
    best.0
}

/// Mean size of a segment's residual with some delay of its own, m, about one zero, or about one in each stretch if that leaves less.
fn mean_residual_m(beside: &Beside, delay_s: f64) -> f64 {
    let column = beside.residuals(delay_s);
    let stretch = |of: &(usize, f64)| beside.stretch(of.0);
    let stretches = column.chunk_by(|a, b| stretch(a) == stretch(b));
    let apart_m: f64 = stretches.map(spread_m).sum();
    apart_m.min(spread_m(&column)) / column.len().max(1) as f64
}

/// Sum of sizes about the median.
fn spread_m(part: &[(usize, f64)]) -> f64 {
    let mut values: Vec<f64> = part.iter().map(|(_, value)| *value).collect();
    let middle = median(&mut values).unwrap_or(0.0);
    values.iter().map(|value| (value - middle).abs()).sum()
}

/// What a segment reads a delay after each sample above what it reads there, m; `error_m` is what is to be added to a reading. Where that is
/// unsure to more than so many noises it is not told. The samples of a stretch in which most readings tell nothing of those between them are
/// separate poses, at rest.
fn ahead_m(
    found: &Alignment,
    segment: usize,
    alike_noises: f64,
    error_m: &dyn Fn(f64) -> f64,
) -> Vec<f64> {
    let o = found.observations;
    let read_m = &o.position_m[segment];
    let told: Vec<(f64, f64)> = (0..o.len()).map(|i| found.later_m(segment, i)).collect();
    let ahead = |i: usize| {
        let (later_m, unsure_m) = told[i];
        if unsure_m <= alike_noises * o.position_noise_m[segment][i] {
            // What is read at that place: the error changes slowly with it.
            let near_m = later_m - error_m(later_m);
            later_m - error_m(near_m) - read_m[i]
        } else {
            f64::NAN
        }
    };
    let mut out: Vec<f64> = (0..o.len()).map(ahead).collect();
    for stretch in stretches(o) {
        let apart = told[stretch.clone()]
            .iter()
            .filter(|(_, unsure_m)| *unsure_m > POSES_M);
        if 2 * apart.count() > stretch.len() {
            out[stretch].fill(0.0);
        }
    }
    out
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::motion::Pose;
    use effects::plant::Geometry;
    use effects::velocity_lag::VelocityLag;
    use hal_sim::courier::Courier;
    use hal_sim::presets::ideal;
    use hal_sim::trajectory::{OpenLoop, Plan};

    /// Sweeps along x and y at three speeds, straight and turned, every second millisecond.
    fn observations(delay_s: [f64; 4], reference: bool) -> Observations {
        let mut plan = Plan::new(Pose::default(), Geometry::PAPER, OpenLoop::COURIER, 7);
        for (number, speed_m_s) in [0.01, 0.05, 0.2].into_iter().enumerate() {
            let half_m = [0.004, 0.01, 0.02][number];
            for (axis, x_m, y_m) in [("x", half_m, 0.0), ("y", 0.0, half_m)] {
                let half = Pose::new(x_m, y_m, 0.004);
                let ends = [half.plus(half, -2.0), half];
                plan = plan.sweep_both_ways(&format!("{axis}_{number}"), ends, speed_m_s);
            }
        }
        let mut spec = ideal(7);
        spec.effects.push(Box::new(VelocityLag {
            delay_s,
            saturation: 0.0,
            saturation_m_s: 1.0,
        }));
        let mut courier = Courier::new(spec, 7).unwrap();
        let whole = hal_sim::record::record(&mut courier, &plan, reference);
        Observations::new(&whole.with_rows(|k, _| k % 2 == 0)).unwrap()
    }

    fn delays_s(o: &Observations) -> [f64; 4] {
        late(o).map(|late| late.map_or(0.0, |late| late.delay_s))
    }

    #[test]
    fn a_segment_that_comes_late_is_found_with_its_delay() {
        for (segment, delay_s) in [(2, 2.0e-3), (1, 7.3e-3), (0, 34.0e-3)] {
            let mut wanted_s = [0.0; 4];
            wanted_s[segment] = delay_s;
            let found_s = delays_s(&observations(wanted_s, false));
            for (found_s, wanted_s) in found_s.into_iter().zip(wanted_s) {
                // Between two samples at 0.2 m/s a period of equation (3) is passed: some micrometres over that speed.
                assert!(
                    (found_s - wanted_s).abs() < 50.0e-6,
                    "{found_s}, {wanted_s}"
                );
            }
        }
    }

    /// Against a reference all are found that are late, also where they are so alike.
    #[test]
    fn segments_that_are_late_alike_are_found_against_a_reference() {
        let found_s = delays_s(&observations([3.0e-3; 4], true));
        assert!(
            found_s.iter().all(|d| (d - 3.0e-3).abs() < 50.0e-6),
            "{found_s:?}"
        );
    }

    #[test]
    fn in_time_or_late_by_little_is_not_late() {
        for delay_s in [0.0, 20.0e-6] {
            let found_s = delays_s(&observations([0.0, delay_s, 0.0, 0.0], false));
            assert_eq!(found_s, [0.0; 4]);
        }
    }

    /// An aligned segment is where it would have been without the delay, but for what lies between two samples.
    #[test]
    fn aligned_in_time_the_segments_agree() {
        let mut o = observations([0.0, 0.0, 5.0e-3, 0.0], false);
        let in_time = observations([0.0; 4], false);
        let found = late(&o);
        o.align_in_time(&found, 1.0);
        let off = o.position_m[2].iter().zip(&in_time.position_m[2]);
        let mut off_m: Vec<f64> = off.map(|(a, b)| (a - b).abs()).collect();
        off_m.retain(|m| m.is_finite());
        assert!(off_m.len() * 10 > o.len() * 9);
        assert!(median(&mut off_m).unwrap() < 2.0e-6);
    }
}
