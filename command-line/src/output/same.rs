//! Whether two paths name one file: links are followed, and on Unix hard links are seen as well.

use std::path::{Path, PathBuf};

/// Links in a row that are followed before a path is taken as it is: as many as Linux follows.
const MOST_LINKS: usize = 40;

/// Whether both name the same file or would once it is written.
pub fn same(one: &Path, other: &Path) -> bool {
    resolved(one) == resolved(other) || hard_linked(one, other)
}

/// Whether `path` is in `folder` or below, or is the folder.
pub fn within(path: &Path, folder: &Path) -> bool {
    resolved(path).starts_with(resolved(folder))
}

/// The path without links. Of what is not there yet, the nearest folder that is counts.
fn resolved(path: &Path) -> PathBuf {
    let mut path = path.to_owned();
    for _ in 0..MOST_LINKS {
        if let Ok(whole) = std::fs::canonicalize(&path) {
            return whole;
        }
        // A link to what is not there yet: writing makes what it points to.
        let Ok(target) = std::fs::read_link(&path) else {
            break;
        };
        path = path.parent().unwrap_or(Path::new("")).join(target);
    }
    match (path.parent(), path.file_name()) {
        (Some(folder), Some(name)) => {
            let folder = if folder.as_os_str().is_empty() {
                Path::new(".")
            } else {
                folder
            };
            resolved(folder).join(name)
        }
        _ => path,
    }
}

/// Whether both are one file under two names.
#[cfg(unix)]
fn hard_linked(one: &Path, other: &Path) -> bool {
    use std::os::unix::fs::MetadataExt;
    match (std::fs::metadata(one), std::fs::metadata(other)) {
        (Ok(one), Ok(other)) => {
            one.is_file() && (one.dev(), one.ino()) == (other.dev(), other.ino())
        }
        _ => false,
    }
}

/// The standard library tells it on Unix alone.
#[cfg(not(unix))]
fn hard_linked(_: &Path, _: &Path) -> bool {
    false
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn links_and_roundabout_names_are_one_file_and_others_are_not() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        std::fs::write(at("file"), "a").unwrap();
        std::fs::create_dir(at("sub")).unwrap();
        std::fs::hard_link(at("file"), at("hard")).unwrap();
        symlink("file", at("soft")).unwrap();
        symlink("new", at("to-new")).unwrap();
        symlink("loop", at("loop")).unwrap();
        for name in ["sub/../file", "./file", "hard", "soft"] {
            assert!(same(&at("file"), &at(name)), "{name}");
        }
        assert!(same(&at("new"), &at("to-new")));
        assert!(same(&at("no/such/a"), &at("no/such/a")));
        for (one, other) in [("file", "new"), ("new", "newer"), ("loop", "file")] {
            assert!(!same(&at(one), &at(other)), "{one} {other}");
        }
        assert!(within(&at("sub/new"), &at("sub")));
        assert!(within(&at("not-yet/new"), &at("not-yet")));
        assert!(!within(&at("sub-new"), &at("sub")));
    }
}
