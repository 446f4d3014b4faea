//! Periods after which the same teeth, or pole pairs, come round again: an error over the place repeats after a turn, and not after each
//! period.

/// Cells to a period, derived from an error of its order two, each wave of which has four.
const CELLS: usize = 8;
/// Most cells. A prior: a place that goes over more is no shaft's.
const MOST_CELLS: usize = 100_000;
/// Turns that must have been made, derived from half of the periods being passed twice.
const LEAST_TURNS: f64 = 1.5;
/// Share of the error's power that comes again. A prior: with less, what does not come again is the larger part.
const COMES_AGAIN: f64 = 0.5;
/// Student's t of that correlation over the periods that are passed twice, each of which is as good as one value: derived from the
/// normal tail: by chance once in three million lengths.
const BEYOND_CHANCE: f64 = 5.0;
/// Several turns are a turn as well, and scatter: the shortest length counts whose part that does not come again is less than so
/// many times that of the best.
const AS_GOOD: f64 = 2.0;

/// Periods of a turn by an error at places, in periods: the length after which most of it comes again. None where it does not. What is the same
/// in every period counts for nothing. Cost: the square of the periods passed, times eight cells each.
pub fn periods_of_turn(place: &[f64], error: &[f64]) -> Option<u32> {
    let known = || {
        let both = place.iter().zip(error);
        both.filter(|(p, e)| p.is_finite() && e.is_finite())
    };
    let [low, high] = known().fold([f64::INFINITY, f64::NEG_INFINITY], |[l, h], (p, _)| {
        [l.min(*p), h.max(*p)]
    });
    let cell = |p: f64| ((p - low.floor()) * CELLS as f64) as usize;
    if !(high > low) || cell(high) > MOST_CELLS {
        return None;
    }
    let mut cells = vec![[0.0; 2]; cell(high) + 1];
    for (p, e) in known() {
        let [sum, count] = &mut cells[cell(*p)];
        *sum += e;
        *count += 1.0;
    }
    let mean = |[sum, count]: &[f64; 2]| (*count > 0.0).then(|| sum / count);
    let means: Vec<Option<f64>> = cells.iter().map(mean).collect();
    let own = own_part(&means);
    let most = ((high - low) / LEAST_TURNS) as usize;
    let alike: Vec<(usize, f64)> = (2..=most)
        .filter_map(|periods| Some((periods, correlation(&own, periods * CELLS)?)))
        .filter(|(periods, c)| students_t(*c, high - low - *periods as f64) > BEYOND_CHANCE)
        .collect();
    let best = alike.iter().map(|(_, c)| *c).fold(0.0, f64::max);
    if best < COMES_AGAIN {
        return None;
    }
    let shortest = alike
        .iter()
        .find(|(_, c)| 1.0 - c <= AS_GOOD * (1.0 - best));
    shortest.and_then(|(periods, _)| u32::try_from(*periods).ok())
}

/// Means of cells less what all periods have in common.
fn own_part(means: &[Option<f64>]) -> Vec<Option<f64>> {
    let common: Vec<f64> = (0..CELLS)
        .map(|phase| {
            let of_it: Vec<f64> = means
                .iter()
                .skip(phase)
                .step_by(CELLS)
                .flatten()
                .copied()
                .collect();
            of_it.iter().sum::<f64>() / of_it.len().max(1) as f64
        })
        .collect();
    let cells = means.iter().enumerate();
    cells
        .map(|(k, mean)| mean.map(|m| m - common[k % CELLS]))
        .collect()
}

/// Student's t of a correlation of so many pairs.
fn students_t(correlation: f64, pairs: f64) -> f64 {
    let rest = (1.0 - correlation * correlation).max(f64::EPSILON);
    correlation * ((pairs - 2.0).max(0.0) / rest).sqrt()
}

/// Correlation of values with those so many cells on; none where none has another.
fn correlation(values: &[Option<f64>], away: usize) -> Option<f64> {
    let pairs = values.iter().zip(values.iter().skip(away));
    let mut sums = [0.0; 3];
    for (a, b) in pairs.filter_map(|(a, b)| Some(((*a)?, (*b)?))) {
        sums = [sums[0] + a * a, sums[1] + b * b, sums[2] + a * b];
    }
    let [a, b, both] = sums;
    (a > 0.0 && b > 0.0).then(|| both / (a * b).sqrt())
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::random::{ChaCha8Rng, SeedableRng, normal};

    /// A ring of pole pairs that are each off by their own amount, turned so many times.
    fn ring(seed: u64, poles: usize, turns: f64, noise: f64) -> (Vec<f64>, Vec<f64>) {
        let mut rng = ChaCha8Rng::seed_from_u64(seed);
        let off: Vec<f64> = (0..poles).map(|_| normal(&mut rng)).collect();
        let place: Vec<f64> = (0..(turns * poles as f64 * 40.0) as usize)
            .map(|i| 3.3 + i as f64 / 40.0)
            .collect();
        let at = |p: &f64| off[*p as usize % poles] + (std::f64::consts::TAU * p).sin();
        let error = place
            .iter()
            .map(|p| at(p) + noise * normal(&mut rng))
            .collect();
        (place, error)
    }

    #[test]
    fn poles_that_come_round_again_tell_their_number() {
        for (seed, poles) in [(1, 25), (2, 7), (3, 64)] {
            let (place, error) = ring(seed, poles, 3.4, 0.3);
            assert_eq!(periods_of_turn(&place, &error), Some(poles as u32));
        }
    }

    #[test]
    fn teeth_that_are_passed_once_have_no_turn() {
        let (place, error) = ring(4, 200, 0.9, 0.3);
        assert_eq!(periods_of_turn(&place, &error), None);
        let (place, error) = ring(5, 25, 1.2, 0.3);
        assert_eq!(periods_of_turn(&place, &error), None);
        assert_eq!(periods_of_turn(&[], &[]), None);
        assert_eq!(periods_of_turn(&[1.0, f64::NAN], &[0.0, 1.0]), None);
    }
}
