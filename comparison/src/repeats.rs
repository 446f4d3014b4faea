//! Repeats of one state: how far they scatter tells what chance is, whatever their covariances say.

use crate::estimate::{Certainty, Estimate};
use crate::significance::JointTest;
use crate::trend::scatter;
use serde::Serialize;

/// Repeats of one state.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Repeats {
    /// How far they scatter about their mean.
    pub test: JointTest,
    /// By how much each ± is raised for it, or lowered where below one: the Birge ratio (Birge 1932, Physical Review 40, 207). One where they scatter less
    /// than chance allows: then they have more in common than their state, as the teeth of one place.
    pub raised: f64,
}

/// Repeats that scatter so little have less than this chance, and tell nothing of it. Derived from what that costs: so often at most is a scale that
/// is right not used.
const TOO_LITTLE: f64 = 1.0e-3;

/// How far the first `count` scatter, which are repeats of one state, and all estimates with covariances that explain it.
///
/// # Errors
/// Fewer than two are repeats, one has no covariance, or nothing is known that all have estimated.
pub fn beside_repeats(
    estimates: &[Estimate],
    count: usize,
) -> Result<(Repeats, Vec<Estimate>), String> {
    let count = count.min(estimates.len());
    let test = scatter(&estimates[..count])?;
    if 1.0 - test.chance < TOO_LITTLE {
        return Ok((Repeats { raised: 1.0, test }, estimates.to_vec()));
    }
    let repeats = Repeats {
        raised: test.mean_square.sqrt(),
        test,
    };
    let directions = repeats.test.directions as f64;
    let deviation = 1.0 - (count as f64).recip();
    let own = deviation * deviation / directions;
    let raise = |(k, of): (usize, &Estimate)| raise(of, &repeats, if k == 0 { own } else { 0.0 });
    let raised = estimates.iter().enumerate().map(raise).collect();
    Ok((repeats, raised))
}

/// The same with a covariance that explains the repeats' scatter, whether that is more or less than the covariance: its degrees of freedom tell
/// how well it is known, and a scale that could only rise would allow for that twice. A pair shares the one scale, so each side has half of
/// its degrees of freedom. The first, against which all others are compared, has a part in the scatter by its deviation from the mean of n
/// repeats, whose variance is `1 - 1/n` of its own: that is its `own` share. Lateral terms are in the scatter.
fn raise(estimate: &Estimate, repeats: &Repeats, own: f64) -> Estimate {
    let raise = |certainty: &Certainty| Certainty {
        covariance: repeats.raised * repeats.raised * &certainty.covariance,
        freedom: certainty.freedom.min(0.5 * repeats.test.directions as f64),
        own,
        lateral: None,
        source: certainty.source.clone(),
    };
    Estimate {
        certainty: estimate.certainty.as_ref().map(raise).map_err(Clone::clone),
        ..estimate.clone()
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::changes::is_change;
    use crate::difference::Difference;
    use crate::difference::tests::of_order;
    use crate::significance::Root;
    use rand_chacha::ChaCha8Rng;
    use rand_chacha::rand_core::SeedableRng;
    use rand_distr::{Distribution, StandardNormal};

    /// Repeats that scatter thirty times as far as is said, a tenth farther, and as said: a fourth of the same state is called changed one
    /// time in twenty, to 2 %. A scale that could only rise was allowed for twice, and one in a thousand was.
    #[test]
    fn one_in_twenty_is_called_changed_beside_repeats() {
        const TRIES: u32 = 2_000;
        let mut rng = ChaCha8Rng::seed_from_u64(393);
        for said_m in [0.03e-6, 0.9e-6, 1.0e-6] {
            let mut of_one_state = || {
                let values = [(); 2].map(|()| -> f64 { StandardNormal.sample(&mut rng) });
                of_order(1, values.map(|value| 1.0e-6 * value), said_m)
            };
            let mut called = 0;
            for _ in 0..TRIES {
                let list = [(); 4].map(|()| of_one_state());
                let (_, raised) = beside_repeats(&list, 3).unwrap();
                let apart = Difference::between(&raised[0], &raised[3]);
                let certainty = apart.certainty.as_ref().unwrap();
                let test = Root::of(&certainty.covariance).test(&apart.values(), certainty.scale());
                called += u32::from(is_change(test.chance));
            }
            let share = f64::from(called) / f64::from(TRIES);
            assert!((share - 0.05).abs() <= 0.02, "{said_m:e}: {share}");
        }
    }

    /// Three of one place, whose teeth they have in common: what they say of chance is no more than nothing.
    #[test]
    fn repeats_that_scatter_less_than_chance_allows_lower_nothing() {
        let list = [0.0, 0.001e-6, 0.002e-6, 0.3e-6].map(|value| of_order(1, [value, 0.0], 0.1e-6));
        let (repeats, raised) = beside_repeats(&list, 3).unwrap();
        assert_eq!(repeats.raised, 1.0);
        assert_eq!(raised, list);
    }
}
