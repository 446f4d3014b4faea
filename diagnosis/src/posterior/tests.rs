//! Simulation-based calibration: problems drawn from the prior itself, whose posterior must be right as often as it says (Talts and others
//! 2018, arXiv 1804.06788; of the probabilities of sets: Schad and others 2023, Psychological Methods 28, 1404).

mod full_size;

use super::evidence::given;
use super::least_size::{SetAtSizes, least_squares, log_normal};
use super::problem::{Prior, Problem};
use super::reduced::Reduced;
use super::scale::{RANGE, draw};
use super::sets::weigh;
use crate::synthetic_problem::SyntheticProblem;
use effects::random::{ChaCha8Rng, SeedableRng, normal, uniform};
use nalgebra::DVector;

const ROWS: usize = 200;
const BLOCKS: [(&str, usize); 3] = [("one", 2), ("other", 3), ("third", 4)];
/// Probability that each acts: often enough that a few hundred problems show it.
const ACTS: f64 = 0.3;

/// A kind of problem.
#[derive(Clone, Copy)]
struct Kind {
    /// What a coefficient of the stated size does in a row, over the noise.
    size: f64,
    /// Probability that the noise is louder than stated by any factor.
    louder: f64,
}

const KINDS: [Kind; 2] = [
    Kind {
        size: 1.0,
        louder: 0.1,
    },
    // So little that the least size cuts off a good part of the prior, and that no amount could be worth a name above louder noise.
    Kind {
        size: 0.15,
        louder: 0.0,
    },
];

/// What one problem shows.
struct Drawn {
    /// Of each effect: the probability that it acts, and whether it does.
    acts: Vec<(f64, bool)>,
    /// Of each coefficient of the true set: its error in standard deviations.
    errors: Vec<f64>,
}

impl Drawn {
    /// What weighing a problem shows, of which the true set is known with its sizes, amounts and noise.
    fn of(problem: &Problem, set: &[usize], (sizes, truth): (&[f64], &[f64]), noise: f64) -> Self {
        let all = weigh(problem);
        let weights: Vec<f64> = all.iter().map(|w| w.log_weight(problem.log_odds)).collect();
        let total = super::noise_scale::log_sum(weights.iter().copied());
        let acts = |effect: &Prior| {
            let with = all.iter().zip(&weights);
            let with = with.filter(|(w, _)| w.set().contains(&effect.block));
            let probability = with.map(|(_, weight)| (weight - total).exp()).sum::<f64>();
            (probability, set.contains(&effect.block))
        };
        let fit = given(problem.reduced, set, sizes, noise).unwrap();
        let columns = problem.reduced.columns(set);
        let deviations = fit.eliminated.variances();
        let error =
            |(k, c): (usize, &usize)| (truth[*c] - fit.coefficients[k]) / deviations[k].sqrt();
        Self {
            acts: problem.effects.iter().map(acts).collect(),
            errors: columns.iter().enumerate().map(error).collect(),
        }
    }
}

/// Draws a problem from the prior and weighs it.
fn drawn(kind: Kind, rng: &mut ChaCha8Rng) -> Drawn {
    let width: usize = BLOCKS.iter().map(|b| b.1).sum();
    let mut rows: Vec<Vec<f64>> = (0..ROWS)
        .map(|_| {
            let common = normal(rng);
            let columns = (0..width).map(|_| kind.size * (0.5 * common + normal(rng)));
            [1.0].into_iter().chain(columns).chain([0.0]).collect()
        })
        .collect();
    let stated = uniform(rng, 0.0, 1.0) >= kind.louder;
    let log_noise = if stated {
        super::noise_scale::STATED_TO * normal(rng)
    } else {
        uniform(rng, 0.0, super::noise_scale::LOUDEST)
    };
    let there: Vec<bool> = BLOCKS
        .iter()
        .map(|_| uniform(rng, 0.0, 1.0) < ACTS)
        .collect();
    let exact = SyntheticProblem::of_rows(1, &BLOCKS, &rows).reduced(&[1, 2, 3]);
    let set: Vec<usize> = (0..BLOCKS.len()).filter(|b| there[*b]).collect();
    let (sizes, truth) = worth_naming(&exact, &set, log_noise.exp(), rng);
    for row in &mut rows {
        let sum: f64 = row[1..=width].iter().zip(&truth).map(|(c, a)| c * a).sum();
        row[width + 1] = sum + (0.5 * log_noise).exp() * normal(rng);
    }
    let reduced = SyntheticProblem::of_rows(1, &BLOCKS, &rows).reduced(&[1, 2, 3]);
    let odds = |p: f64| (p / (1.0 - p)).ln();
    let prior = |block| Prior {
        block,
        log_odds: odds(ACTS),
        inexactness: 0.0,
        shape: false,
        listed: true,
    };
    let effects: Vec<Prior> = (0..BLOCKS.len()).map(prior).collect();
    let problem = Problem::of_unit_noise(&reduced, &effects, odds(kind.louder));
    Drawn::of(&problem, &set, (&sizes, &truth), log_noise.exp())
}

