//! Detection and naming against the size of an effect, and effect by effect.

use crate::judged::Judged;
use serde::{Deserialize, Serialize};
use specimens::{Kind, SIZES_M};
use std::collections::BTreeMap;

/// Classes of size.
const SIZE_CLASSES: usize = 5;

/// Detection and naming of single effects within a class of size.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Detection {
    /// Sizes, m.
    pub from_m: f64,
    /// To, m.
    pub to_m: f64,
    /// Single effects of that size.
    pub cases: usize,
    /// Of them with a gap seen.
    pub detected: usize,
    /// Of them with the first named cause right.
    pub named: usize,
}

/// Of some cases, class by class.
fn classes<'a>(judged: impl Iterator<Item = &'a Judged>) -> Vec<Detection> {
    let step = (SIZES_M[1] / SIZES_M[0]).powf(1.0 / SIZE_CLASSES as f64);
    let mut list: Vec<Detection> = (0..SIZE_CLASSES)
        .map(|k| Detection {
            from_m: SIZES_M[0] * step.powi(k as i32),
            to_m: SIZES_M[0] * step.powi(k as i32 + 1),
            cases: 0,
            detected: 0,
            named: 0,
        })
        .collect();
    for one in judged {
        let size_m = one.case.effects[0].size_m;
        let class = list.iter().rposition(|c| size_m >= c.from_m).unwrap_or(0);
        list[class].cases += 1;
        list[class].detected += usize::from(one.detected());
        list[class].named += usize::from(one.right());
    }
    list
}

/// Single effects by size.
pub(super) fn by_size(judged: &[Judged]) -> Vec<Detection> {
    classes(judged.iter().filter(|j| j.case.kind == Kind::Single))
}

/// Effect by effect, and each by size: catalogued ones by themselves, and those that are in no catalogue.
pub(super) fn by_effect(judged: &[Judged]) -> BTreeMap<String, Vec<Detection>> {
    let mut list: BTreeMap<String, Vec<&Judged>> = BTreeMap::new();
    for one in judged {
        if matches!(one.case.kind, Kind::Single | Kind::Unlisted) {
            list.entry(one.truth()[0].into()).or_default().push(one);
        }
    }
    list.into_iter()
        .map(|(name, cases)| (name, classes(cases.into_iter())))
        .collect()
}
