//! Effects that stand on terms which only complete them.

use crate::inference::cross_validation::CrossValidation;
use crate::trace::{log, tracing};

/// A term counts to an effect's core if its prior size is at least this share of the largest.
const CORE_PRIOR_RATIO: f64 = 0.3;
/// The core must take this share of what the effect takes.
const CORE_SHARE: f64 = 0.5;

/// True if an effect beside others stands on terms that only complete it: a shape that happens to look like them, and not the
/// effect.
pub fn lacks_core_terms(validation: &mut CrossValidation, others: &[usize], block: usize) -> bool {
    let columns = validation.columns;
    let size = |c: &usize| columns.regressors[*c].size_m;
    let own = columns.blocks[block].columns.clone();
    let largest = own.clone().map(|c| size(&c)).fold(0.0, f64::max);
    let core: Vec<usize> = own
        .clone()
        .filter(|c| size(c) >= CORE_PRIOR_RATIO * largest)
        .collect();
    if core.len() == own.len() {
        return false;
    }
    let mut list: Vec<usize> = columns.blocks[0].columns.clone().collect();
    for &b in others {
        list.extend(columns.blocks[b].columns.clone());
    }
    list.extend(core);
    let set: Vec<usize> = others.iter().copied().chain([block]).collect();
    let (without, with) = (
        validation.score(others).squares,
        validation.score(&set).squares,
    );
    let by_core = without - validation.score_columns(&list).squares;
    let lacks_core_terms = by_core < CORE_SHARE * (without - with);
    if lacks_core_terms && tracing() {
        let name = &columns.blocks[block].name;
        log(&format!(
            "hollow beside {others:?}: {name}, {by_core:.0} of {:.0} by its core",
            without - with
        ));
    }
    lacks_core_terms
}
