//! What every package's manifest says: licence, description, the oldest compiler, and why each dependency is there.
//!
//! The oldest compiler is held in two halves. Clippy's `incompatible_msrv`, among the lints of `cargo xtask test`, finds library
//! functions that are newer than `rust-version`; this file finds dependencies that want a newer compiler.
//! It also holds that `courier` alone and `xtask` are built with the features that the tests have: else the diagnosis and the
//! simulator would be built twice.

use crate::arm;
use crate::cargo::cargo;
use anyhow::{Context, Result, ensure};
use serde_json::Value;
use std::collections::BTreeSet;
use std::path::Path;

/// Fields that every package has.
const FIELDS: [&str; 3] = ["license", "description", "rust_version"];

/// Checks all manifests.
///
/// # Errors
/// All that is missing, a line each.
pub fn check() -> Result<()> {
    let mut faults = Vec::new();
    let root = std::fs::read_to_string(arm::root().join("Cargo.toml")).context("Cargo.toml")?;
    for workspace in workspaces(&root)? {
        for package in own_packages(&workspace)? {
            faults.extend(package_faults(&package)?);
        }
    }
    let metadata = metadata("Cargo.toml", &[])?;
    faults.extend(newer_dependencies(&metadata));
    faults.extend(no_default(&metadata));
    faults.extend(built_twice()?);
    ensure!(faults.is_empty(), "{}", faults.join("\n"));
    Ok(())
}

/// Manifests of the workspaces: the root's, and those of the folders that the root leaves out.
///
/// # Errors
/// The root's manifest leaves out no folder.
pub fn workspaces(root: &str) -> Result<Vec<String>> {
    let line = root
        .lines()
        .find_map(|line| line.strip_prefix("exclude = ["));
    let folders = line.context("Cargo.toml: found no `exclude`, wanted the workspaces apart")?;
    let quoted = folders.split('"').skip(1).step_by(2);
    let apart = quoted.map(|folder| format!("{folder}/Cargo.toml"));
    Ok(std::iter::once("Cargo.toml".to_owned())
        .chain(apart)
        .collect())
}

/// What cargo knows of a workspace.
fn metadata(manifest: &str, more: &[&str]) -> Result<Value> {
    let mut command = cargo(&["metadata", "--format-version", "1", "--quiet"]);
    command.args(["--manifest-path", manifest]).args(more);
    let text = arm::output(&mut command).with_context(|| manifest.to_owned())?;
    serde_json::from_str(&text).context("cargo metadata")
}

/// Packages of a workspace, without their dependencies.
///
/// # Errors
/// cargo cannot read a manifest.
pub fn own_packages(manifest: &str) -> Result<Vec<Value>> {
    let known = metadata(manifest, &["--no-deps"])?;
    Ok(known["packages"].as_array().cloned().unwrap_or_default())
}

fn package_faults(package: &Value) -> Result<Vec<String>> {
    let path = package["manifest_path"].as_str().unwrap_or_default();
    let text = std::fs::read_to_string(path).with_context(|| path.to_owned())?;
    let place = Path::new(path).strip_prefix(arm::root());
    let place = place.map_or(path.to_owned(), |place| place.display().to_string());
    let missing = FIELDS.into_iter().filter(|field| package[field].is_null());
    let missing = missing.map(|field| format!("{place}: found no {field}, wanted one"));
    let unexplained = unexplained(&text).into_iter();
    let unexplained =
        unexplained.map(|name| format!("{place}: found no reason for {name}, wanted `# why`"));
    Ok(missing.chain(unexplained).collect())
}

/// Dependencies without a comment that says why they are there.
fn unexplained(manifest: &str) -> Vec<String> {
    let mut is_dependency = false;
    let mut found = Vec::new();
    for line in manifest.lines().map(str::trim) {
        if let Some(section) = line.strip_prefix('[') {
            let section = section.trim_end_matches(']');
            is_dependency =
                section.ends_with("dependencies") && section != "workspace.dependencies";
        } else if let Some((name, value)) = line.split_once('=').filter(|_| is_dependency) {
            let reason = value.rsplit_once("# ").map_or("", |(_, reason)| reason);
            if !line.starts_with('#') && reason.trim().is_empty() {
                found.push(name.trim().trim_end_matches(".workspace").to_owned());
            }
        }
    }
    found
}

/// Dependencies that want a newer compiler than the packages of the workspace say.
fn newer_dependencies(metadata: &Value) -> Vec<String> {
    let packages = metadata["packages"].as_array().cloned().unwrap_or_default();
    let (own, others): (Vec<_>, Vec<_>) = packages.iter().partition(|p| p["source"].is_null());
    let oldest = own.iter().filter_map(|package| version(package)).min();
    let is_newer = |package: &&&Value| version(package) > oldest;
    let told = |package: &&Value| {
        format!(
            "rust-version: found that {} {} wants {}, wanted no more than the workspace says",
            package["name"], package["version"], package["rust_version"]
        )
    };
    others.iter().filter(is_newer).map(told).collect()
}

/// Members of the workspace that are not built by default. `cargo xtask` takes the features that all default members ask for together,
/// which are those of the tests only if none is left out.
fn no_default(metadata: &Value) -> Vec<String> {
    let names = |list: &str| -> BTreeSet<String> {
        let ids = metadata[list].as_array().into_iter().flatten();
        ids.filter_map(|id| id.as_str().map(str::to_owned))
            .collect()
    };
    let (members, default) = (
        names("workspace_members"),
        names("workspace_default_members"),
    );
    let absent = members.difference(&default);
    absent
        .map(|id| {
            format!(
                "Cargo.toml: found {id} among members alone, wanted it among default-members too"
            )
        })
        .collect()
}

