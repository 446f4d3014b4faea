//! Kinds of files that more than one command knows.

use crate::output::Kind;

/// What `courier diagnose --json` writes.
pub const DIAGNOSIS: Kind = Kind::json(
    "a diagnosis",
    &["schema", "recording", "verdict", "gap", "unexplained"],
);
/// What `courier diagnose --model` writes.
pub const MODEL: Kind = Kind::json("a diagnosed model", &["schema", "survey", "claimed"]);
/// What `courier check --json` writes.
pub const CHECK: Kind = Kind::json("a check", &["schema", "recording", "model", "held_out"]);
/// What `courier export` writes.
pub const CALIBRATION: Kind = Kind::json("a calibration", &["courier_calibration"]);
/// What `courier map --out` writes.
pub const MAP: Kind = Kind::json("a tooth map", &["courier_tooth_map"]);
/// What `courier maps --learn-mark` writes.
pub const MARK: Kind = Kind::json("a mark", &["courier_mark", "place", "mark"]);
/// What `courier diagnose --report`, `courier compare --report` and `courier blind --report` write.
pub const PAGE: Kind = Kind::Page {
    made_by: report::html::MADE_BY,
};
