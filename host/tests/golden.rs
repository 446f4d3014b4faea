//! Golden tables: what the commands print, line by line. A changed table is a commit of its own that says why;
//! `INSTA_UPDATE=always cargo test -p courier --test golden` writes them anew.

mod common;

use common::courier;

/// The table of the demonstration: one fixed courier, a short run.
#[test]
fn demo_table() {
    let ran = courier(&[
        "demo", "--preset", "ideal", "--plan", "optimal", "--poses", "120", "--seed", "7",
    ]);
    insta::assert_snapshot!(ran.quiet());
}

/// What is foretold of the paper's own motion, before anything moves.
#[test]
fn isolability_table() {
    let ran = courier(&["isolability", "--poses", "200"]);
    insta::assert_snapshot!(ran.quiet());
}
