//! `cargo xtask circles`: no file of a crate takes names from a file that takes names from it, by whatever way.
//!
//! A module that passes names on (`pub use`) is looked through: who uses such a name takes it from the file that defines it.

use crate::source::{Root, modules, names, roots, told};
use anyhow::{Result, ensure};
use petgraph::algo::tarjan_scc;
use petgraph::graphmap::DiGraphMap;
use std::collections::{BTreeMap, BTreeSet};
use std::path::PathBuf;

/// What each file takes from which others.
type Taken = BTreeMap<PathBuf, BTreeMap<PathBuf, BTreeSet<String>>>;

/// Refuses circles in any crate of the project.
///
/// # Errors
/// There is one: its files, and what each takes from the others.
pub fn check() -> Result<()> {
    let mut found = Vec::new();
    for root in roots()? {
        found.extend(circles_of(&root)?);
    }
    ensure!(found.is_empty(), "{}", found.join("\n"));
    println!("0 circles");
    Ok(())
}

/// The circles of a crate, in words.
fn circles_of(root: &Root) -> Result<Vec<String>> {
    let modules = modules::modules(root)?;
    let mut taken = Taken::new();
    for (place, module) in &modules {
        let of_file = taken.entry(module.file.clone()).or_default();
        for (file, names) in names::taken(place, &modules) {
            of_file.entry(file).or_default().extend(names);
        }
    }
    let circles = circles(&taken).into_iter();
    Ok(circles.map(|c| in_words(&c, &taken)).collect())
}

/// Sets of files that reach each other.
fn circles(taken: &Taken) -> Vec<Vec<&PathBuf>> {
    let mut graph = DiGraphMap::<&PathBuf, ()>::new();
    for (file, others) in taken {
        for other in others.keys() {
            graph.add_edge(file, other, ());
        }
    }
    let mut sets = tarjan_scc(&graph);
    sets.retain(|set| set.len() > 1);
    sets.iter_mut().for_each(|set| set.sort());
    sets
}

fn in_words(circle: &[&PathBuf], taken: &Taken) -> String {
    let mut text = format!("a circle of {} files:\n", circle.len());
    for file in circle {
        let others = taken[*file]
            .iter()
            .filter(|(other, _)| circle.contains(other));
        for (other, names) in others {
            let names: Vec<&str> = names.iter().map(String::as_str).collect();
            text += &format!(
                "  {} takes {} from {}\n",
                told(file),
                names.join(", "),
                told(other)
            );
        }
    }
    text
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A crate of these files in a folder that vanishes.
    fn found(files: &[(&str, &str)]) -> Vec<String> {
        let folder = tempfile::tempdir().unwrap();
        for (name, text) in files {
            let path = folder.path().join(name);
            std::fs::create_dir_all(path.parent().unwrap()).unwrap();
            std::fs::write(path, text).unwrap();
        }
        let root = Root {
            path: folder.path().join("lib.rs"),
        };
        circles_of(&root).unwrap()
    }

    #[test]
    fn two_files_that_take_from_each_other_are_a_circle() {
        let a = (
            "a.rs",
            "use crate::b::B;\npub struct A(B);\npub const N: usize = 1;",
        );
        let b = ("b.rs", "pub struct B([u8; super::a::N]);");
        assert_eq!(found(&[("lib.rs", "mod a; mod b;"), a, b]).len(), 1);
        let cut = ("b.rs", "pub struct B([u8; 1]);");
        assert!(found(&[("lib.rs", "mod a; mod b;"), a, cut]).is_empty());
    }

    #[test]
    fn what_is_passed_on_comes_from_where_it_is_defined() {
        // The folder passes on what its file defines, and the file uses what the folder itself passes on from a third.
        let files = [
            ("lib.rs", "mod folder;"),
            (
                "folder/mod.rs",
                "mod one; mod two; pub use one::One; pub use two::Two;",
            ),
            ("folder/one.rs", "use super::Two;\npub struct One(Two);"),
            ("folder/two.rs", "pub struct Two;"),
        ];
        assert!(found(&files).is_empty());
        let mut circle = files;
        circle[1].1 = "mod one; mod two; pub use one::One; pub use two::Two; pub fn f(_: One) {}\npub struct Own;";
        circle[2].1 = "use super::Own;\npub struct One(Own);";
        assert_eq!(found(&circle).len(), 1);
    }

    #[test]
    fn what_only_tests_take_makes_no_circle() {
        let a = ("a.rs", "use crate::b::B;\npub struct A(B);");
        let b = (
            "b.rs",
            "pub struct B;\n#[cfg(test)]\nmod tests { use crate::a::A; fn f(_: A) {} }",
        );
        assert!(found(&[("lib.rs", "mod a; mod b;"), a, b]).is_empty());
    }
}
