//! How well any claim can foretell what a pair that wanders leaves on the next recording: the bound beside which the claims of
//! `quadrature_drift` are to be read.
//!
//! The amounts of a pair follow a law of chance over time. Their mean over the first recording is what equation (3) is calibrated at;
//! what the second leaves is its course about that mean. A claim is right if the second comes within 10 % of it.

use anyhow::Result;
use effects::random::{ChaCha8Rng, SeedableRng, normal};

/// Pairs of recordings that a share is counted over: told to a percent.
const PAIRS: usize = 4000;
/// Moments of a recording.
const MOMENTS: usize = 60;
/// How near a claim is asked to come.
const NEAR: f64 = 0.1;
/// Factors that a claim is tried with: steps of a percent from a seventh to seven.
const FACTORS: i32 = 200;
/// Times after which an amount has forgotten 1/e of where it was, over the recording's.
const MEMORIES: [f64; 5] = [0.05, 0.15, 0.3, 1.0, 10.0];
/// Amounts that wander: offsets, gains and angles of some of the four pairs.
const AMOUNTS: [usize; 4] = [1, 2, 4, 8];

/// Prints, for each law, how often the best claim comes within 10 %: of one who has the first recording and the best factor to its rms,
/// and of one who knows the law and its size.
pub fn run() -> Result<()> {
    println!("| memory, recordings | amounts | best by one recording | by the law and its size |");
    println!("|--------------------|---------|-----------------------|-------------------------|");
    for memory in MEMORIES {
        for amounts in AMOUNTS {
            let [recording, law] = shares(memory, amounts).map(|share| 100.0 * share);
            println!("| {memory:18} | {amounts:7} | {recording:19.0} % | {law:21.0} % |");
        }
    }
    Ok(())
}

/// Shares of recordings that the best claim comes within 10 % of, by the first recording's rms and by the law's size.
fn shares(memory: f64, amounts: usize) -> [f64; 2] {
    let mut rng = ChaCha8Rng::seed_from_u64(1);
    let mut ratios = [Vec::new(), Vec::new()];
    for _ in 0..PAIRS {
        let (mut first, mut second, mut size) = (0.0, 0.0, 0.0);
        for _ in 0..amounts {
            let square = normal(&mut rng).powi(2);
            let [here, there] = [0, 1].map(|_| course(&mut rng, memory));
            let mean = here.iter().sum::<f64>() / MOMENTS as f64;
            let about = |course: &[f64]| course.iter().map(|v| (v - mean).powi(2)).sum::<f64>();
            first += square * about(&here) / MOMENTS as f64;
            second += square * about(&there) / MOMENTS as f64;
            size += square;
        }
        ratios[0].push((first / second).sqrt());
        ratios[1].push((size / second).sqrt());
    }
    ratios.map(|list| best(&list))
}

/// An amount's course over a recording: of unit variance, forgotten to 1/e after `memory` of it (Uhlenbeck and Ornstein 1930).
fn course(rng: &mut ChaCha8Rng, memory: f64) -> Vec<f64> {
    let stays = (-1.0 / (memory * MOMENTS as f64)).exp();
    let mut now = normal(rng);
    let next = |_| {
        now = stays * now + (1.0 - stays * stays).sqrt() * normal(rng);
        now
    };
    (0..MOMENTS).map(next).collect()
}

/// Largest share of claims over what comes that one factor brings within 10 %.
fn best(ratios: &[f64]) -> f64 {
    let right = |factor: f64| {
        let near = ratios.iter().filter(|r| (factor * **r - 1.0).abs() <= NEAR);
        near.count() as f64 / ratios.len() as f64
    };
    let factors = (-FACTORS..=FACTORS).map(|k| (0.01 * f64::from(k)).exp());
    factors.map(right).fold(0.0, f64::max)
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Many amounts that are soon forgotten come alike each time; one that is hardly forgotten tells nothing of the next.
    #[test]
    fn what_is_soon_forgotten_is_foretold_and_what_stays_is_not() {
        let [soon, late] =
            [(0.01, 200), (10.0, 1)].map(|(memory, amounts)| shares(memory, amounts));
        assert!(soon.iter().all(|share| *share > 0.95), "{soon:?}");
        assert!(late.iter().all(|share| *share < 0.2), "{late:?}");
    }
}
