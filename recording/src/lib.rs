//! Reader and writer of recordings: recording.toml and samples.csv, schema 1.
