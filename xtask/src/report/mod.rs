//! `cargo xtask report`: the HTML reports in a real headless browser, at the width of a desk and of a phone.
//!
//! A probe script is added to a copy of each page; what it finds is read from the dumped document, what the console says from
//! the browser's log. Debian's chromium is installed where it is missing and that is allowed; else this says so and skips.

use crate::arm::{install, on_path, root};
use crate::cargo;
use anyhow::{Context, Result, bail, ensure};
use std::path::{Path, PathBuf};
use std::process::{Command, Stdio};
use std::time::{Duration, Instant};

/// Widths of a desk and of a phone, CSS pixels.
const WIDTHS: [u32; 2] = [1280, 390];
/// Longest that a page may take.
const PATIENCE: Duration = Duration::from_secs(120);
/// Names under which the browser is found.
const BROWSERS: [&str; 2] = ["chromium", "chromium-browser"];

/// Runs after the page has loaded and sends its findings to the frame around it.
const PROBE: &str = r#"<script>
window.faults = [];
addEventListener('error', event => faults.push(event.message), true);
addEventListener('load', () => {
  const page = document.documentElement, list = query => [...document.querySelectorAll(query)];
  const seen = element => element.getClientRects().length > 0;
  const wide = list('body *').filter(e => !e.closest('.scroll') && e.getBoundingClientRect().right > page.clientWidth + 1);
  if (page.scrollWidth > innerWidth) faults.push('overflows by ' + (page.scrollWidth - innerWidth) + ' px');
  if (wide.length) faults.push('sticks out: ' + wide[0].tagName + '.' + wide[0].className);
  for (const figure of list('figure')) {
    const section = figure.closest('section'), name = section.querySelector('h2').textContent;
    const plots = [...figure.querySelectorAll('svg')].filter(seen);
    if (plots.length != 1) faults.push(name + ': ' + plots.length + ' plots to be seen');
    for (const plot of plots) if (!plot.getAttribute('aria-label') || plot.getAttribute('role') != 'img') faults.push(name + ': no label');
    if (!figure.querySelector('figcaption')?.textContent.trim()) faults.push(name + ': no caption');
    if (!section.querySelector('details table tbody tr')) faults.push(name + ': no table');
  }
  parent.postMessage(JSON.stringify({ width: innerWidth, figures: list('figure').length, faults }), '*');
});
</script>"#;

/// Holds the page in a frame of its own width, since no window is narrower than 500 pixels, and keeps what the probe says.
fn frame(page: &Path, width: u32) -> String {
    format!(
        "<!DOCTYPE html><script>addEventListener('message', event => document.documentElement.setAttribute('data-probe', event.data));\
         </script><iframe style=\"width:{width}px;height:900px;border:0\" src=\"file://{}\"></iframe>",
        page.display()
    )
}

/// Makes reports and opens them.
///
/// # Errors
/// A page has errors, overflows, asks for the network, or lacks a text equivalent.
pub fn run() -> Result<()> {
    let Some(browser) = browser() else {
        return Ok(());
    };
    let folder = root().join("target/report-check");
    if folder.exists() {
        std::fs::remove_dir_all(&folder).with_context(|| folder.display().to_string())?;
    }
    std::fs::create_dir_all(&folder)?;
    for page in pages(&folder)? {
        let text = std::fs::read_to_string(&page).with_context(|| page.display().to_string())?;
        alone(&text).with_context(|| page.display().to_string())?;
        let probed = page.with_extension("probed.html");
        std::fs::write(
            &probed,
            text.replacen("<head>", &format!("<head>{PROBE}"), 1),
        )?;
        for width in WIDTHS {
            open(browser, &folder, &probed, width)
                .with_context(|| format!("{} at {width}", page.display()))?;
        }
    }
    Ok(())
}

/// The browser, installed if need be.
fn browser() -> Option<&'static str> {
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

