//! `--json`, the same in every command: it prints JSON in place of the text, or writes it to a file beside the text.

use crate::output::{self, Kind};
use crate::terminal::{print, print_json};
use anyhow::{Context, Result};
use serde::Serialize;
use std::ffi::OsString;
use std::fs::File;
use std::io::Write as _;
use std::path::{Path, PathBuf};

/// The option.
#[derive(Clone, Debug, Default, clap::Args)]
pub struct Json {
    /// Print JSON in place of the text; with =FILE, write it to that file beside the text.
    #[arg(
        long = "json",
        value_name = "FILE",
        num_args = 0..=1,
        require_equals = true,
        default_missing_value = "-"
    )]
    to: Option<PathBuf>,
}

impl Json {
    /// The file that JSON goes to; none where it is printed or was not asked for.
    pub fn file(&self) -> Option<&PathBuf> {
        self.to.as_ref().filter(|path| !is_standard_output(path))
    }

    /// Whether JSON takes the text's place on standard output.
    pub fn is_printed(&self) -> bool {
        self.to.as_deref().is_some_and(is_standard_output)
    }

    /// Tells a command's answer: `value` as JSON where it was asked for, `text` where JSON does not take its place. `kind` is
    /// what a file must be for the JSON to replace it.
    ///
    /// # Errors
    /// Standard output is closed, or the file cannot be written.
    pub fn tell(
        &self,
        kind: Kind,
        value: &impl Serialize,
        text: impl FnOnce() -> String,
    ) -> Result<()> {
        if self.is_printed() {
            return print_json(value);
        }
        if let Some(path) = self.file() {
            let json = serde_json::to_string_pretty(value)? + "\n";
            output::write(path, kind, json.as_bytes())?;
        }
        print(&text())
    }

    /// For commands that tell one thing after another: a line each.
    ///
    /// # Errors
    /// The file cannot be written.
    pub fn lines(&self) -> Result<Lines> {
        let file = self.file().map(|path| {
            let file = File::create(path)
                .with_context(|| format!("{}: wanted a file that can be written", path.display()));
            file.map(|file| (path.clone(), file))
        });
        Ok(Lines {
            printed: self.is_printed(),
            file: file.transpose()?,
        })
    }
}

/// One line after another, as [`Json::lines`] was asked for.
pub struct Lines {
    printed: bool,
    file: Option<(PathBuf, File)>,
}

impl Lines {
    /// Tells one more thing.
    ///
    /// # Errors
    /// Standard output is closed, or the file cannot be written.
    pub fn push(&mut self, value: &impl Serialize, text: impl FnOnce() -> String) -> Result<()> {
        let json = || serde_json::to_string(value);
        if self.printed {
            return print(&json()?);
        }
        if let Some((path, file)) = &mut self.file {
            let line = json()? + "\n";
            file.write_all(line.as_bytes())
                .with_context(|| format!("{}: wanted room to write", path.display()))?;
        }
        print(&text())
    }
}

fn is_standard_output(path: &Path) -> bool {
    path.as_os_str() == "-"
}

/// The command line with `--json FILE` written as `--json=FILE`, as `diagnose`, `check` and `blind` took it first; none where no
/// `--json` has a word after it that could be a file.
pub fn in_one_word(arguments: &[OsString]) -> Option<Vec<OsString>> {
    let at = arguments
        .iter()
        .take_while(|word| *word != "--")
        .position(|word| word == "--json")?;
    let file = arguments.get(at + 1)?;
    let is_option = file.as_encoded_bytes().starts_with(b"-") && file != "-";
    if is_option {
        return None;
    }
    let mut joined = OsString::from("--json=");
    joined.push(file);
    Some([&arguments[..at], &[joined], &arguments[at + 2..]].concat())
}

#[cfg(test)]
mod tests {
    use super::*;

    fn words(line: &str) -> Vec<OsString> {
        line.split(' ').map(OsString::from).collect()
    }

    #[test]
    fn a_file_after_the_option_is_its_value_and_another_option_is_not() {
        let joined = |line| in_one_word(&words(line));
        for (line, wanted) in [
            (
                "courier diagnose r --json a.json",
                "courier diagnose r --json=a.json",
            ),
            ("courier check --json - m r", "courier check --json=- m r"),
            (
                "courier diagnose --json a r --model m",
                "courier diagnose --json=a r --model m",
            ),
        ] {
            assert_eq!(joined(line), Some(words(wanted)), "{line}");
        }
        for line in [
            "courier status --json",
            "courier diagnose r --json --model m",
            "courier diagnose r --json=a.json",
            "courier diagnose -- --json r",
        ] {
            assert_eq!(joined(line), None, "{line}");
        }
    }
}
