//! The layout of a recording: its version and the names of its files.

/// Version of the layout that this library reads and writes.
pub const SCHEMA: i64 = 1;

/// Name of the table of units.
pub const META_FILE: &str = "recording.toml";

/// Name of the table of samples.
pub const SAMPLES_FILE: &str = "samples.csv";
