//! What the text of the pages names: links, files, commands.

use crate::page::{Page, entries};
use clap::CommandFactory;
use clap::error::ErrorKind;
use courier::cli::Cli;
use std::path::Path;

/// Relative links to files that are not there, or to headings that a page does not have.
pub fn broken_links(root: &Path, pages: &[Page]) -> Vec<String> {
    let mut wrong = vec![];
    for page in pages {
        for link in page.links.iter().filter(|link| !is_elsewhere(link)) {
            let (file, anchor) = link.split_once('#').unwrap_or((link, ""));
            let target = if file.is_empty() {
                root.join(&page.name)
            } else {
                root.join(&page.name).parent().unwrap().join(file)
            };
            if !target.exists() {
                wrong.push(format!("{}: the link {link} leads nowhere", page.name));
            } else if !anchor.is_empty() && !anchors(pages, root, &target).any(|it| it == anchor) {
                wrong.push(format!("{}: {link}: no such heading", page.name));
            }
        }
    }
    wrong
}

fn is_elsewhere(link: &str) -> bool {
    ["http://", "https://", "mailto:"]
        .iter()
        .any(|start| link.starts_with(start))
}

fn anchors<'a>(
    pages: &'a [Page],
    root: &'a Path,
    target: &Path,
) -> impl Iterator<Item = &'a String> + use<'a> {
    let target = target.canonicalize().unwrap();
    pages
        .iter()
        .filter(move |page| root.join(&page.name).canonicalize().unwrap() == target)
        .flat_map(|page| &page.anchors)
}

/// Files and folders of the project that the text names in code type, and that are not there.
///
/// A name is taken for one of the project's where it ends as its sources and pages do, or begins with one of its folders. It may
/// leave out the folders before it: `judge/alike.rs`.
pub fn missing_files(root: &Path, pages: &[Page]) -> Vec<String> {
    let files = files(root);
    let folders: Vec<String> = entries(root)
        .iter()
        .filter(|path| path.is_dir())
        .map(|path| path.file_name().unwrap().to_string_lossy().into_owned() + "/")
        .collect();
    let mut wrong = vec![];
    for page in pages {
        for word in page
            .words
            .iter()
            .filter(|word| is_project_s(word, &folders))
        {
            let end = word.trim_end_matches('/');
            let is_there = files.iter().any(|file| {
                file.strip_suffix(end)
                    .is_some_and(|before| before.is_empty() || before.ends_with('/'))
            });
            if !is_there {
                wrong.push(format!("{}: `{word}` is not there", page.name));
            }
        }
    }
    wrong
}

fn is_project_s(word: &str, folders: &[String]) -> bool {
    let is_path = word
        .chars()
        .all(|letter| letter.is_ascii_alphanumeric() || "/._-".contains(letter));
    let ends = [".rs", ".md", ".yml", ".py", ".cff"];
    let is_source = ends
        .iter()
        .any(|end| word.len() > end.len() && word.ends_with(end));
    let is_below =
        folders.iter().any(|folder| word.starts_with(folder)) && !word.starts_with("target/");
    is_path && (is_source || is_below)
}

/// Every file and folder of the project, from its root, what was built and what git keeps aside.
fn files(root: &Path) -> Vec<String> {
    let mut found = vec![];
    let mut folders = vec![root.to_owned()];
    while let Some(folder) = folders.pop() {
        for path in entries(&folder) {
            let name = path
                .strip_prefix(root)
                .unwrap()
                .to_string_lossy()
                .replace('\\', "/");
            if name == ".git" || name.ends_with("target") {
                continue;
            }
            if path.is_dir() {
                folders.push(path);
            }
            found.push(name);
        }
    }
    found
}

/// Commands in code type that name no command or option of `courier`, and no task of `cargo xtask`.
pub fn strange_commands(root: &Path, pages: &[Page]) -> Vec<String> {
    let tasks = tasks(root);
    let mut wrong = vec![];
    for page in pages {
        for words in &page.words {
            let task = words
                .strip_prefix("cargo xtask ")
                .and_then(|rest| rest.split_whitespace().next());
            if task.is_some_and(|task| !tasks.iter().any(|it| it == task)) {
                wrong.push(format!("{}: `{words}`: no such task", page.name));
            }
        }
        for words in page
            .words
            .iter()
            .filter(|words| words.starts_with("courier "))
        {
            let words: Vec<&str> = words
                .split_whitespace()
                .filter(|word| *word != "…")
                .collect();
            let told = Cli::command()
                .allow_negative_numbers(true)
                .try_get_matches_from(&words);
            if let Err(error) = told
                && matches!(
                    error.kind(),
                    ErrorKind::UnknownArgument | ErrorKind::InvalidSubcommand
                )
            {
                wrong.push(format!(
                    "{}: `{}`: {}",
                    page.name,
                    words.join(" "),
                    error.kind()
                ));
            }
        }
    }
    wrong
}

/// The tasks of `cargo xtask`: the lines of its table that hold a name alone.
fn tasks(root: &Path) -> Vec<String> {
    let source = std::fs::read_to_string(root.join("xtask/src/main.rs")).unwrap();
    let names = source.lines().filter_map(|line| {
        let name = line.trim().strip_prefix('"')?.strip_suffix("\",")?;
        name.chars()
            .all(|letter| letter.is_ascii_lowercase() || letter == '-')
            .then(|| name.to_owned())
    });
    names.collect()
}
