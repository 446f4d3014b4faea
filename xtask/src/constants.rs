//! `cargo xtask constants`: where the numbers of the estimators come from, in `docs/notes/constants.md`.
//!
//! A constant is data (it was measured, or is published), a derivation (from an equation, a distribution, a geometry or a
//! definition), a prior (what is expected before anything is measured, and why), or a bound on the work (it changes what an answer
//! costs, and it is said what reaching it does). A sentence of its documentation says which: one of the words below and then a reason
//! of some words, data with a number. What has no such sentence, or one that owns to have no reason, stands in the last part, without
//! evidence. Whether a reason is a good one no program can tell; that none is given, it can.

use crate::arm::root;
use crate::source::{files_below, is_for_tests};
use anyhow::{Context, Result, ensure};
use std::fmt::Write;
use std::path::Path;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{Attribute, Expr, Ident, Type};

/// Folders whose constants are listed: the signal path, the diagnosis and what it is made of, and all other estimators.
const FOLDERS: &[&str] = &[
    "diagnosis/src",
    "effects/src",
    "plausibility/src",
    "tooth-map/src",
    "tooth-field/src",
    "normal-equations/src",
    "signal/src",
    "calibration/src",
    "encoder/src",
    "fleet/src",
    "guided/src",
    "comparison/src",
    "host/src/isolability",
    "host/src/replay",
    "host/src/board_model",
];

/// The page that the list stands in.
const PAGE: &str = "docs/notes/constants.md";

/// What the head of the page says.
const HEAD: &str = "# Constants\n\nEvery named numeric constant of the signal path, the calibration, the diagnosis, the effects, the check of wires and\nunits, the tooth map, the tooth field, the encoder, fleets, guided captures, comparisons and the host's estimators, with what\nits documentation says of it: data, a derivation, a prior, a bound on the work, or nothing that is a reason. Made by\n`cargo xtask constants`; `cargo xtask test constants` fails where it is stale.\n";

/// Where a value comes from, by what its documentation says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Source {
    Data,
    Derivation,
    Prior,
    Bound,
    None,
}

/// Sources in the order of the page: the heading, and words by which a sentence states one. The first that a documentation states is
/// it.
const SOURCES: [(Source, &str, &[&str]); 5] = [
    (
        Source::Derivation,
        "Derivations",
        &[
            "derived from",
            "a derivation",
            "a definition",
            "by definition",
            "% point of",
        ],
    ),
    (
        Source::Data,
        "Data",
        &[
            "measured",
            "data sheet",
            "paper",
            "as seen in",
            "recordings of",
            "recordings where",
            "recordings with",
        ],
    ),
    (Source::Prior, "Priors", &["prior"]),
    (
        Source::Bound,
        "Bounds on the work",
        &["a bound on the work", "cost alone"],
    ),
    (Source::None, "Without evidence", &[]),
];

/// Words of a reason that follow those of a source, at least: fewer name a source and give none.
const REASON_WORDS: usize = 3;

/// A sentence with one of these owns that there is no reason.
const NO_REASON: [&str; 7] = [
    "without data",
    "a choice",
    "experience",
    "rule of thumb",
    "empirical",
    "heuristic",
    "by trial",
];

/// A constant as it is listed.
#[derive(Clone, Debug, PartialEq)]
struct Row {
    file: String,
    name: String,
    value: String,
    says: String,
    source: Source,
}

/// Writes the page.
///
/// # Errors
/// A file cannot be read or written.
pub fn run() -> Result<()> {
    let rows = rows()?;
    let path = root().join(PAGE);
    std::fs::write(&path, page(&rows)).with_context(|| path.display().to_string())?;
    let bare = rows.iter().filter(|row| row.source == Source::None).count();
    println!("{PAGE}: {} constants, {bare} without evidence", rows.len());
    Ok(())
}