/// Reports on couriers with and without a gap, and the blind check's page.
fn pages(folder: &Path) -> Result<Vec<PathBuf>> {
    let courier = |arguments: &[&str]| -> Result<()> {
        let mut command = cargo(&[
            "run",
            "--quiet",
            "--profile",
            "checked",
            "--package",
            "courier",
            "--manifest-path",
        ]);
        command
            .current_dir(folder)
            .arg(root().join("Cargo.toml"))
            .arg("--")
            .args(arguments)
            .stdout(Stdio::null());
        ensure!(
            command.status().context("courier")?.success(),
            "courier {}",
            arguments.join(" ")
        );
        Ok(())
    };
    courier(&[
        "blind",
        "--cases",
        "4",
        "--seed",
        "1",
        "--quick",
        "--folder",
        "cases",
        "--report",
        "blind.html",
    ])?;
    let mut list = vec![folder.join("blind.html")];
    for case in 0..4 {
        let page = format!("case_{case}.html");
        courier(&[
            "diagnose",
            &format!("cases/recordings/case_00{case}"),
            "--report",
            &page,
        ])?;
        list.push(folder.join(page));
    }
    Ok(list)
}

/// Nothing on the page is fetched from anywhere.
fn alone(page: &str) -> Result<()> {
    for wanted in [
        "<!DOCTYPE html>",
        "lang=\"en\"",
        "name=\"viewport\"",
        "prefers-color-scheme:dark",
    ] {
        ensure!(page.contains(wanted), "{wanted} is not in it");
    }
    for foreign in [
        "src=\"http",
        "href=\"http",
        "url(http",
        "@import",
        "<script",
    ] {
        ensure!(
            !page.contains(foreign),
            "found {foreign}, wanted a page that needs nothing else"
        );
    }
    Ok(())
}

/// Opens a page and judges what the probe and the console say.
fn open(browser: &str, folder: &Path, page: &Path, width: u32) -> Result<()> {
    let profile = folder.join(format!("profile-{width}"));
    let mut command = Command::new(browser);
    command.args([
        "--headless",
        "--no-sandbox",
        "--disable-gpu",
        "--disable-quic",
        "--no-first-run",
    ]);
    command.args([
        "--disable-background-networking",
        "--disable-component-update",
        "--disable-sync",
    ]);
    command.args([
        "--enable-logging=stderr",
        "--dump-dom",
        "--virtual-time-budget=5000",
    ]);
    command
        .arg(format!("--user-data-dir={}", profile.display()))
        .arg("--window-size=1400,1000");
    let framed = page.with_extension(format!("{width}.html"));
    std::fs::write(&framed, frame(page, width))?;
    command.arg(format!("file://{}", framed.display()));
    let (document, log) = within(&mut command, folder, PATIENCE)?;
    let console: Vec<&str> = log
        .lines()
        .filter(|line| line.contains(":CONSOLE"))
        .collect();
    ensure!(
        console.is_empty(),
        "the console says: {}",
        console.join("; ")
    );
    let found = document
        .split("data-probe=\"")
        .nth(1)
        .and_then(|rest| rest.split('"').next());
    let found = found
        .context("the probe did not run")?
        .replace("&quot;", "\"")
        .replace("&amp;", "&");
    let probe: serde_json::Value = serde_json::from_str(&found).context(found.clone())?;
    ensure!(
        probe["width"] == width,
        "the window is {} wide, wanted {width}",
        probe["width"]
    );
    let refused = std::fs::read_to_string(page)?.contains("insufficient_data");
    ensure!(
        refused || probe["figures"].as_u64() > Some(0),
        "no figure on the page"
    );
    let faults = probe["faults"].as_array().map_or(&[][..], Vec::as_slice);
    ensure!(faults.is_empty(), "{faults:?}");
    eprintln!(
        "report: {} at {width}: {} figures, no faults",
        page.display(),
        probe["figures"]
    );
    Ok(())
}

/// Output and log of a command that must end in time.
fn within(command: &mut Command, folder: &Path, patience: Duration) -> Result<(String, String)> {
    let (out, err) = (folder.join("document.html"), folder.join("browser.log"));
    command
        .stdin(Stdio::null())
        .stdout(std::fs::File::create(&out)?)
        .stderr(std::fs::File::create(&err)?);
    let mut child = command.spawn().context("the browser")?;
    let begin = Instant::now();
    while child.try_wait()?.is_none() {
        if begin.elapsed() > patience {
            child.kill()?;
            child.wait()?;
            bail!("the browser did not end within {} s", patience.as_secs());
        }
        std::thread::sleep(Duration::from_millis(50));
    }
    let text = |path: &Path| -> Result<String> {
        Ok(String::from_utf8_lossy(&std::fs::read(path)?).into_owned())
    };
    Ok((text(&out)?, text(&err)?))
}
