//! Recordings that several files ask of: real ones, which are never copied into the project, and made ones of one segment.

use recording::{Electronics, Geometry, Meta, Recording, Samples};
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

/// Samples of one segment with a pitch, m, and a converter.
pub fn of_one_segment(pitch_m: f64, electronics: Electronics, samples: Samples) -> Recording {
    let geometry = Geometry {
        pitch_m,
        ..Geometry::default()
    };
    Recording {
        meta: Meta {
            geometry,
            electronics,
            ..Meta::default()
        },
        samples,
        warnings: Vec::new(),
    }
}
