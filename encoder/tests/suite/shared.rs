//! Recordings from outside, which are never copied into the project.

use std::path::{Path, PathBuf};

/// A folder of real data, in `$COURIER_SHARED/data` or `../shared/data`; none, and said so, where it is absent.
pub fn shared(name: &str) -> Option<PathBuf> {
    let beside = || Path::new(env!("CARGO_MANIFEST_DIR")).join("../../shared");
    let shared = std::env::var_os("COURIER_SHARED").map_or_else(beside, PathBuf::from);
    let path = shared.join("data").join(name);
    if path.exists() {
        return Some(path);
    }
    eprintln!(
        "SKIPPED: nothing at {}; set COURIER_SHARED to the folder that holds data/",
        path.display()
    );
    None
}