/// Packages that `courier` alone wants with other features than the tests of the workspace: they, and all that need them, would be
/// built once for each.
fn built_twice() -> Result<Vec<String>> {
    let tests = features(&["--workspace", "--edges", "normal,build,dev"])?;
    // Its tests, and the command itself.
    let mut alone = features(&["--package", "courier", "--edges", "normal,build,dev"])?;
    alone.extend(features(&[
        "--package",
        "courier",
        "--edges",
        "normal,build",
    ])?);
    let others = alone.difference(&tests).cloned();
    // The extension of Python, whose own packages the tests have not.
    let extension = ["--package", "courier-python", "--features", "module"];
    let extension = features(&[&extension[..], &["--edges", "normal,build"]].concat())?;
    let others = others.chain(otherwise(&extension, &tests));
    Ok(others
        .map(|package| {
            format!("Cargo.toml: found {package} for `courier` or the package of Python alone, wanted the features that the tests of the workspace have")
        })
        .collect())
}

/// Packages that both builds have, and one with other features.
fn otherwise(build: &BTreeSet<String>, tests: &BTreeSet<String>) -> Vec<String> {
    let name = |line: &str| line.split(" with ").next().unwrap_or_default().to_owned();
    let known: BTreeSet<String> = tests.iter().map(|line| name(line)).collect();
    let differs = |line: &&String| known.contains(&name(line)) && !tests.contains(*line);
    let with_its_feature = |line: &&String| !line.starts_with("courier-python ");
    build
        .iter()
        .filter(differs)
        .filter(with_its_feature)
        .cloned()
        .collect()
}

/// Every package of a build with its features.
fn features(selection: &[&str]) -> Result<BTreeSet<String>> {
    let mut command = cargo(&["tree", "--quiet", "--prefix", "none", "--no-dedupe"]);
    command.args(["--format", "{p} with {f}"]).args(selection);
    let text = arm::output(&mut command)?;
    let plain = |line: &str| line.trim_end_matches(" (*)").to_owned();
    Ok(text.lines().map(plain).collect())
}

/// The oldest compiler of a package, as numbers that can be compared.
fn version(package: &Value) -> Option<Vec<u64>> {
    let text = package["rust_version"].as_str()?;
    let mut numbers: Vec<u64> = text.split('.').map_while(|n| n.parse().ok()).collect();
    numbers.resize(3, 0);
    Some(numbers)
}

#[cfg(test)]
mod tests {
    use super::*;
    use serde_json::json;

    #[test]
    fn a_dependency_without_a_reason_is_found() {
        let manifest = "[workspace.dependencies]\na = \"1\"\n[dependencies]\nb = \"1\" # why\n# b = 2\nc.workspace = true\n\
                        [target.'cfg(unix)'.dependencies]\nd = { version = \"1\" }\n[features]\ne = []\n";
        assert_eq!(unexplained(manifest), ["c", "d"]);
    }

    #[test]
    fn workspaces_that_the_root_leaves_out_are_among_them() {
        let found = workspaces("[workspace]\nexclude = [\"bench\", \"tools/a\"]\n").unwrap();
        assert_eq!(
            found,
            ["Cargo.toml", "bench/Cargo.toml", "tools/a/Cargo.toml"]
        );
    }

    #[test]
    fn a_package_with_other_features_is_found_and_a_further_one_is_not() {
        let lines = |lines: &[&str]| lines.iter().map(|line| (*line).to_owned()).collect();
        let tests: BTreeSet<String> =
            lines(&["a v1 with std", "b v1 with ", "courier-python v1 with "]);
        let build = lines(&[
            "a v1 with std",
            "b v1 with full",
            "c v1 with std",
            "courier-python v1 with module",
        ]);
        assert_eq!(otherwise(&build, &tests), ["b v1 with full"]);
    }

    #[test]
    fn a_dependency_that_wants_a_newer_compiler_is_found() {
        let package = |name: &str, source: Value, rust_version: Value| json!({ "name": name, "version": "1", "source": source, "rust_version": rust_version });
        let metadata = json!({ "packages": [
            package("own", Value::Null, "1.89".into()),
            package("alike", "registry".into(), "1.89.0".into()),
            package("silent", "registry".into(), Value::Null),
            package("newer", "registry".into(), "1.90".into()),
        ] });
        let found = newer_dependencies(&metadata);
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].contains("newer"), "{found:?}");
    }

    #[test]
    fn a_member_that_is_not_built_by_default_is_found() {
        let found = no_default(
            &json!({ "workspace_members": ["a", "b"], "workspace_default_members": ["a"] }),
        );
        assert_eq!(found.len(), 1, "{found:?}");
        assert!(found[0].contains("found b "), "{found:?}");
    }

    #[test]
    fn a_package_without_its_fields_is_found() {
        let folder = std::env::temp_dir().join(format!("manifests-{}", std::process::id()));
        std::fs::create_dir_all(&folder).unwrap();
        let path = folder.join("Cargo.toml");
        std::fs::write(&path, "[package]\nname = \"a\"\n").unwrap();
        let package = json!({ "manifest_path": path, "license": "MIT" });
        let faults = package_faults(&package).unwrap();
        std::fs::remove_dir_all(&folder).unwrap();
        assert_eq!(faults.len(), 2, "{faults:?}");
    }
}
