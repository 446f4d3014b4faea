//! What the forms of a set's effects lack, as a term of the model: some directions that nobody knows, with a size that is known.
//!
//! A set that leaves squares which other sets take either lacks a cause, or its effects' forms are not exact. The second is a cause of its
//! own, whose directions may be any: `D` columns, orthogonal to all others, with one amplitude (Kennedy and O'Hagan 2001, J. R. Stat. Soc. B
//! 63, 425: a model's own inexactness beside the noise). A companion that takes all of what lacks with few columns is then likelier than
//! that, and one that takes a part of it is not.

use super::noise_scale::{Left, NoiseScale, integrate};
use crate::algebra::statistics::NORMAL_97_5;

/// Rows to each direction that what a form lacks may lie in. Measured (`effects/form_errors.csv`): of what an effect's form lacks a column of another effect takes
/// one part in 630 (independent simulator, 9,400 rows), 810 (drawn couriers, some 30,000) and 1,350 (38,000) in the mean, pairs of which the other takes
/// more than three tenths apart; 16, 37 and 28 rows, of which this is the geometric mean.
const ROWS_PER_DIRECTION: f64 = 25.0;
/// Fewest directions. A prior: the deviations of an effect from its form have a structure of their own, of a few amounts.
const LEAST_DIRECTIONS: f64 = 10.0;
/// Step of the grid of the amplitude's logarithm over the width of the density of `D` squares in it, `√(1 / 2 D)`.
/// Derived from that width: the trapezoid rule is exact to a thousandth at half a deviation.
const STEP: f64 = 0.45;
/// Amplitudes over the noise that are looked at, as logarithms from this on. Derived from what it does: exp(-3) squared adds
/// 0.0025 of the noise to ten directions.
const LEAST: f64 = -3.0;
/// No form lacks more than so many times what it lacks with 95 % probability: of the measured couriers (`effects/inexactness.csv`) none
/// lacks 1.1 times that, and one of the drawn campaigns (seed 6006, number 8) lacks 1.47 times.
pub(super) const AT_MOST: f64 = 1.5;

/// Of the squares over the noise that a set misses those that its effects' forms may lack: what is missed beyond the longest that may lack
/// stays with the noise.
fn relief(missed: f64, lacking: f64) -> f64 {
    let longest = AT_MOST * lacking.max(0.0).sqrt();
    let beyond = (missed.max(0.0).sqrt() - longest).max(0.0);
    (missed.max(0.0) - beyond * beyond).max(0.0)
}

/// Logarithm of the density of so many squares `ρ` beyond the noise, of `lacking` that may lack, over that of noise alone which left none of
/// them. They lie in `D` directions, each with the amplitude `a`, which is half normal, the squares `D a²` at [`NORMAL_97_5`] deviations being
/// `lacking`; noise alone leaves `D` in them: `ln ∫ p(a) (1 + a²)^(−D/2) exp(½ D − ½ (ρ + D) / (1 + a²)) da`. Never above 0.
fn log_density(squares: f64, lacking: f64, directions: f64) -> f64 {
    let step = STEP * (0.5 / directions).sqrt();
    let deviation = (lacking / directions).sqrt() / NORMAL_97_5;
    let at = |amplitude: f64| {
        let variance = 1.0 + amplitude * amplitude;
        -0.5 * directions * (variance.ln() - 1.0 + variance.recip()) - 0.5 * squares / variance
    };
    let least = LEAST.exp();
    let most = AT_MOST * NORMAL_97_5 * deviation;
    if most <= least {
        return at(0.0);
    }
    let prior = |amplitude: f64| {
        let ratio = amplitude / deviation;
        (2.0 / std::f64::consts::PI).sqrt().ln() - deviation.ln() - 0.5 * ratio * ratio
    };
    let count = ((most.ln() - LEAST) / step).ceil() as usize;
    let each = (0..=count).map(|k| {
        let log = LEAST + step * k as f64;
        let amplitude = log.exp();
        prior(amplitude) + log + step.ln() + at(amplitude)
    });
    // Amplitudes below the least do nothing.
    let below = prior(0.0) + least.ln() + at(0.0);
    super::noise_scale::log_sum(each.chain([below])).min(0.0)
}

/// How seldom what a form lacks may pass for a companion by chance. A prior: one wrong companion in fifty couriers, the best of
/// some twenty being looked at.
const BY_CHANCE: f64 = 1.0e-3;

/// Logarithm of the density of the logarithm of the squares that the form of an effect lacks, of `lacking` with 95 % probability: its amplitude
/// is half normal.
pub fn log_density_of_size(squares: f64, lacking: f64) -> f64 {
    let deviations = NORMAL_97_5 * (squares / lacking.max(f64::MIN_POSITIVE)).sqrt();
    (deviations / std::f64::consts::TAU.sqrt()).ln() - 0.5 * deviations * deviations
}

/// Directions that what a form lacks may lie in, of so many rows.
fn directions(rows: f64) -> f64 {
    (rows / ROWS_PER_DIRECTION).max(LEAST_DIRECTIONS)
}

/// Share of what a form lacks that `k` columns take by chance that seldom: of a random one of `D` directions `χ²_k / D`, and that is above
/// `k + 2 √(k x) + 2 x` with less than the probability `e^−x` (Laurent and Massart 2000, Ann. Stat. 28, 1302, lemma 1).
pub fn share_by_chance(columns: f64, rows: f64) -> f64 {
    let seldom = -BY_CHANCE.ln();
    let columns = columns.max(1.0);
    let taken = columns + 2.0 * (columns * seldom).sqrt() + 2.0 * seldom;
    (taken / directions(rows)).min(1.0)
}

