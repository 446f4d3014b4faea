//! Mutations that one build serves: building the image takes ten times what a check does.
//!
//! Those go together whose change is the same, and those that break rules, each another one: a check tells all rules that were broken,
//! and its run goes on. What is shown by words of a check goes alone, since another mutation might be the cause of those words.

use super::copy::{self, Files};
use super::mutations::Mutation;

/// Mutations that are brought in together.
pub type Batch = Vec<&'static Mutation>;

/// The mutations in as few batches as may be.
pub fn of(mutations: &[&'static Mutation], files: &Files) -> Vec<Batch> {
    let mut batches: Vec<Batch> = vec![];
    for mutation in mutations {
        match batches
            .iter_mut()
            .find(|batch| joins(mutation, batch, files))
        {
            Some(batch) => batch.push(mutation),
            None => batches.push(vec![mutation]),
        }
    }
    batches
}

fn joins(mutation: &'static Mutation, batch: &Batch, files: &Files) -> bool {
    let all =
        |may: fn(&Mutation, &Mutation) -> bool| batch.iter().all(|other| may(mutation, other));
    let fits = || {
        let together: Batch = batch.iter().copied().chain([mutation]).collect();
        copy::mutate(files, &together).is_ok()
    };
    all(|a, b| a.edits == b.edits) || all(break_rules) && fits()
}

/// Whether both break rules, and not the same one.
fn break_rules(a: &Mutation, b: &Mutation) -> bool {
    a.rule().is_some() && b.rule().is_some() && a.rule() != b.rule()
}

#[cfg(test)]
mod tests {
    use super::super::mutations::{Edit, MUTATIONS};
    use super::*;
    use std::path::PathBuf;

    fn mutation(name: &'static str, edit: Edit, shows: &'static str) -> &'static Mutation {
        Box::leak(Box::new(Mutation {
            name,
            what: "",
            edits: Box::leak(Box::new([edit])),
            check: "",
            shows,
        }))
    }

    #[test]
    fn rules_go_together_and_words_alone() {
        let edit = |find| Edit {
            file: "a",
            find,
            put: "",
        };
        let one = mutation("one", edit("one"), "first:");
        let two = mutation("two", edit("two"), "second:");
        let same_rule = mutation("same rule", edit("three"), "first:");
        let same_place = mutation("same place", edit("one t"), "third:");
        let words = mutation("words", edit("three"), "words");
        let same_change = mutation("same change", edit("three"), "other words");
        let files = Files::from([(PathBuf::from("a"), b"one two three".to_vec())]);
        let all = [one, two, same_rule, same_place, words, same_change];
        let names = |batch: Batch| batch.iter().map(|it| it.name).collect::<Vec<_>>();
        let found: Vec<_> = of(&all, &files).into_iter().map(names).collect();
        let wanted = [
            vec!["one", "two"],
            vec!["same rule", "same place"],
            vec!["words", "same change"],
        ];
        assert_eq!(found[..2], wanted[..2]);
        assert!(found[2..].concat().contains(&"words"), "{found:?}");
    }

    #[test]
    fn every_mutation_is_in_one_batch() {
        let files = copy::read(&crate::arm::root()).expect("readable");
        let all: Vec<&Mutation> = MUTATIONS.iter().collect();
        let batches = of(&all, &files);
        assert_eq!(batches.concat().len(), MUTATIONS.len());
        assert!(batches.len() < MUTATIONS.len());
    }
}
