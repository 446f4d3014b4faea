//! `cargo xtask constants`: where the numbers of the estimators come from, in `docs/notes/constants.md`.
//!
//! A constant is data (it was measured), a derivation (from an equation, a distribution or other constants), or a prior (what is
//! expected before anything is measured). Its documentation says which. What says none of these stands in the last part, without
//! evidence. Whether a source is a good one no program can tell; that none is given, it can.

use crate::arm::root;
use crate::source::{files_below, is_for_tests};
use anyhow::{Context, Result, ensure};
use std::fmt::Write;
use syn::spanned::Spanned;
use syn::visit::{self, Visit};
use syn::{Attribute, Expr, Ident, Type};

/// Folders whose constants are listed: the diagnosis and what it is made of, and the estimators of the host.
const FOLDERS: &[&str] = &[
    "diagnosis/src",
    "effects/src",
    "plausibility/src",
    "tooth-map/src",
    "tooth-field/src",
    "normal-equations/src",
    "comparison/src",
    "host/src/isolability",
    "host/src/replay",
    "host/src/board_model",
];

/// The page that the list stands in.
const PAGE: &str = "docs/notes/constants.md";

/// What the head of the page says.
const HEAD: &str = "# Constants\n\nEvery named numeric constant of the diagnosis, the effects, the check of wires and units, the tooth map, the tooth\nfield, comparisons and the host's estimators, with what its documentation says of it. Made by `cargo xtask constants`; `cargo xtask test constants` fails where it is stale.\n";

/// Where a value comes from, by what its documentation says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Source {
    Data,
    Derivation,
    Prior,
    None,
}

/// Sources in the order of the page: the heading, and words of a documentation that state one. The first that a documentation has
/// a word of is it.
const SOURCES: [(Source, &str, &[&str]); 4] = [
    (
        Source::Derivation,
        "Derivations",
        &[
            "equation (",
            "point of ",
            "degrees of freedom",
            "derived",
            "exact",
            "definition",
            "et al",
            "as tables have it",
            "golden section",
        ],
    ),
    (
        Source::Data,
        "Data",
        &[
            "measured on",
            "was measured",
            "recordings where",
            "recordings with",
            "mirrors",
            "data sheet",
            " it was ",
        ],
    ),
    (
        Source::Prior,
        "Priors",
        &["prior", "expected size", "physical size", "typical"],
    ),
    (Source::None, "Without evidence", &[]),
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
        for path in files_below(&root().join(folder))? {
            let file = path.strip_prefix(root())?.display().to_string();
            let text = std::fs::read_to_string(&path).with_context(|| file.clone())?;
            rows.extend(of_file(&file, &text)?);
        }
    }
    Ok(rows)
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

/// True where a value is written as digits alone, and not by other constants.
fn is_bare(value: &Expr) -> bool {
    struct Names(bool);
    impl<'ast> Visit<'ast> for Names {
        fn visit_expr_path(&mut self, path: &'ast syn::ExprPath) {
            let last = path.path.segments.last();
            self.0 |= last.is_some_and(|name| {
                let name = name.ident.to_string();
                name == name.to_uppercase() && !matches!(name.as_str(), "INFINITY" | "NEG_INFINITY")
            });
        }
    }
    let mut names = Names(false);
    names.visit_expr(value);
    !names.0
}

fn source_of(says: &str) -> Source {
    let text = says.to_lowercase();
    let stated = SOURCES
        .iter()
        .find(|(_, _, words)| words.iter().any(|word| text.contains(word)));
    match stated {
        Some((source, _, _)) => *source,
        None if has_year(&text) => Source::Derivation,
        None => Source::None,
    }
}

/// True where a year stands: that of a publication.
fn has_year(text: &str) -> bool {
    let mut words = text.split(|c: char| !c.is_ascii_digit());
    words.any(|word| word.len() == 4 && matches!(&word[..2], "18" | "19" | "20"))
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
        let text = "/// Most lines.\nconst A: usize = 3;\n/// Prior size, m.\nconst B: [f64; 2] = [1.0, 2.0];\n\
            /// Lomb 1976.\nconst C: f64 = 4.0;\n/// As was measured on rings.\nconst D: (usize, f64) = (1, 0.5);\n\
            /// See [`B`].\nconst E: f64 = 1.0;\n/// Twice.\nconst F: f64 = 2.0 * C;";
        let wanted = [
            ("A", Source::None),
            ("B", Source::Prior),
            ("C", Source::Derivation),
            ("D", Source::Data),
            ("E", Source::Prior),
            ("F", Source::Derivation),
        ];
        let wanted: Vec<_> = wanted
            .map(|(name, source)| (name.to_owned(), source))
            .into();
        assert_eq!(sources(text), wanted);
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
