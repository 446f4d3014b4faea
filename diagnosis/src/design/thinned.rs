//! Fewer samples of a recording, spread over all of it.

use effects::random::{ChaCha8Rng, SeedableRng, index};

/// A mask of about so many of the samples in use: one at random out of each group of neighbours. At regular steps a uniform motion would show the
/// same few phases of its teeth again and again. Pure: the same mask gives the same samples. All of them where there are no more than `most`.
pub fn thinned(mask: &[bool], most: usize) -> Vec<bool> {
    let used: Vec<usize> = (0..mask.len()).filter(|i| mask[*i]).collect();
    let every = used.len().div_ceil(most.max(1)).max(1);
    let mut out = vec![false; mask.len()];
    let mut rng = ChaCha8Rng::seed_from_u64(0);
    for group in used.chunks(every) {
        out[group[index(&mut rng, group.len())]] = true;
    }
    out
}

#[cfg(test)]
mod tests {
    use super::thinned;

    #[test]
    fn few_samples_stay_and_more_are_spread() {
        let few: Vec<bool> = (0..300).map(|i| i % 3 > 0).collect();
        assert_eq!(thinned(&few, 200), few);
        let many = thinned(&few, 60);
        assert!(many.iter().zip(&few).all(|(kept, used)| *used || !kept));
        for part in many.chunks(60) {
            let kept = part.iter().filter(|kept| **kept).count();
            assert!((9..=11).contains(&kept), "{kept} of 60");
        }
        let places: Vec<usize> = (0..300).filter(|i| many[*i]).collect();
        let mut steps: Vec<usize> = places.windows(2).map(|w| w[1] - w[0]).collect();
        steps.sort_unstable();
        assert!(steps[0] < 4 && steps[steps.len() - 1] > 7, "{steps:?}");
    }
}
