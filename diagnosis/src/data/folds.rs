//! Parts of a recording that are held out in turn.

/// Folds of the cross-validation. As is usual (Hastie, Tibshirani and Friedman 2009, section 7.10): with five a fit has four
/// fifths of the samples, and the cost is five times one.
pub const FOLDS: usize = 5;

/// Fold of each sample: pieces of runs, never single samples; a place that is passed twice falls into different folds.
pub fn folds(stretch: &[usize]) -> Vec<u8> {
    let mut out = vec![0; stretch.len()];
    let mut start = 0;
    while start < stretch.len() {
        let end = (start..stretch.len())
            .find(|&i| stretch[i] != stretch[start])
            .unwrap_or(stretch.len());
        let length = end - start;
        let pieces = (length / 20).clamp(1, 4 * FOLDS);
        for (k, fold) in out[start..end].iter_mut().enumerate() {
            // Stepping by two folds from run to run parts there from back.
            *fold = ((k * pieces / length + 2 * stretch[start]) % FOLDS) as u8;
        }
        start = end;
    }
    out
}
