//! README and docs are true: every command in them is run and prints what stands there, every link and every file leads
//! somewhere, every command and option that the text names is one.
//!
//! A block after ```` ```console ```` holds commands after `$ `, each with its output; a block after ```` ```sh ```` holds
//! commands to copy, which must succeed. `[..]` in an output stands for what changes from run to run or machine to machine,
//! a line `...` for lines that are left out. `exit-1` after the fence: the block's last command ends with exit code 1.
//! `nightly` after the fence: the block is run by the nightly checks alone, in a shell of its own. `not-run` after the
//! fence: the block is not run, for the reason in `NOT_RUN`.
//!
//! `COURIER_DOCS=overwrite cargo test -p courier --test docs` writes what the commands print now into the pages;
//! `COURIER_DOCS_PAGES=tutorial` runs those pages only whose names hold this word.

mod not_run;
mod page;
mod run;
mod text;

use page::Page;
use std::path::{Path, PathBuf};
use std::sync::Mutex;
use std::sync::atomic::{AtomicUsize, Ordering};
use std::time::Instant;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR"))
        .parent()
        .unwrap()
        .to_owned()
}

/// Fails with all that is wrong.
fn none_wrong(wrong: &[String]) {
    assert!(
        wrong.is_empty(),
        "{} wrong:\n\n{}",
        wrong.len(),
        wrong.join("\n\n")
    );
}

/// Does the same with every page, as many at once as there are cores.
fn each_page(pages: &[Page], work: impl Fn(&Page) + Sync) {
    let next = AtomicUsize::new(0);
    let cores = std::thread::available_parallelism().map_or(1, usize::from);
    std::thread::scope(|scope| {
        for _ in 0..cores {
            scope.spawn(|| {
                while let Some(page) = pages.get(next.fetch_add(1, Ordering::Relaxed)) {
                    work(page);
                }
            });
        }
    });
}

#[cfg(unix)]
#[test]
fn every_command_prints_what_its_page_says() {
    run_pages(false);
}

#[cfg(unix)]
#[test]
#[ignore = "nightly: a minute"]
fn every_long_command_prints_what_its_page_says() {
    run_pages(true);
}

#[cfg(unix)]
fn run_pages(nightly: bool) {
    let root = root();
    let courier = Path::new(env!("CARGO_BIN_EXE_courier"));
    let overwrite = std::env::var_os("COURIER_DOCS").is_some_and(|value| value == "overwrite");
    let only = std::env::var("COURIER_DOCS_PAGES").unwrap_or_default();
    let mut pages = page::all(&root);
    pages.retain(|page| page.name.contains(&only));
    let wrong = Mutex::new(vec![]);
    each_page(&pages, |page| {
        let begin = Instant::now();
        let compared = run::compare(&root, courier, page, nightly);
        if compared.ran > 0 {
            let took_s = begin.elapsed().as_secs();
            println!("{}: {} commands, {took_s} s", page.name, compared.ran);
        }
        if overwrite && compared.renewed != page.text {
            std::fs::write(root.join(&page.name), compared.renewed).unwrap();
        }
        wrong.lock().unwrap().extend(compared.wrong);
    });
    none_wrong(&wrong.into_inner().unwrap());
}

#[test]
fn every_block_of_commands_is_run_or_listed_with_a_reason() {
    none_wrong(&not_run::unlisted(&page::all(&root())));
}

#[test]
fn every_link_leads_somewhere() {
    none_wrong(&text::broken_links(&root(), &page::all(&root())));
}

#[test]
fn every_file_that_the_text_names_is_there() {
    none_wrong(&text::missing_files(&root(), &page::all(&root())));
}

#[test]
fn every_command_that_the_text_names_is_one() {
    none_wrong(&text::strange_commands(&root(), &page::all(&root())));
}
