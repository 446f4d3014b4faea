//! Held-out pieces of the recording check a set, and can veto it: the evidence trusts the columns, of which some are formed of noisy
//! readings and rebuild noise where amounts nearly cancel; a piece that was not fitted shows that.

use crate::inference::cross_validation::CrossValidation;

/// The effect of a set, told by its block, without which the others predict pieces that they were not fitted to best; none if each predicts
/// them better than the others do without it. Cost: a cross-validation for each effect and one of all; those that were asked for before are
/// known.
pub fn refuted(validation: &mut CrossValidation, set: &[usize]) -> Option<usize> {
    // The baseline is block 0 of the columns and none of the sets.
    let mut left = |blocks: &mut dyn Iterator<Item = &usize>| {
        let blocks: Vec<usize> = blocks.map(|b| b + 1).collect();
        validation.score(&blocks).squares
    };
    let whole = left(&mut set.iter());
    let without = set
        .iter()
        .map(|block| (left(&mut set.iter().filter(|b| *b != block)), *block));
    let least = without.min_by(|a, b| a.0.total_cmp(&b.0));
    least
        .filter(|(left, _)| *left <= whole)
        .map(|(_, block)| block)
}

#[cfg(test)]
mod tests {
    use super::refuted;
    use crate::synthetic_problem::SyntheticProblem;
    use effects::random::normal;

    /// Thirty columns that do nothing predict no piece that they were not fitted to; a column that acts does, beside them or alone.
    #[test]
    fn what_does_not_act_is_vetoed() {
        let idle = [1.0; 30];
        let blocks = [("acts", &[1.0][..]), ("idle", &idle)];
        let problem = SyntheticProblem::new(&blocks, &|rng| {
            let mut row = vec![1.0];
            row.extend((0..31).map(|_| normal(rng)));
            row.push(0.2 * row[1] + normal(rng));
            row
        });
        let mut validation = problem.cross_validation();
        assert_eq!(refuted(&mut validation, &[]), None);
        assert_eq!(refuted(&mut validation, &[0]), None);
        assert_eq!(refuted(&mut validation, &[1]), Some(1));
        assert_eq!(refuted(&mut validation, &[0, 1]), Some(1));
    }
}
