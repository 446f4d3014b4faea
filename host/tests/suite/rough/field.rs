//! Recordings of the rig, changed row by row or line by line, and what the command says of them.

use crate::common::{Ran, courier_in, json_in};
use recording::{Existing, Recording};
use serde_json::Value;
use specimens::rig;
use tempfile::TempDir;

/// What is wrong with the courier of [`with_lateral`].
pub const LATERAL: &str = "lateral_dependence";

/// A courier of the rig: `samples` asked of its usual runs, with a reference or with a beacon.
pub fn courier(seed: u64, effects: &[(&str, f64)], reference: bool) -> Recording {
    let options = rig::Options {
        samples: 2400,
        reference,
        beacon: !reference,
        ..rig::Options::default()
    };
    rig::record(seed, effects, &options).0
}

/// With nothing wrong.
pub fn sound() -> Recording {
    courier(31, &[], false)
}

/// With 2 µm of lateral dependence.
pub fn with_lateral() -> Recording {
    courier(32, &[(LATERAL, 2.0e-6)], false)
}

/// The same with other times.
pub fn times(of: &Recording, time_s: impl Fn(usize, f64) -> f64) -> Recording {
    of.with_rows(|i, row| {
        row.t_s = time_s(i, row.t_s);
        true
    })
}

/// What `courier diagnose` said.
pub struct Told {
    folder: TempDir,
    ran: Ran,
}

/// Writes the recording, after changing the text of its table, and has it diagnosed.
pub fn diagnose_text(of: &Recording, change: impl Fn(String) -> String) -> Told {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("field");
    of.write(&path, Existing::Refuse).unwrap();
    let table = path.join("samples.csv");
    let text = std::fs::read_to_string(&table).unwrap();
    std::fs::write(&table, change(text)).unwrap();
    let files = [
        "--json", "d.json", "--model", "m.json", "--report", "r.html",
    ];
    let ran = courier_in(
        folder.path(),
        &[&["diagnose", "field"][..], &files].concat(),
    );
    Told { folder, ran }
}

/// Writes the recording and has it diagnosed.
pub fn diagnose(of: &Recording) -> Told {
    diagnose_text(of, |text| text)
}

impl Told {
    /// The answer, which must have been given in under a screen, with a report.
    pub fn answer(&self) -> Value {
        let Ran { code, out, err, .. } = &self.ran;
        assert_eq!(*code, 0, "{err}");
        assert!(out.lines().count() <= 24, "{out}");
        let page = std::fs::read_to_string(self.folder.path().join("r.html")).unwrap();
        assert!(page.ends_with("</html>"));
        json_in(self.folder.path().join("d.json"))
    }

    /// It must be `insufficient_data`, with these words and a wanted number in its notes, no name and no model.
    pub fn insufficient(&self, words: &[&str]) {
        let answer = self.answer();
        assert_eq!(answer["verdict"], "insufficient_data", "{answer}");
        assert_eq!(answer["effects"].as_array().unwrap().len(), 0);
        let notes = answer["notes"].to_string();
        for word in words.iter().chain(&["at least", "wanted"]) {
            assert!(notes.contains(word), "wanted {word:?} in {notes}");
        }
        assert!(self.ran.out.contains("insufficient data"));
        assert!(!self.folder.path().join("m.json").exists());
    }

    /// The names in the answer.
    pub fn names(&self) -> Vec<String> {
        let answer = self.answer();
        let effects = answer["effects"].as_array().unwrap().iter();
        effects
            .map(|e| e["name"].as_str().unwrap().to_owned())
            .collect()
    }

    /// Nothing but these may be named.
    pub fn names_only(&self, allowed: &[&str]) {
        let names = self.names();
        let known = |n: &String| allowed.contains(&n.as_str());
        assert!(names.iter().all(known), "{names:?} of {allowed:?}");
    }

    /// The verdict.
    pub fn verdict(&self) -> String {
        self.answer()["verdict"].as_str().unwrap().to_owned()
    }

    /// The command must have refused in one line with these words, and have written nothing.
    pub fn refused(&self, words: &[&str]) {
        self.ran.refused(words);
        for file in ["d.json", "m.json", "r.html"] {
            assert!(!self.folder.path().join(file).exists(), "{file}");
        }
    }

    /// Warnings on standard error.
    pub fn warnings(&self) -> &str {
        &self.ran.err
    }
}
