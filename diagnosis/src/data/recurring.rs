//! Disturbances that come back where they were: a bump at a place, and no burst, which comes at any time and anywhere.

use crate::linearization::recording::range;

/// Samples nearer in time than this belong to the same disturbance. By definition the piece that a disturbance must stand out of
/// ([`crate::data::outliers`]).
const MARKED_APART_SAMPLES: usize = 60;
/// Nearest samples of other times that are asked. Derived from the mean that they enter: over ten disturbed samples it is known
/// to 0.06 where half recur.
const NEAREST: usize = 6;
/// Of these so many are disturbed as well, in the mean over disturbed samples. A derivation: of bursts as many as of all samples,
/// some hundredths; inside a bump all and at its straight edge half, so that the mean about a bump is above a half.
const RECURS: f64 = 0.4;
/// Most disturbed samples that are looked at, evenly. A bound on the work: the mean share of 200 is known to 0.035, and `RECURS`
/// lies many of these from either answer.
const MOST_MARKED: usize = 200;

/// True if marked samples lie about places rather than times. `place` is not a number where there is none.
/// Cost: marked samples (200 at most) times all.
pub fn recurs(marked: &[bool], place: &[[f64; 2]]) -> bool {
    let known: Vec<usize> = (0..place.len())
        .filter(|&i| place[i].iter().all(|p| p.is_finite()))
        .collect();
    let spans = [0, 1].map(|axis| {
        let all: Vec<f64> = known.iter().map(|&i| place[i][axis]).collect();
        range(&all).map_or(1.0, |[low, high]| (high - low).max(f64::MIN_POSITIVE))
    });
    let away = |i: usize, j: usize| {
        let step = |axis: usize| (place[i][axis] - place[j][axis]) / spans[axis];
        step(0).powi(2) + step(1).powi(2)
    };
    let of_them: Vec<usize> = known.iter().copied().filter(|&i| marked[i]).collect();
    let every = of_them.len().div_ceil(MOST_MARKED).max(1);
    let shares: Vec<f64> = of_them
        .iter()
        .step_by(every)
        .filter_map(|&i| {
            let others = known
                .iter()
                .filter(|j| j.abs_diff(i) > MARKED_APART_SAMPLES);
            let mut near: Vec<(f64, bool)> = others.map(|&j| (away(i, j), marked[j])).collect();
            if near.len() < NEAREST {
                return None;
            }
            near.select_nth_unstable_by(NEAREST - 1, |a, b| a.0.total_cmp(&b.0));
            let also = near[..NEAREST].iter().filter(|n| n.1).count();
            Some(also as f64 / NEAREST as f64)
        })
        .collect();
    let mean = shares.iter().sum::<f64>() / shares.len().max(1) as f64;
    crate::trace::log(&format!("disturbed again at the same place: {mean:.2}"));
    mean > RECURS
}

/// Disturbances at the ends of a range lie farther out than this share of the undisturbed samples, in the mean. A derivation: the
/// mean is a half if they come anywhere (Mann and Whitney 1947), and 0.85 is that of the outermost three tenths alone;
const OUT: f64 = 0.85;
/// and beyond chance: standard deviations of that mean. Derived from the normal tail: by chance once in 3.5 million recordings.
const SURE: f64 = 5.0;

/// True if marked samples lie at the ends of a commanded quantity's range: there a model lacks most, and what it lacks is no burst.
/// Commanded, as a disturbed reading is itself far out. The share of others that m of them lie beyond scatters by the root of
/// 1 / (12 m) about a half if they come anywhere (Mann and Whitney 1947). Cost: that of sorting.
pub fn at_the_ends(marked: &[bool], commanded: &[f64]) -> bool {
    let known = || (0..commanded.len()).filter(|i| commanded[*i].is_finite());
    let mut all: Vec<f64> = known().map(|i| commanded[i]).collect();
    let Some(middle) = crate::algebra::statistics::median(&mut all) else {
        return false;
    };
    let away = |i: usize| (commanded[i] - middle).abs();
    let mut others: Vec<f64> = known().filter(|i| !marked[*i]).map(away).collect();
    others.sort_by(f64::total_cmp);
    let (mut last, mut count, mut sum) = (None, 0.0, 0.0);
    for i in known().filter(|i| marked[*i]) {
        if last.is_none_or(|last| i - last > MARKED_APART_SAMPLES) {
            let nearer = others.partition_point(|o| *o < away(i));
            sum += nearer as f64 / others.len().max(1) as f64;
            count += 1.0;
            last = Some(i);
        }
    }
    let mean = sum / f64::max(count, 1.0);
    mean > OUT && mean - 0.5 > SURE / (12.0 * count).sqrt()
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::random::{ChaCha8Rng, SeedableRng, uniform};

    #[test]
    fn a_speck_recurs_and_bursts_do_not() {
        let mut rng = ChaCha8Rng::seed_from_u64(4);
        let mut place: Vec<[f64; 2]> = (0..3000)
            .map(|_| [0, 1].map(|_| uniform(&mut rng, -2.0e-3, 2.0e-3)))
            .collect();
        let speck: Vec<bool> = place
            .iter()
            .map(|[x, y]| (x - 0.4e-3).hypot(y + 0.7e-3) < 0.4e-3)
            .collect();
        let bursts: Vec<bool> = (0..3000).map(|i| i % 40 < 3).collect();
        assert!(recurs(&speck, &place) && !recurs(&bursts, &place));
        // Where the courier rests every place is the same, and tells nothing.
        place[1000..].fill([0.1e-3, 0.2e-3]);
        assert!(!recurs(&bursts, &place));
        place.fill([f64::NAN; 2]);
        assert!(!recurs(&speck, &place));
    }

    #[test]
    fn bursts_come_at_any_angle_and_what_a_model_lacks_at_its_ends() {
        let mut rng = ChaCha8Rng::seed_from_u64(6);
        let angle: Vec<f64> = (0..4000).map(|_| uniform(&mut rng, -0.02, 0.03)).collect();
        let beyond: Vec<bool> = angle.iter().map(|a| !(-0.019..0.029).contains(a)).collect();
        assert!(at_the_ends(&beyond, &angle));
        let bursts: Vec<bool> = (0..4000).map(|i| i % 200 < 4).collect();
        assert!(!at_the_ends(&bursts, &angle));
        // Two are no proof, and one burst at an end is one.
        let at: Vec<usize> = (0..4000).filter(|i| beyond[*i]).collect();
        let two: Vec<bool> = (0..4000).map(|i| at[..2].contains(&i)).collect();
        assert!(!at_the_ends(&two, &angle));
        let mut resting = angle.clone();
        resting[1000..1050].fill(0.03);
        let one: Vec<bool> = (0..4000).map(|i| (1000..1050).contains(&i)).collect();
        assert!(!at_the_ends(&one, &resting));
        assert!(!at_the_ends(&beyond, &[f64::NAN; 4000]) && !at_the_ends(&beyond, &[]));
    }
}