/// Squares over the noise at which a set was fitted that it leaves beyond what that noise alone would.
pub fn excess(left: &Left) -> f64 {
    ((left.squares - left.allowance) * (-left.log_noise).exp() - left.degrees).max(0.0)
}

/// The noise under a set whose effects' forms may lack so many squares over the noise at which it was fitted: as [`integrate`], or with what
/// it leaves taken for what lacks, whichever is likelier. Of the squares that it leaves, `others` are of something that the forms do not
/// lack.
pub fn noise(left: &Left, lacking: f64, others: f64, rows: f64) -> NoiseScale {
    let unlocated = lacking / rows;
    let plain = integrate(left, unlocated);
    let missed = excess(left) - others;
    if missed <= 0.0 || lacking <= 0.0 {
        return plain;
    }
    let relief = relief(missed, lacking);
    let relieved = Left {
        squares: left.squares - relief * left.log_noise.exp(),
        log_density: left.log_density + 0.5 * relief,
        ..*left
    };
    let cost = log_density(
        relief.min(AT_MOST * AT_MOST * lacking),
        lacking,
        directions(rows),
    );
    let with = integrate(&relieved, unlocated);
    NoiseScale {
        log_variance: if with.louder + cost > plain.louder {
            with.log_variance
        } else {
            plain.log_variance
        },
        stated: plain.stated.max(with.stated + cost),
        louder: plain.louder.max(with.louder + cost),
    }
}

#[cfg(test)]
mod tests {
    use super::{Left, log_density, log_density_of_size, noise, relief};

    /// A density of the logarithm: its integral is one, and 95 % of it lie below what may lack.
    #[test]
    fn sizes_of_what_lacks_have_a_density() {
        let lacking: f64 = 300.0;
        let step = 0.01;
        let sum = |to: f64| -> f64 {
            let from = (1.0e-8 * lacking).ln();
            let count = ((to.ln() - from) / step) as usize;
            let each = (0..count).map(|k| (from + step * (k as f64 + 0.5)).exp());
            each.map(|squares| step * log_density_of_size(squares, lacking).exp())
                .sum()
        };
        assert!((sum(20.0 * lacking) - 1.0).abs() < 2e-3);
        assert!((sum(lacking) - 0.95).abs() < 2e-3);
    }

    /// Nothing lacks, nothing is gained; what may lack costs its directions, and what may not costs as noise does.
    #[test]
    fn what_may_lack_costs_its_directions_alone() {
        assert!((log_density(100.0, 0.0, 10.0) + 50.0).abs() < 1e-9);
        let may = log_density(5.0e3, 1.0e4, 10.0);
        // Ten directions at 500 squares each: 5 ln 501, beside the width and the prior of the amplitude.
        assert!((-40.0..-30.0).contains(&may), "{may}");
        assert!(log_density(0.0, 1.0e4, 10.0) > -60.0);
    }

    /// Of what is fifty times as much as may lack, most stays with the noise.
    #[test]
    fn what_may_not_lack_stays_with_the_noise() {
        assert_eq!(relief(0.0, 1.0e4), 0.0);
        assert!(relief(5.0e5, 0.0) < 1e-6);
        assert!((relief(5.0e3, 1.0e4) - 5.0e3).abs() < 1e-9);
        let of_much = relief(5.0e5, 1.0e4);
        assert!((1.5e5..2.0e5).contains(&of_much), "{of_much}");
    }

    /// Of 3,000 squares that may lack, 2,000 are lines: these cost as noise does, half of each.
    #[test]
    fn lines_are_nothing_that_lacks() {
        let left = Left {
            log_noise: 0.0,
            log_density: -6500.0,
            squares: 13_000.0,
            allowance: 0.0,
            degrees: 10_000.0,
        };
        let of = |lines: f64| noise(&left, 1.0e4, lines, 1.0e4).stated;
        // 3,000 squares in 400 directions cost 200 ln (1 + 3,000/400), beside half of what noise leaves.
        assert!((of(0.0) + 5428.0).abs() < 60.0, "{}", of(0.0));
        // Near the stated noise a part of them is taken for louder noise.
        assert!(of(2.0e3) < of(0.0) - 300.0, "{}", of(2.0e3));
    }

    /// Against the sum over a fine grid.
    #[test]
    fn the_integral_is_that_of_a_fine_grid() {
        for (squares, lacking) in [(20.0, 30.0), (4.0e3, 1.0e4), (6.0e4, 3.0e4)] {
            let deviation = (lacking / 10.0_f64).sqrt() / 1.96;
            let step = deviation / 4000.0;
            let sum: f64 = (0..32_000)
                .map(|k| {
                    let a = step * (f64::from(k) + 0.5);
                    let v = 1.0 + a * a;
                    let prior = (2.0 / std::f64::consts::PI).sqrt() / deviation
                        * (-0.5 * (a / deviation).powi(2)).exp();
                    let in_them = -5.0 * (v.ln() - 1.0 + 1.0 / v) - 0.5 * squares / v;
                    prior * step * (in_them + 0.5 * squares / 1.0e3).exp()
                })
                .sum();
            let wanted = sum.ln() - 0.5 * squares / 1.0e3;
            let found = log_density(squares, lacking, 10.0);
            assert!(
                (found - wanted).abs() < 0.1,
                "{squares} {lacking}: {found} {wanted}"
            );
        }
    }
}
