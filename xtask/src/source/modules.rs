//! The modules of a crate: in which file each lies, what it defines, and what it imports under which name.

use super::{Root, is_for_tests};
use anyhow::{Context, Result};
use std::collections::{BTreeMap, BTreeSet};
use std::path::{Path, PathBuf};
use syn::{Item, ItemMod, UseTree};

/// A module's place in its crate: the names on the way to it, none for the root.
pub type Place = Vec<String>;

/// One module.
#[derive(Clone, Default)]
pub struct Module {
    /// The file that it lies in.
    pub file: PathBuf,
    /// Names of its modules.
    pub modules: BTreeSet<String>,
    /// Names of what else it defines.
    pub items: BTreeSet<String>,
    /// What it imports: the path, by the name that it has here.
    pub imports: BTreeMap<String, Vec<String>>,
    /// What it contains, but for modules and imports.
    pub code: Vec<Item>,
}

/// Every module of a crate, those for tests alone left out.
///
/// # Errors
/// A file cannot be read or is no Rust.
pub fn modules(root: &Root) -> Result<BTreeMap<Place, Module>> {
    let mut found = BTreeMap::new();
    let folder = root.path.parent().unwrap_or(Path::new(""));
    let items = parsed(&root.path)?;
    gather(Vec::new(), &root.path, folder, items, &mut found)?;
    Ok(found)
}

fn parsed(path: &Path) -> Result<Vec<Item>> {
    let text = std::fs::read_to_string(path).with_context(|| path.display().to_string())?;
    let file = syn::parse_file(&text).with_context(|| path.display().to_string())?;
    Ok(file.items)
}

/// Takes in a module and all within; `folder` is where the files of its modules lie.
fn gather(
    place: Place,
    file: &Path,
    folder: &Path,
    items: Vec<Item>,
    found: &mut BTreeMap<Place, Module>,
) -> Result<()> {
    let mut module = Module {
        file: file.into(),
        ..Module::default()
    };
    for item in items {
        match item {
            Item::Mod(inner) if is_for_tests(&inner.attrs) => {}
            Item::Mod(inner) => {
                let name = inner.ident.to_string();
                module.modules.insert(name.clone());
                let within = [place.as_slice(), std::slice::from_ref(&name)].concat();
                enter(within, file, folder, inner, found)?;
            }
            Item::Use(import) if is_for_tests(&import.attrs) => {}
            Item::Use(import) => flatten(&import.tree, Vec::new(), &mut module.imports),
            other => {
                module.items.extend(name_of(&other));
                module.code.push(other);
            }
        }
    }
    found.insert(place, module);
    Ok(())
}

fn enter(
    place: Place,
    file: &Path,
    folder: &Path,
    inner: ItemMod,
    found: &mut BTreeMap<Place, Module>,
) -> Result<()> {
    let name = inner.ident.to_string();
    if let Some((_, items)) = inner.content {
        return gather(place, file, &folder.join(name), items, found);
    }
    let beside = stated_path(&inner).map(|path| file.parent().unwrap_or(folder).join(path));
    let candidates = [
        beside.clone().unwrap_or_default(),
        folder.join(format!("{name}.rs")),
        folder.join(&name).join("mod.rs"),
    ];
    // What a feature leaves out may have no file at all.
    let Some(path) = candidates.into_iter().find(|path| path.is_file()) else {
        return Ok(());
    };
    let is_folder = path.file_name().is_some_and(|name| name == "mod.rs") || beside.is_some();
    let folder = match is_folder {
        true => path.parent().unwrap_or(folder).to_owned(),
        false => folder.join(name),
    };
    let items = parsed(&path)?;
    gather(place, &path, &folder, items, found)
}

/// The file of `#[path = "…"]`.
fn stated_path(module: &ItemMod) -> Option<String> {
    let attribute = module.attrs.iter().find(|a| a.path().is_ident("path"))?;
    let value = &attribute.meta.require_name_value().ok()?.value;
    let syn::Expr::Lit(literal) = value else {
        return None;
    };
    match &literal.lit {
        syn::Lit::Str(text) => Some(text.value()),
        _ => None,
    }
}

fn flatten(tree: &UseTree, mut before: Vec<String>, into: &mut BTreeMap<String, Vec<String>>) {
    match tree {
        UseTree::Path(path) => {
            before.push(path.ident.to_string());
            flatten(&path.tree, before, into);
        }
        UseTree::Group(group) => {
            for tree in &group.items {
                flatten(tree, before.clone(), into);
            }
        }
        UseTree::Name(name) if name.ident == "self" => {
            into.extend(before.last().cloned().map(|last| (last, before)));
        }
        UseTree::Name(name) => {
            before.push(name.ident.to_string());
            into.insert(name.ident.to_string(), before);
        }
        UseTree::Rename(renamed) => {
            if renamed.ident != "self" {
                before.push(renamed.ident.to_string());
            }
            into.insert(renamed.rename.to_string(), before);
        }
        // All of a module: held under a name that none has.
        UseTree::Glob(_) => {
            into.insert(format!("{}::*", before.join("::")), before);
        }
    }
}

fn name_of(item: &Item) -> Option<String> {
    let name = match item {
        Item::Const(item) => &item.ident,
        Item::Enum(item) => &item.ident,
        Item::Fn(item) => &item.sig.ident,
        Item::Macro(item) => item.ident.as_ref()?,
        Item::Static(item) => &item.ident,
        Item::Struct(item) => &item.ident,
        Item::Trait(item) => &item.ident,
        Item::Type(item) => &item.ident,
        Item::Union(item) => &item.ident,
        _ => return None,
    };
    Some(name.to_string())
}