/// Refuses a page that is not what [`run`] would write.
///
/// # Errors
/// The page is stale, or a file cannot be read.
pub fn check() -> Result<()> {
    let path = root().join(PAGE);
    let written = std::fs::read_to_string(&path).with_context(|| path.display().to_string())?;
    ensure!(
        written == page(&rows()?),
        "{PAGE} is stale; run `cargo xtask constants`"
    );
    Ok(())
}

fn rows() -> Result<Vec<Row>> {
    let mut rows = Vec::new();
    for folder in FOLDERS {
        let files = files_below(&root().join(folder))?;
        for path in files.iter().filter(|path| !holds_tests(path)) {
            let file = path.strip_prefix(root())?.display().to_string();
            let text = std::fs::read_to_string(path).with_context(|| file.clone())?;
            rows.extend(of_file(&file, &text)?);
        }
    }
    Ok(rows)
}

/// True for a file of tests, or of what they alone use.
fn holds_tests(path: &Path) -> bool {
    path.ends_with("tests.rs") || path.ends_with("diagnosis/src/synthetic_problem.rs")
}

fn of_file(file: &str, text: &str) -> Result<Vec<Row>> {
    let parsed = syn::parse_file(text).with_context(|| file.to_owned())?;
    let mut finder = Finder {
        file,
        rows: Vec::new(),
    };
    finder.visit_file(&parsed);
    Ok(finder.rows)
}

/// The page that lists these constants: a part for each source, in it a table for each file.
fn page(rows: &[Row]) -> String {
    let mut page = HEAD.to_owned();
    for (source, heading, _) in SOURCES {
        let of_it: Vec<&Row> = rows.iter().filter(|row| row.source == source).collect();
        let _ = write!(page, "\n## {heading}\n\n{} constants.\n", of_it.len());
        let mut last = "";
        for row in of_it {
            if row.file != last {
                let _ = write!(
                    page,
                    "\n### {}\n\n| name | value | what is said of it |\n|---|---|---|\n",
                    row.file
                );
                last = &row.file;
            }
            let _ = writeln!(page, "| `{}` | `{}` | {} |", row.name, row.value, row.says);
        }
    }
    page
}

/// Gathers the numeric constants of a file, those of tests left out.
struct Finder<'a> {
    file: &'a str,
    rows: Vec<Row>,
}

impl Finder<'_> {
    fn add(&mut self, name: &Ident, kind: &Type, value: &Expr, attributes: &[Attribute]) {
        if !is_numeric(kind) || is_for_tests(attributes) {
            return;
        }
        let said = documentation(attributes);
        let says = self.followed(&said);
        let bare = is_bare(value);
        self.rows.push(Row {
            file: self.file.to_owned(),
            name: name.to_string(),
            value: cell(&value.span().source_text().unwrap_or_default()),
            source: if bare {
                source_of(&says)
            } else {
                Source::Derivation
            },
            says: cell(&said),
        });
    }

    /// A documentation, or that of the constant beside that it refers to.
    fn followed(&self, said: &str) -> String {
        let beside = said
            .strip_prefix("See [`")
            .and_then(|rest| rest.split('`').next());
        let row = beside.and_then(|name| self.rows.iter().find(|row| row.name == name));
        row.map_or_else(|| said.to_owned(), |row| row.says.clone())
    }
}

impl<'ast> Visit<'ast> for Finder<'_> {
    fn visit_item_mod(&mut self, item: &'ast syn::ItemMod) {
        if !is_for_tests(&item.attrs) {
            visit::visit_item_mod(self, item);
        }
    }

    fn visit_item_fn(&mut self, item: &'ast syn::ItemFn) {
        if !is_for_tests(&item.attrs) {
            visit::visit_item_fn(self, item);
        }
    }

    fn visit_item_const(&mut self, item: &'ast syn::ItemConst) {
        self.add(&item.ident, &item.ty, &item.expr, &item.attrs);
    }

    fn visit_impl_item_const(&mut self, item: &'ast syn::ImplItemConst) {
        self.add(&item.ident, &item.ty, &item.expr, &item.attrs);
    }
}

