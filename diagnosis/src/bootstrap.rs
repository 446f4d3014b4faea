//! 95 % intervals of an rms from the pieces that it is made of: bootstrap of the studentised logarithm (Efron and Tibshirani
//! 1993, section 12.5), which has its level with few and with skewed pieces, where percentiles are too narrow.

use effects::random::{ChaCha8Rng, SeedableRng, index};

/// Draws of the bootstrap.
const DRAWS: usize = 999;

/// Squares of the residual and of the noise in a piece, and its number of rows.
pub type Piece = [f64; 3];

/// Logarithm of a ratio of the pieces' sums, and its standard error by linearisation.
#[derive(Clone, Copy)]
struct Level {
    log: f64,
    error: f64,
}

impl Level {
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
    let here = Level::of(pieces.iter(), weight);
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
    let here = Level::of(pieces.iter(), 2);
    let mut draw = drawing(pieces, 2);
    let deviations = quantiles(|| {
        let (one, other) = (draw(), draw());
        (other.log - one.log) / one.error.hypot(other.error)
    });
    let both = here.error * std::f64::consts::SQRT_2;
    deviations.map(|deviation| (0.5 * deviation * both).exp())
}

/// 97.5 % point of Student's distribution, from one degree of freedom on.
const STUDENT: [f64; 9] = [
    12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262,
];
/// The same of more.
const NORMAL: f64 = 1.96;
/// Fewer runs do not tell how runs differ.
const FEWEST_RUNS: usize = 3;

/// Half of the 95 % interval of the logarithm of the noise's rms in as many other runs, about that of these: squares and number
/// of each.
pub fn other_runs(runs: &[[f64; 2]]) -> f64 {
    if runs.len() < FEWEST_RUNS {
        return 0.0;
    }
    let levels: Vec<f64> = runs.iter().map(|r| 0.5 * (r[0] / r[1]).ln()).collect();
    let freedom = (runs.len() - 1) as f64;
    let scatter = crate::statistics::deviation(&levels) * (levels.len() as f64 / freedom).sqrt();
    let whole: f64 = runs.iter().map(|r| r[1]).sum();
    let shares: f64 = runs.iter().map(|r| (r[1] / whole).powi(2)).sum();
    let student = STUDENT.get(runs.len() - 2).unwrap_or(&NORMAL);
    student * scatter * (2.0 * shares).sqrt()
}

/// Levels of as many pieces drawn again from these.
fn drawing(pieces: &[Piece], weight: usize) -> impl FnMut() -> Level + '_ {
    let mut rng = ChaCha8Rng::seed_from_u64(7);
    move || {
        let drawn: Vec<&Piece> = (0..pieces.len())
            .map(|_| &pieces[index(&mut rng, pieces.len())])
            .collect();
        Level::of(drawn.into_iter(), weight)
    }
}

/// Lower and upper 2.5 % of what is drawn; draws of one piece alone tell nothing.
fn quantiles(mut deviation: impl FnMut() -> f64) -> [f64; 2] {
    let mut list: Vec<f64> = (0..DRAWS)
        .map(|_| deviation())
        .filter(|d| d.is_finite())
        .collect();
    list.sort_by(f64::total_cmp);
    let tail = list.len() / 40;
    match list.len() {
        0 => [0.0; 2],
        count => [list[tail], list[count - 1 - tail]],
    }
}
