//! Which file a name comes from.

use super::modules::{Module, Place};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use syn::visit::Visit;

/// Imports that are followed one after the other before it is taken for a name that imports itself.
const DEEPEST: usize = 5;

/// The other files of the crate that a module takes names from, each with the names. An import that a module only passes on
/// counts for who uses the name, and as one from the file that defines it.
pub fn taken(
    place: &Place,
    modules: &BTreeMap<Place, Module>,
) -> BTreeMap<PathBuf, BTreeSet<String>> {
    let module = &modules[place];
    let mut paths = Paths::default();
    for item in &module.code {
        paths.visit_item(item);
    }
    let mut found: BTreeMap<PathBuf, BTreeSet<String>> = BTreeMap::new();
    for path in &paths.list {
        if let Some((file, name)) = defined(path, place, modules, 0)
            && file != module.file
        {
            found.entry(file.into()).or_default().insert(name);
        }
    }
    found
}

/// The file that defines the last module's name of a path, and that name; none where it is another crate's.
fn defined<'a>(
    path: &[String],
    from: &Place,
    modules: &'a BTreeMap<Place, Module>,
    depth: usize,
) -> Option<(&'a Path, String)> {
    let mut at = from.clone();
    let mut rest = path;
    while let Some((first, after)) = rest.split_first() {
        match first.as_str() {
            "crate" => at = Place::new(),
            "self" => {}
            "super" => {
                at.pop()?;
            }
            _ => break,
        }
        rest = after;
    }
    let is_outside = rest.len() == path.len();
    for (k, name) in rest.iter().enumerate() {
        let module = modules.get(&at)?;
        // A module's name before `::` is the module, also where a function is called the same.
        let is_module = module.modules.contains(name) && k + 1 < rest.len();
        if module.items.contains(name) && !is_module {
            return Some((&module.file, name.clone()));
        }
        if module.modules.contains(name) {
            at.push(name.clone());
            continue;
        }
        let further = |import: &Vec<String>| [import.as_slice(), &rest[k + 1..]].concat();
        if depth == DEEPEST {
            return None;
        }
        if let Some(import) = module.imports.get(name) {
            // `use name` of another crate imports itself.
            let whole = further(import);
            return (whole != path || at != *from)
                .then(|| defined(&whole, &at, modules, depth + 1))
                .flatten();
        }
        // A name of another crate, or one of all that was imported together.
        let together = module
            .imports
            .iter()
            .filter(|(name, _)| name.ends_with("::*"));
        let mut sources = together.map(|(_, import)| [import.as_slice(), &rest[k..]].concat());
        let found = sources.find_map(|whole| defined(&whole, &at, modules, depth + 1));
        return found.or((!is_outside && k > 0).then(|| (module.file.as_path(), name.clone())));
    }
    None
}

/// Every path that code says, also within macros as far as their words are paths.
#[derive(Default)]
struct Paths {
    list: Vec<Vec<String>>,
}

impl<'ast> Visit<'ast> for Paths {
    fn visit_path(&mut self, path: &'ast syn::Path) {
        self.list
            .push(path.segments.iter().map(|s| s.ident.to_string()).collect());
        syn::visit::visit_path(self, path);
    }

    fn visit_macro(&mut self, called: &'ast syn::Macro) {
        self.visit_path(&called.path);
        self.words(called.tokens.clone());
    }

    fn visit_item_use(&mut self, _: &'ast syn::ItemUse) {
        // Imports within a function are rare; what they bring is said again by full paths elsewhere or is another crate's.
    }
}

impl Paths {
    /// Paths in the words of a macro: names joined by `::`.
    fn words(&mut self, tokens: proc_macro2::TokenStream) {
        use proc_macro2::TokenTree;
        let mut path: Vec<String> = Vec::new();
        let mut colons = 0;
        for token in tokens {
            match token {
                TokenTree::Ident(name) => {
                    if colons != 2 {
                        self.list.extend((!path.is_empty()).then(|| path.clone()));
                        path.clear();
                    }
                    path.push(name.to_string());
                    colons = 0;
                }
                TokenTree::Punct(mark) if mark.as_char() == ':' => colons += 1,
                TokenTree::Group(group) => {
                    self.words(group.stream());
                    colons = 0;
                }
                _ => colons = 0,
            }
        }
        self.list.extend((!path.is_empty()).then_some(path));
    }
}