/// True for a number, and for lists and tuples of numbers.
fn is_numeric(kind: &Type) -> bool {
    match kind {
        Type::Array(array) => is_numeric(&array.elem),
        Type::Slice(slice) => is_numeric(&slice.elem),
        Type::Reference(reference) => is_numeric(&reference.elem),
        Type::Tuple(tuple) => !tuple.elems.is_empty() && tuple.elems.iter().all(is_numeric),
        Type::Path(path) => path.path.get_ident().is_some_and(|name| {
            let name = name.to_string();
            let digits = name.trim_start_matches(['f', 'u', 'i']);
            digits.len() < name.len() && (digits == "size" || digits.parse::<u8>().is_ok())
        }),
        _ => false,
    }
}

/// True where a value is more than other constants: where it has digits of its own beside them, other than those that double, halve
/// or count one.
fn is_bare(value: &Expr) -> bool {
    struct Parts {
        named: bool,
        free: bool,
    }
    impl<'ast> Visit<'ast> for Parts {
        fn visit_expr_path(&mut self, path: &'ast syn::ExprPath) {
            let last = path.path.segments.last();
            self.named |= last.is_some_and(|name| {
                let name = name.ident.to_string();
                let of_mathematics = matches!(name.as_str(), "INFINITY" | "NEG_INFINITY" | "PI");
                name == name.to_uppercase() && !of_mathematics
            });
        }

        fn visit_lit(&mut self, literal: &'ast syn::Lit) {
            let value: Option<f64> = match literal {
                syn::Lit::Int(digits) => digits.base10_parse().ok(),
                syn::Lit::Float(digits) => digits.base10_parse().ok(),
                _ => None,
            };
            self.free |= value.is_some_and(|value| ![0.0, 0.5, 1.0, 2.0].contains(&value));
        }
    }
    let mut parts = Parts {
        named: false,
        free: false,
    };
    parts.visit_expr(value);
    !parts.named || parts.free
}

/// What a documentation states, sentence by sentence: the first source in their order that one of them gives a reason of.
fn source_of(says: &str) -> Source {
    let reasons = says.split(". ").filter(|sentence| {
        let sentence = sentence.to_lowercase();
        !NO_REASON.iter().any(|words| sentence.contains(words))
    });
    let reasons: Vec<&str> = reasons.collect();
    let stated = SOURCES.iter().find(|(source, _, words)| {
        let states = |sentence: &&str| states(sentence, *source, words);
        reasons.iter().any(states)
    });
    stated.map_or(Source::None, |(source, _, _)| *source)
}

/// True where a sentence has one of a source's words and a reason: some words behind it, and behind a colon where the word is also one
/// of plain speech; for data, a number.
fn states(sentence: &str, source: Source, words: &[&str]) -> bool {
    if source == Source::Derivation && cites(sentence) {
        return true;
    }
    let lower = sentence.to_lowercase();
    let mut behind = words.iter().filter_map(|word| {
        let (_, behind) = lower.split_once(word)?;
        Some(behind)
    });
    match source {
        Source::Data => behind.next().is_some() && lower.contains(|c: char| c.is_ascii_digit()),
        Source::Derivation => behind.any(is_reason),
        _ => behind.any(|behind| {
            behind
                .split_once(':')
                .is_some_and(|(_, told)| is_reason(told))
        }),
    }
}

fn is_reason(text: &str) -> bool {
    text.split_whitespace().count() >= REASON_WORDS
}

/// True where a name and a year stand: a publication.
fn cites(sentence: &str) -> bool {
    let words: Vec<&str> = sentence.split_whitespace().collect();
    words.windows(2).any(|pair| {
        let name = pair[0].trim_start_matches('(');
        let year = pair[1].trim_end_matches(|c: char| !c.is_ascii_digit());
        let year = year.split(',').next().unwrap_or_default();
        let is_year = year
            .parse::<u16>()
            .is_ok_and(|year| (1750..2100).contains(&year));
        let written_by_someone = name.starts_with(char::is_uppercase) && name.len() > 2;
        year.len() == 4 && is_year && written_by_someone
    })
}

