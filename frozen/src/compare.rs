//! How two answers to one specimen may differ.

use crate::Answer;
use serde_json::Value;

/// Numbers may differ by this share of the largest number beside them (in the same list, else by themselves).
///
/// One machine gives the same bits each time. Another may not: nalgebra multiplies matrices by kernels that are chosen when the
/// program runs (with or without fused multiplication), and sums are then rounded elsewhere. What rounding can do is measured by
/// `frozen shake`, which makes every other reading larger by a unit of its last place: at most 2.1e-9 over the twelve of the ordinary test.
/// This leaves room for the larger ones.
pub const RELATIVE: f64 = 1.0e-6;

/// A place where two answers differ.
#[derive(Clone, Debug, PartialEq)]
pub struct Difference {
    /// Where, as a JSON pointer.
    pub at: String,
    /// What was kept.
    pub kept: Value,
    /// What is answered now.
    pub now: Value,
    /// For two numbers: by what share of the largest number beside them. Infinite for all else.
    pub relative: f64,
}

impl std::fmt::Display for Difference {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{}: {} was kept, {} now", self.at, self.kept, self.now)
    }
}

/// Every place where the answers differ by more than `relative`; with zero, every place where their bits do.
///
/// An effect's amounts are compared from the least to the largest: the diagnosis tells them by size, and where two segments share
/// one displacement, with opposite signs, rounding alone decides which of the two comes first.
///
/// # Panics
/// Never: an answer is JSON.
#[must_use]
pub fn compare(kept: &Answer, now: &Answer, relative: f64) -> Vec<Difference> {
    let value = |answer: &Answer| serde_json::to_value(in_order(answer)).unwrap_or_default();
    let mut found = Vec::new();
    walk(&value(kept), &value(now), "", 0.0, &mut found);
    found.retain(|d| d.relative > relative);
    found
}

/// The same answer with each effect's amounts from the least to the largest.
fn in_order(answer: &Answer) -> Answer {
    let mut answer = answer.clone();
    for effect in &mut answer.effects {
        effect.amounts.sort_by(|a, b| a[0].total_cmp(&b[0]));
    }
    answer
}

fn walk(kept: &Value, now: &Value, at: &str, beside: f64, found: &mut Vec<Difference>) {
    match (kept, now) {
        (Value::Array(a), Value::Array(b)) if a.len() == b.len() => {
            let beside = largest(a).max(largest(b)).max(beside);
            for (k, (a, b)) in a.iter().zip(b).enumerate() {
                walk(a, b, &format!("{at}/{k}"), beside, found);
            }
        }
        (Value::Object(a), Value::Object(b)) if a.keys().eq(b.keys()) => {
            for (key, a) in a {
                walk(a, &b[key], &format!("{at}/{key}"), 0.0, found);
            }
        }
        (a, b) if a == b => {}
        (a, b) => found.push(Difference {
            at: at.into(),
            kept: a.clone(),
            now: b.clone(),
            relative: match (a.as_f64(), b.as_f64()) {
                (Some(a), Some(b)) => (a - b).abs() / a.abs().max(b.abs()).max(beside),
                _ => f64::INFINITY,
            },
        }),
    }
}

/// The largest number of a list, by size.
fn largest(list: &[Value]) -> f64 {
    let numbers = list.iter().filter_map(Value::as_f64);
    numbers.fold(0.0, |most, x| most.max(x.abs()))
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::answer::Named;

    fn named(name: &str, weight: f64, amounts: Vec<[f64; 2]>) -> Answer {
        Answer {
            effects: vec![Named {
                name: name.into(),
                weight,
                amounts,
                ..Named::default()
            }],
            ..Answer::default()
        }
    }

    #[test]
    fn numbers_are_compared_with_those_beside_them() {
        let kept = named("a", 0.9, vec![[1.0, 1.0e-12]]);
        assert!(compare(&kept, &kept, 0.0).is_empty());
        let rounded = named("a", 0.9, vec![[1.0 + 1.0e-9, 2.0e-12]]);
        assert_eq!(compare(&kept, &rounded, 0.0).len(), 2);
        assert!(compare(&kept, &rounded, RELATIVE).is_empty());
        let other = named("a", 0.9001, vec![[1.0, 1.0e-12]]);
        assert_eq!(compare(&kept, &other, RELATIVE)[0].at, "/effects/0/weight");
    }

    #[test]
    fn two_amounts_of_one_size_may_come_in_either_order() {
        let kept = named("a", 0.9, vec![[2.0, 0.1], [-2.0, 0.1], [1.0, 0.1]]);
        let other = named("a", 0.9, vec![[-2.0, 0.1], [2.0, 0.1], [1.0, 0.1]]);
        assert!(compare(&kept, &other, RELATIVE).is_empty());
        let turned = named("a", 0.9, vec![[2.0, 0.1], [-2.0, 0.1], [-1.0, 0.1]]);
        assert!(!compare(&kept, &turned, RELATIVE).is_empty());
    }

    #[test]
    fn another_name_or_another_count_is_another_answer() {
        let kept = named("a", 0.9, vec![]);
        let other = named("b", 0.9, vec![]);
        assert_eq!(compare(&kept, &other, RELATIVE).len(), 1);
        let more = named("a", 0.9, vec![[0.0, 0.0]]);
        assert_eq!(compare(&kept, &more, RELATIVE).len(), 1);
        assert_eq!(compare(&kept, &Answer::default(), RELATIVE).len(), 1);
    }
}
