//! Real recordings, which are never copied into the project.

use recording::Recording;
use std::path::PathBuf;

/// The recordings that may not be copied into the project; without them the test says so and passes.
pub fn shared(name: &str) -> Option<Recording> {
    let root = std::env::var_os("COURIER_SHARED").map_or_else(
        || PathBuf::from(concat!(env!("CARGO_MANIFEST_DIR"), "/../../shared")),
        PathBuf::from,
    );
    let path = root.join("data").join(name);
    if !path.exists() {
        eprintln!(
            "SKIPPED: {} is not there; set COURIER_SHARED",
            path.display()
        );
        return None;
    }
    Some(Recording::read(path).expect("a readable recording"))
}