/// All lines of a documentation in one.
fn documentation(attributes: &[Attribute]) -> String {
    let lines = attributes.iter().filter_map(|attribute| {
        let value = &attribute.meta.require_name_value().ok()?.value;
        match value {
            Expr::Lit(syn::ExprLit {
                lit: syn::Lit::Str(text),
                ..
            }) => Some(text.value().trim().to_owned()),
            _ => None,
        }
    });
    lines.collect::<Vec<_>>().join(" ")
}

/// A text as a cell of a table has it, on one line.
fn cell(text: &str) -> String {
    let words: Vec<&str> = text.split_whitespace().collect();
    words
        .join(" ")
        .replace("[`", "`")
        .replace("`]", "`")
        .replace('|', "/")
}

#[cfg(test)]
mod tests {
    use super::*;

    fn sources(text: &str) -> Vec<(String, Source)> {
        let rows = of_file("a.rs", text).unwrap();
        rows.into_iter().map(|row| (row.name, row.source)).collect()
    }

    #[test]
    fn a_constant_stands_under_what_its_documentation_says() {
        let text = "/// Most lines.\nconst A: usize = 3;\n/// A prior: as large as a tooth is.\nconst B: [f64; 2] = [1.0, 2.0];\n\
            /// Of a period (Lomb 1976).\nconst C: f64 = 4.0;\n/// As was measured on 61 rings.\nconst D: (usize, f64) = (1, 0.5);\n\
            /// See [`B`].\nconst E: f64 = 1.0;\n/// Twice.\nconst F: f64 = 2.0 * C;\n\
            /// A bound on the work: with more the rest is left out.\nconst G: usize = 9;";
        let wanted = [
            ("A", Source::None),
            ("B", Source::Prior),
            ("C", Source::Derivation),
            ("D", Source::Data),
            ("E", Source::Prior),
            ("F", Source::Derivation),
            ("G", Source::Bound),
        ];
        let wanted: Vec<_> = wanted
            .map(|(name, source)| (name.to_owned(), source))
            .into();
        assert_eq!(sources(text), wanted);
    }

    #[test]
    fn words_alone_are_no_evidence() {
        for says in [
            "Prior size of a shape, m.",
            "A prior.",
            "Below this share of its prior size it is nothing.",
            "A prior from experience with many sensors.",
            "A prior without data: a few percent of it.",
            "Measured on some recordings.",
            "No segment is more exact than this, m.",
            "Samples of a piece, some 2000 in all.",
            "A bound on the work.",
        ] {
            let text = format!("/// {says}\nconst A: f64 = 3.0;");
            assert_eq!(sources(&text), [("A".to_owned(), Source::None)], "{says}");
        }
    }

    #[test]
    fn a_formula_is_a_derivation_unless_it_has_digits_of_its_own() {
        let text = "const A: f64 = 4.0 * B;\nconst C: f64 = 0.5 * B;\nconst D: f64 = 0.5 * PI;";
        let wanted = [Source::None, Source::Derivation, Source::None];
        let found: Vec<Source> = sources(text).into_iter().map(|row| row.1).collect();
        assert_eq!(found, wanted);
    }

    #[test]
    fn what_is_no_number_and_what_is_for_tests_is_not_listed() {
        let text = "const A: &str = \"a\";\n#[cfg(test)]\nmod tests { const B: f64 = 1.0; }\nfn f() { const C: i32 = 1; }";
        assert_eq!(sources(text), [("C".to_owned(), Source::None)]);
    }

    #[test]
    fn the_page_has_a_part_for_each_source() {
        let rows = of_file("a.rs", "/// Most | lines.\nconst A: f64 = 0.5;").unwrap();
        let page = page(&rows);
        assert!(page.contains("## Priors\n\n0 constants.\n"));
        assert!(page.ends_with("## Without evidence\n\n1 constants.\n\n### a.rs\n\n| name | value | what is said of it |\n|---|---|---|\n| `A` | `0.5` | Most / lines. |\n"), "{page}");
    }
}
