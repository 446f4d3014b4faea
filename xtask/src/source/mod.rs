//! The project's own sources, parsed: for checks that read code.

pub mod modules;
pub mod names;

use crate::{arm, manifests};
use anyhow::{Context, Result};
use std::path::{Path, PathBuf};

/// A crate: where it begins. Programs, libraries and tests are crates of their own.
#[derive(Clone, Debug)]
pub struct Root {
    /// Its first file.
    pub path: PathBuf,
}

/// Every crate of every workspace of the project.
///
/// # Errors
/// cargo cannot read a manifest.
pub fn roots() -> Result<Vec<Root>> {
    let manifest = std::fs::read_to_string(arm::root().join("Cargo.toml")).context("Cargo.toml")?;
    let mut list = Vec::new();
    for workspace in manifests::workspaces(&manifest)? {
        for package in manifests::own_packages(&workspace)? {
            for target in package["targets"].as_array().into_iter().flatten() {
                list.push(Root {
                    path: target["src_path"].as_str().unwrap_or_default().into(),
                });
            }
        }
    }
    Ok(list)
}

/// All sources below a folder, in order.
///
/// # Errors
/// A folder cannot be read.
pub fn files_below(folder: &Path) -> Result<Vec<PathBuf>> {
    let mut list = Vec::new();
    let entries = std::fs::read_dir(folder).with_context(|| folder.display().to_string())?;
    for entry in entries {
        let path = entry?.path();
        if path.is_dir() {
            list.extend(files_below(&path)?);
        } else if path.extension().is_some_and(|ending| ending == "rs") {
            list.push(path);
        }
    }
    list.sort();
    Ok(list)
}

/// A path as it is told: from the project's root.
#[must_use]
pub fn told(path: &Path) -> String {
    let inside = path.strip_prefix(arm::root()).unwrap_or(path);
    inside.display().to_string()
}

/// True where an item is for tests alone.
#[must_use]
pub fn is_for_tests(attributes: &[syn::Attribute]) -> bool {
    attributes.iter().any(|attribute| {
        attribute.path().is_ident("test")
            || attribute.path().is_ident("cfg")
                && attribute
                    .parse_args::<syn::Path>()
                    .is_ok_and(|only| only.is_ident("test"))
    })
}