/// The logarithms of the variances of a set's effects, and all amounts, from the prior cut off below the least size.
fn worth_naming(
    reduced: &Reduced,
    set: &[usize],
    noise: f64,
    rng: &mut ChaCha8Rng,
) -> (Vec<f64>, Vec<f64>) {
    loop {
        let sizes: Vec<f64> = set.iter().map(|_| draw(rng)).collect();
        let inside = |size: &f64| (2.0 * RANGE[0]..2.0 * RANGE[1]).contains(size);
        if !sizes.iter().all(inside) {
            continue;
        }
        let mut truth = vec![0.0; reduced.centre.len()];
        for (block, size) in set.iter().zip(&sizes) {
            for column in reduced.blocks[*block].clone() {
                truth[column] = (0.5 * size).exp() * normal(rng);
            }
        }
        let set_at_sizes = SetAtSizes {
            reduced,
            set,
            log_variances: &sizes,
            noise,
        };
        let worth = |k: usize| {
            let amounts = truth[reduced.blocks[set[k]].clone()].to_vec();
            let own = set_at_sizes.own_power(k, &DVector::from_vec(amounts));
            own.unwrap().power > least_squares(reduced.rows)
        };
        if (0..set.len()).all(worth) {
            return (sizes, truth);
        }
    }
}

/// Checks so many problems.
fn check(kind: Kind, problems: u64) {
    let all: Vec<Drawn> = (0..problems)
        .map(|seed| drawn(kind, &mut ChaCha8Rng::seed_from_u64(seed)))
        .collect();
    are_calibrated(&all);
}

/// Of problems that were drawn from the prior an effect acts as often as its probability says, over all and in each part of the scale, and coefficients
/// scatter about their means as their covariance says.
fn are_calibrated(all: &[Drawn]) {
    let acts: Vec<(f64, bool)> = all.iter().flat_map(|d| d.acts.iter().copied()).collect();
    for [low, high] in [
        [0.0, 1.1],
        [0.0, 0.05],
        [0.05, 0.5],
        [0.5, 0.95],
        [0.95, 1.1],
    ] {
        let within: Vec<_> = acts.iter().filter(|a| (low..high).contains(&a.0)).collect();
        let expected: f64 = within.iter().map(|a| a.0).sum();
        let variance: f64 = within.iter().map(|a| a.0 * (1.0 - a.0)).sum();
        let found = within.iter().filter(|a| a.1).count() as f64;
        let off = (found - expected) / variance.max(1.0).sqrt();
        println!(
            "{low} to {high}: {} effects, {expected:.1} expected, {found} act, {off:.2} deviations off",
            within.len()
        );
        assert!(off.abs() < 4.0, "{low} to {high}: {found} of {expected}");
    }
    let errors: Vec<f64> = all.iter().flat_map(|d| d.errors.iter().copied()).collect();
    let count = errors.len() as f64;
    let squares: f64 = errors.iter().map(|e| e * e).sum::<f64>() / count;
    // Those of one problem go together, and a prior that is cut off is no normal one: the tolerance is of a tenth besides chance.
    assert!(
        (squares - 1.0).abs() < 0.1 + 4.0 * (2.0 / count).sqrt(),
        "{squares}"
    );
    // Ranks of the truth among the posterior's draws are even: a tenth of them in each tenth.
    let mut tenths = [0.0; 10];
    for e in &errors {
        tenths[((log_normal(*e).exp() * 10.0) as usize).min(9)] += 1.0;
    }
    let chi_square: f64 = tenths
        .iter()
        .map(|t| (t - 0.1 * count).powi(2) / (0.1 * count))
        .sum();
    println!(
        "{count} coefficients: mean square {squares:.3}, ranks {tenths:?}, chi square {chi_square:.1}"
    );
    // One draw in ten thousand of a chi-square with 9 degrees of freedom is above, as tables have it.
    assert!(chi_square < 33.7, "{tenths:?}");
}

#[test]
fn the_posterior_is_right_as_often_as_it_says() {
    KINDS.into_iter().for_each(|kind| check(kind, 150));
}

/// The same of many more: `cargo test -p diagnosis --release --lib posterior::tests -- --ignored --nocapture`.
#[test]
#[ignore = "nightly: a minute"]
fn the_posterior_is_right_as_often_as_it_says_of_many() {
    KINDS.into_iter().for_each(|kind| check(kind, 4000));
}
