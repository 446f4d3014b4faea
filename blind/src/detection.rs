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

/// Least and largest size of the classes, m: those that were drawn from. Under drawn conditions these follow each courier's noise, and
/// the classes hold all sizes that came.
fn range_m(judged: &[Judged]) -> [f64; 2] {
    let drawn = judged.iter().filter(|j| !j.case.conditions.is_usual());
    let sizes = drawn.flat_map(|j| j.case.effects.iter().map(|effect| effect.size_m));
    sizes
        .map(|size_m| [size_m, size_m])
        .reduce(|[low, high], [size_m, _]| [low.min(size_m), high.max(size_m)])
        .unwrap_or(SIZES_M)
}

/// Of some cases, class by class.
fn classes<'a>(
    judged: impl Iterator<Item = &'a Judged>,
    [low_m, high_m]: [f64; 2],
) -> Vec<Detection> {
    let step = (high_m / low_m).powf(1.0 / SIZE_CLASSES as f64);
    let mut list: Vec<Detection> = (0..SIZE_CLASSES)
        .map(|k| Detection {
            from_m: low_m * step.powi(k as i32),
            to_m: low_m * step.powi(k as i32 + 1),
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
    classes(
        judged.iter().filter(|j| j.case.kind == Kind::Single),
        range_m(judged),
    )
}

/// Effect by effect, and each by size: catalogued ones by themselves, and those that are in no catalogue.
pub(super) fn by_effect(judged: &[Judged]) -> BTreeMap<String, Vec<Detection>> {
    let mut list: BTreeMap<String, Vec<&Judged>> = BTreeMap::new();
    for one in judged {
        if matches!(one.case.kind, Kind::Single | Kind::Unlisted) {
            list.entry(one.truth()[0].into()).or_default().push(one);
        }
    }
    let range_m = range_m(judged);
    list.into_iter()
        .map(|(name, cases)| (name, classes(cases.into_iter(), range_m)))
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::{Case, Conditions, Drawn};
    use diagnosis::verdict::answer::Verdict;

    #[test]
    fn under_drawn_conditions_the_classes_begin_at_the_smallest_size() {
        let judged = [0.02e-6, 9.0e-6].map(|size_m| Judged {
            case: Case {
                number: 0,
                seed: 0,
                kind: Kind::Single,
                effects: vec![Drawn {
                    name: "velocity_lag".into(),
                    size_m,
                }],
                conditions: Conditions::Drawn,
            },
            verdict: Verdict::NoGap,
            named: Vec::new(),
            aliases: Vec::new(),
            stated: Vec::new(),
            places: Vec::new(),
            claim: None,
            without: None,
            hidden: None,
            ideal: None,
        });
        let classes = by_size(&judged);
        let counts: Vec<usize> = classes.iter().map(|class| class.cases).collect();
        assert_eq!(counts, [1, 0, 0, 0, 1]);
        assert!((classes[0].from_m - 0.02e-6).abs() < 1e-12, "{classes:?}");
    }
}
