//! How much of a gap some columns leave, and whether one of them shows that there is a gap.

use crate::figures::limits::MINIMUM_SQUARES;
use crate::inference::cross_validation::CrossValidation;

/// Whitened squares beyond `floor`, as a share of those of the baseline.
pub fn unexplained_fraction(validation: &mut CrossValidation, blocks: &[usize], floor: f64) -> f64 {
    let whole_gap = (validation.score(&[]).squares - floor).max(MINIMUM_SQUARES);
    let left = validation.score(blocks).squares;
    // What is of no physical size explains nothing.
    if left.is_finite() {
        (left - floor) / whole_gap
    } else {
        1.0
    }
}

/// True if some block stands out beyond chance although the sum of squares does not: it leaves less than the baseline alone, and is
/// likelier. Large amounts that nearly cancel may leave less by the noise that they are allowed for. What it takes below the floor
/// is no gap: the simulator leaves as much.
pub fn stands_out(validation: &mut CrossValidation, floor: f64) -> bool {
    let alone = validation.score(&[]);
    (1..validation.columns.blocks.len()).any(|b| {
        let with = validation.score(&[b]);
        let gain = alone.squares - with.squares.max(floor);
        gain > 2.0 * MINIMUM_SQUARES
            && gain > 0.01 * floor
            && with.log_evidence > alone.log_evidence
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::synthetic_problem::SyntheticProblem;
    use effects::random::{ChaCha8Rng, normal};

    /// Noise stated a little too low. A shape that is there stands out; columns of nothing that carry much noise leave less by what
    /// that is allowed for, and do not.
    #[test]
    fn what_noise_is_allowed_for_does_not_stand_out() {
        const COLUMNS: usize = 20;
        let synthetic_problem = |there: f64, errors_in_variables: f64| {
            let row = |rng: &mut ChaCha8Rng| {
                let columns: Vec<f64> = (0..COLUMNS).map(|_| normal(rng)).collect();
                let target = there * columns[0] + 1.03 * normal(rng);
                [vec![1.0], columns, vec![target]].concat()
            };
            SyntheticProblem::new(&[("block", &[1.0; COLUMNS][..])], &row)
                .with_errors_in_variables(errors_in_variables)
        };
        let shape = synthetic_problem(0.4, 0.0);
        assert!(stands_out(
            &mut shape.cross_validation(),
            shape.cross_validation().rows()
        ));
        let nothing = synthetic_problem(0.0, 9.0);
        let mut validation = nothing.cross_validation();
        let gain = validation.score(&[]).squares - validation.score(&[1]).squares;
        assert!(gain > 2.0 * MINIMUM_SQUARES, "{gain}");
        let floor = validation.rows();
        assert!(!stands_out(&mut validation, floor));
        // Where the simulator leaves as much as the baseline alone there is no gap.
        let mut validation = shape.cross_validation();
        let floor = validation.score(&[]).squares;
        assert!(!stands_out(&mut validation, floor));
    }
}
