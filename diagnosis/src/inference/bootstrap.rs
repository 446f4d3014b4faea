//! 95 % intervals of an rms from the pieces that it is made of: bootstrap of the studentised logarithm (Efron and Tibshirani
//! 1993, section 12.5), which has its level with few and with skewed pieces, where percentiles are too narrow.

use crate::algebra::statistics::NORMAL_97_5;
use effects::random::{ChaCha8Rng, SeedableRng, index};

/// Draws of the bootstrap. Derived from the quantiles that are read (Davison and Hinkley 1997): 2.5 % of one more than 999 is a
/// whole number, and its coverage is known to half a percent.
const BOOTSTRAP_DRAWS: usize = 999;

/// Squares of the residual and of the noise in a piece, and its number of rows.
pub type Piece = [f64; 3];

/// Logarithm of a ratio of the pieces' sums, and its standard error by linearisation.
#[derive(Clone, Copy)]
struct LogRatio {
    log: f64,
    error: f64,
}

impl LogRatio {
    /// Of squares over a weight: an index of [`Piece`].
    fn of<'a>(pieces: impl Iterator<Item = &'a Piece>, weight: usize) -> Self {
        let (mut count, mut sum, mut weights) = (0.0, 0.0, 0.0);
        let [mut ss, mut sw, mut ww] = [0.0; 3];
        for piece in pieces {
            let (s, w) = (piece[0], piece[weight]);
            count += 1.0;
            sum += s;
            weights += w;
            ss += s * s;
            sw += s * w;
            ww += w * w;
        }
        let ratio = sum / weights;
        let scatter = (ss - 2.0 * ratio * sw + ratio * ratio * ww).max(0.0);
        Self {
            log: ratio.ln(),
            error: (scatter * count / (count - 1.0)).sqrt() / sum,
        }
    }
}

/// Ends of the interval that the rms was estimated to, over the rms. The noise's own rms is known, and the same whichever pieces are
/// drawn.
pub fn estimated(pieces: &[Piece]) -> [f64; 2] {
    let weight = if pieces.iter().all(|p| p[1] > 0.0) {
        1
    } else {
        2
    };
    let here = LogRatio::of(pieces.iter(), weight);
    let mut draw = drawing(pieces, weight);
    let deviations = quantiles(|| {
        let drawn = draw();
        (drawn.log - here.log) / drawn.error
    });
    let end = |deviation: f64| (-0.5 * deviation * here.error).exp();
    [end(deviations[1]), end(deviations[0])]
}

/// Ends of the interval that the rms of as many other pieces is in, over the rms of these: of two that scatter alike.
pub fn foretold(pieces: &[Piece]) -> [f64; 2] {
    let here = LogRatio::of(pieces.iter(), 2);
    let mut draw = drawing(pieces, 2);
    let deviations = quantiles(|| {
        let (one, other) = (draw(), draw());
        (other.log - one.log) / one.error.hypot(other.error)
    });
    let both = here.error * std::f64::consts::SQRT_2;
    deviations.map(|deviation| (0.5 * deviation * both).exp())
}

/// 97.5 % point of Student's distribution, from one degree of freedom on.
const STUDENT_97_5: [f64; 9] = [
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262,
];
/// Fewer runs do not tell how runs differ. Derived from the degrees of freedom: the scatter of two has one, whose 97.5 % point of
/// Student's distribution is 12.7.
const FEWEST_RUNS: usize = 3;

/// Half of the 95 % interval of the logarithm of the noise's rms in as many other runs, about that of these: squares and number
/// of each.
pub fn other_runs(runs: &[[f64; 2]]) -> f64 {
    if runs.len() < FEWEST_RUNS {
        return 0.0;
    }
    let levels: Vec<f64> = runs.iter().map(|r| 0.5 * (r[0] / r[1]).ln()).collect();
    let freedom = (runs.len() - 1) as f64;
    let scatter =
        crate::algebra::statistics::deviation(&levels) * (levels.len() as f64 / freedom).sqrt();
    let whole: f64 = runs.iter().map(|r| r[1]).sum();
    let shares: f64 = runs.iter().map(|r| (r[1] / whole).powi(2)).sum();
    let student = STUDENT_97_5.get(runs.len() - 2).unwrap_or(&NORMAL_97_5);
    student * scatter * (2.0 * shares).sqrt()
}

