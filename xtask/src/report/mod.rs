//! `cargo xtask report`: the HTML reports in a real headless browser, at the width of a desk and of a phone, by day and by night.
//!
//! A probe script is added to a copy of each page; what it finds is read from the dumped document. Pages that are broken on purpose show
//! that the probe finds what it looks for. Debian's chromium is installed where it is missing and that is allowed; else this says so
//! and skips.

mod browser;
mod faulty;
mod pages;

use crate::arm::root;
use anyhow::{Context, Result, bail, ensure};
use browser::{Finding, Scheme};
use faulty::{FAULTS, Fault};
use std::path::{Path, PathBuf};

/// Widths of a desk and of a phone, CSS pixels.
const WIDTHS: [u32; 2] = [1280, 390];
/// Where the README's picture of a report lies, its size in pixels, and how large its file may be.
const PICTURE: &str = "docs/report.png";
const PICTURE_PX: [u32; 2] = [1100, 1180];
const PICTURE_BYTES: u64 = 150_000;

/// Makes reports and opens them, or opens those that are named. With `--picture` the README's picture is made anew as well: of the first
/// page that is named, or of an example's report.
///
/// # Errors
/// A page has a fault, the probe overlooks one that was made on purpose, or the picture is too large.
pub fn run(arguments: &[String]) -> Result<()> {
    let (options, named): (Vec<&String>, Vec<&String>) =
        arguments.iter().partition(|a| a.starts_with("--"));
    if let Some(other) = options.iter().find(|o| **o != "--picture") {
        bail!("found {other}, wanted --picture or pages");
    }
    let Some(browser) = browser::find() else {
        return Ok(());
    };
    let folder = root().join("target/report-check");
    if folder.exists() {
        std::fs::remove_dir_all(&folder).with_context(|| folder.display().to_string())?;
    }
    std::fs::create_dir_all(&folder)?;
    let pages = if named.is_empty() {
        pages::make(&folder)?
    } else {
        copies(&folder, &named)?
    };
    for page in &pages {
        let text = std::fs::read_to_string(page).with_context(|| page.display().to_string())?;
        alone(&text).with_context(|| page.display().to_string())?;
    }
    let broken = broken(&folder, &pages)?;
    let all: Vec<PathBuf> = pages
        .iter()
        .chain(broken.iter().map(|b| &b.1))
        .cloned()
        .collect();
    for scheme in [Scheme::Light, Scheme::Dark] {
        let found = browser::look(browser, &folder, &all, &WIDTHS, scheme)?;
        judge(&found, &pages, &broken, scheme)?;
    }
    if !options.is_empty() {
        let page = match (named.is_empty(), pages.first()) {
            (false, Some(page)) => page.clone(),
            _ => pages::pictured(&folder)?,
        };
        picture(browser, &folder, &page)?;
    }
    Ok(())
}

/// Copies of pages of which a probe may lie beside them.
fn copies(folder: &Path, named: &[&String]) -> Result<Vec<PathBuf>> {
    let copy = |(k, from): (usize, &&String)| {
        let to = folder.join(format!("{k}.html"));
        std::fs::copy(from, &to).with_context(|| (*from).clone())?;
        Ok(to)
    };
    named.iter().enumerate().map(copy).collect()
}

/// The first page with a plot, broken in every way that it can be.
fn broken(folder: &Path, pages: &[PathBuf]) -> Result<Vec<(&'static Fault, PathBuf)>> {
    let mut list = Vec::new();
    for page in pages.iter().take(1) {
        let text = std::fs::read_to_string(page)?;
        for fault in FAULTS {
            if let Some(text) = fault.in_page(&text) {
                let path = folder.join(format!("broken-{}.html", fault.name));
                std::fs::write(&path, text)?;
                list.push((fault, path));
            }
        }
    }
    Ok(list)
}

/// No page has a fault, and every broken one has its own at some width.
fn judge(
    found: &[Finding],
    pages: &[PathBuf],
    broken: &[(&'static Fault, PathBuf)],
    scheme: Scheme,
) -> Result<()> {
    let mut faults = Vec::new();
    for finding in found.iter().filter(|f| pages.contains(&f.page)) {
        let name = finding.page.file_name().unwrap_or_default().display();
        let what = format!("{name}, {} wide, {scheme:?}", finding.width);
        eprintln!(
            "report: {what}: {} figures, {} faults",
            finding.figures,
            finding.faults.len()
        );
        if finding.figures == 0 && !name.to_string().starts_with("insufficient") {
            faults.push(format!("{what}: no figure"));
        }
        faults.extend(
            finding
                .faults
                .iter()
                .map(|fault| format!("{what}: {fault}")),
        );
    }
    for (fault, path) in broken {
        let said = found
            .iter()
            .filter(|f| f.page == *path)
            .flat_map(|f| &f.faults);
        let list: Vec<&String> = said.collect();
        if !list.iter().any(|s| s.contains(fault.said)) {
            faults.push(format!(
                "the probe overlooks a page that is {}: it says {list:?}",
                fault.name
            ));
        }
    }
    ensure!(faults.is_empty(), "{}", faults.join("\n"));
    Ok(())
}

/// What a page needs to stand by itself.
fn alone(page: &str) -> Result<()> {
    for wanted in [
        "<!DOCTYPE html>",
        "lang=\"en\"",
        "name=\"viewport\"",
        "Content-Security-Policy",
        "prefers-color-scheme:dark",
    ] {
        ensure!(page.contains(wanted), "{wanted} is not in it");
    }
    for foreign in [
        "src=\"http",
        "href=\"http",
        "url(http",
        "@import",
        "<script src",
    ] {
        ensure!(
            !page.contains(foreign),
            "found {foreign}, wanted a page that needs nothing else"
        );
    }
    Ok(())
}

/// The README's picture: the top of a report.
fn picture(browser: &str, folder: &Path, page: &Path) -> Result<()> {
    let to = root().join(PICTURE);
    browser::picture(browser, folder, page, &to, PICTURE_PX)?;
    let size = std::fs::metadata(&to)?.len();
    ensure!(
        size <= PICTURE_BYTES,
        "{PICTURE}: found {size} bytes, wanted at most {PICTURE_BYTES}"
    );
    eprintln!("report: {PICTURE}, {size} bytes");
    Ok(())
}
