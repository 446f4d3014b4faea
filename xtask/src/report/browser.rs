//! Pages in a headless browser: all of them at once, each in a frame of the wanted width, since no window is narrower than 500 pixels.

use crate::arm::{install, on_path};
use anyhow::{Context, Result, bail, ensure};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Longest that the browser may take.
const PATIENCE: Duration = Duration::from_secs(240);
/// Names under which it is found.
const BROWSERS: [&str; 2] = ["chromium", "chromium-browser"];
/// Looks at a page from within.
const PROBE: &str = include_str!("probe.js");

/// What the probe found in one page at one width.
#[derive(Clone, Debug, PartialEq)]
pub struct Finding {
    /// The page.
    pub page: PathBuf,
    /// Width, CSS pixels.
    pub width: u32,
    /// Number of figures.
    pub figures: u64,
    /// What is wrong.
    pub faults: Vec<String>,
}

/// By day or by night.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Scheme {
    /// Dark letters on a light ground.
    Light,
    /// The other way round.
    Dark,
}

/// The browser, installed if need be; none where it cannot be had.
pub fn find() -> Option<&'static str> {
    let found = || BROWSERS.into_iter().find(|name| on_path(name));
    if let Some(name) = found() {
        return Some(name);
    }
    eprintln!("report: no chromium here; installing Debian's");
    if let Err(error) = install(&["chromium"]) {
        eprintln!("report: SKIPPED, nothing was checked in a browser: {error:#}");
        return None;
    }
    found()
}

/// Opens all pages at all widths and gives what the probe says of each. What it needs is written to `folder`.
///
/// # Errors
/// The browser does not end, or a page says nothing.
pub fn look(
    browser: &str,
    folder: &Path,
    pages: &[PathBuf],
    widths: &[u32],
    scheme: Scheme,
) -> Result<Vec<Finding>> {
    let mut frames = String::new();
    for page in pages {
        let text = std::fs::read_to_string(page).with_context(|| page.display().to_string())?;
        let probed = page.with_extension("probed.html");
        let script = format!("<head><script>{PROBE}</script>");
        std::fs::write(&probed, text.replacen("<head>", &script, 1))?;
        for width in widths {
            frames += &format!(
                "<iframe style=\"width:{width}px;height:900px;border:0\" src=\"file://{}\"></iframe>",
                probed.display()
            );
        }
    }
    let around = folder.join("frames.html");
    std::fs::write(&around, format!("<!DOCTYPE html>{COLLECT}{frames}"))?;
    let mut command = command(browser, folder, scheme);
    command
        .args([
            "--dump-dom",
            "--virtual-time-budget=20000",
            "--window-size=1400,1000",
        ])
        .arg(format!("file://{}", around.display()));
    let document = within(&mut command, folder)?;
    let found = findings(&document)?;
    let wanted = pages.len() * widths.len();
    ensure!(
        found.len() == wanted,
        "found {} pages that the probe ran in, wanted {wanted}",
        found.len()
    );
    Ok(found)
}

/// Keeps what the probes say where the dumped document shows it.
const COLLECT: &str = "<script>const found = []; addEventListener('message', event => { found.push(event.data); \
    document.documentElement.setAttribute('data-found', encodeURIComponent(JSON.stringify(found))); });</script>";

fn findings(document: &str) -> Result<Vec<Finding>> {
    let found = document
        .split("data-found=\"")
        .nth(1)
        .and_then(|rest| rest.split('"').next())
        .context("the probe did not run")?;
    let list: Vec<serde_json::Value> = serde_json::from_str(&decoded(found)?)?;
    let finding = |one: &serde_json::Value| -> Option<Finding> {
        let page = one["page"].as_str()?.strip_prefix("file://")?;
        let faults = one["faults"].as_array()?.iter();
        Some(Finding {
            page: PathBuf::from(page.replace(".probed.html", ".html")),
            width: u32::try_from(one["width"].as_u64()?).ok()?,
            figures: one["figures"].as_u64()?,
            faults: faults
                .filter_map(|f| Some(f.as_str()?.to_owned()))
                .collect(),
        })
    };
    list.iter()
        .map(|one| finding(one).with_context(|| format!("the probe said {one}")))
        .collect()
}

/// Undoes `encodeURIComponent`.
fn decoded(text: &str) -> Result<String> {
    let mut bytes = Vec::new();
    let mut rest = text.bytes();
    while let Some(byte) = rest.next() {
        if byte != b'%' {
            bytes.push(byte);
            continue;
        }
        let digits: String = rest.by_ref().take(2).map(char::from).collect();
        bytes.push(u8::from_str_radix(&digits, 16)?);
    }
    Ok(String::from_utf8(bytes)?)
}

/// A picture of the top of a page.
///
/// # Errors
/// The browser does not end, or writes none.
pub fn picture(browser: &str, folder: &Path, page: &Path, to: &Path, size: [u32; 2]) -> Result<()> {
    let mut command = command(browser, folder, Scheme::Light);
    command
        .arg("--hide-scrollbars")
        .arg(format!("--window-size={},{}", size[0], size[1]))
        .arg(format!("--screenshot={}", to.display()))
        .arg(format!("file://{}", page.display()));
    within(&mut command, folder)?;
    ensure!(
        to.is_file(),
        "{}: the browser wrote no picture",
        to.display()
    );
    Ok(())
}

fn command(browser: &str, folder: &Path, scheme: Scheme) -> Command {
    // Blink's `PreferredColorScheme`: 0 is dark, 1 is light.
    let preferred = match scheme {
        Scheme::Dark => 0,
        Scheme::Light => 1,
    };
    let mut command = Command::new(browser);
    command.args([
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--disable-quic",
        "--no-first-run",
        "--disable-background-networking",
        "--disable-component-update",
        "--disable-sync",
        "--enable-logging=stderr",
    ]);
    command
        .arg(format!("--blink-settings=preferredColorScheme={preferred}"))
        .arg(format!(
            "--user-data-dir={}",
            folder.join("profile").display()
        ));
    command
}

/// Standard output of a browser that must end in time. Its log lies beside it.
fn within(command: &mut Command, folder: &Path) -> Result<String> {
    let (out, err) = (folder.join("document.html"), folder.join("browser.log"));
    command
        .stdin(Stdio::null())
        .stdout(std::fs::File::create(&out)?)
        .stderr(std::fs::File::create(&err)?);
    let mut child = command.spawn().context("the browser")?;
    let begin = Instant::now();
    while child.try_wait()?.is_none() {
        if begin.elapsed() > PATIENCE {
            child.kill()?;
            child.wait()?;
            bail!("the browser did not end within {} s", PATIENCE.as_secs());
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    Ok(String::from_utf8_lossy(&std::fs::read(out)?).into_owned())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_the_probe_says_is_read_from_the_document() {
        let said = r#"[{"page":"file:///t/a.probed.html","width":390,"dark":true,"figures":2,"faults":["µ \"x\""]}]"#;
        let encoded: String = said.bytes().map(|b| format!("%{b:02X}")).collect();
        let found = findings(&format!("<html data-found=\"{encoded}\">")).unwrap();
        let wanted = Finding {
            page: "/t/a.html".into(),
            width: 390,
            figures: 2,
            faults: vec!["µ \"x\"".into()],
        };
        assert_eq!(found, [wanted]);
        assert!(findings("<html>").is_err());
    }
}