/// Levels of as many pieces drawn again from these.
fn drawing(pieces: &[Piece], weight: usize) -> impl FnMut() -> LogRatio + '_ {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    move || {
        let drawn: Vec<&Piece> = (0..pieces.len())
            .map(|_| &pieces[index(&mut rng, pieces.len())])
            .collect();
        LogRatio::of(drawn.into_iter(), weight)
    }
}

/// 97.5 % point of the ratio of two mean squares with two degrees of freedom each (Fisher's F: p / (1 - p) there).
const FISHER_2_2_97_5: f64 = 39.0;

/// 95 % interval of an rms, m, on another recording, where all but `known_m` of it is a wander whose course is another one there. A
/// wander is known by a sine and a cosine at the least, however many periods of it are seen: two degrees of freedom.
pub fn other_course(rms_m: f64, known_m: f64) -> [f64; 2] {
    let wander = (rms_m * rms_m - known_m * known_m).max(0.0);
    [1.0 / FISHER_2_2_97_5, FISHER_2_2_97_5]
        .map(|ratio| known_m.min(rms_m).hypot((wander * ratio).sqrt()))
}

/// Lower and upper 2.5 % of what is drawn, no farther out than Student's of one degree of freedom: where one piece holds nearly all,
/// draws without it seem to be sure. Draws of one piece alone tell nothing.
fn quantiles(mut deviation: impl FnMut() -> f64) -> [f64; 2] {
    let mut list: Vec<f64> = (0..BOOTSTRAP_DRAWS)
        .map(|_| deviation())
        .filter(|d| d.is_finite())
        .collect();
    list.sort_by(f64::total_cmp);
    let tail = list.len() / 40;
    match list.len() {
        0 => [0.0; 2],
        count => {
            [list[tail], list[count - 1 - tail]].map(|d| d.clamp(-STUDENT_97_5[0], STUDENT_97_5[0]))
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use effects::random::normal;

    /// Courses of as many flaws, each of one period, whose sine and cosine are another recording's own.
    fn wander(flaws: usize, rng: &mut ChaCha8Rng) -> f64 {
        let squares = (0..2 * flaws).map(|_| normal(rng).powi(2));
        squares.sum::<f64>() / flaws as f64
    }

    #[test]
    fn another_course_is_within_what_is_foretold() {
        const PAIRS: usize = 2000;
        let pairs = PAIRS as f64;
        for flaws in [1, 3] {
            let mut rng = ChaCha8Rng::seed_from_u64(11);
            let covered = (0..PAIRS).filter(|_| {
                let [here, there] = [0, 1].map(|_| (1.0 + 9.0 * wander(flaws, &mut rng)).sqrt());
                let [low, high] = other_course(here, 1.0);
                (low..=high).contains(&there)
            });
            let least = 0.95 * pairs - 3.0 * (0.95 * 0.05 * pairs).sqrt();
            let covered = covered.count() as f64;
            assert!(covered >= least, "{covered}, {flaws} flaws");
        }
    }

    /// Draws without the one loud piece are all alike, and say nothing of how loud another may be.
    #[test]
    fn one_loud_piece_does_not_make_an_interval_without_end() {
        let mut rng = ChaCha8Rng::seed_from_u64(12);
        let mut pieces: Vec<Piece> = (0..200)
            .map(|_| [50.0 * (0.01 * normal(&mut rng)).exp(), 50.0, 50.0])
            .collect();
        pieces[77][0] = 1.0e5;
        let [low, high] = estimated(&pieces);
        // The logarithm of a sum that is one piece's has an error of one.
        assert!(
            low < 1.0 && high > 1.0 && high < (0.5 * STUDENT_97_5[0]).exp() * 1.1,
            "{low} {high}"
        );
    }
}
