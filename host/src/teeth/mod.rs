//! The tooth map, estimated from a recording under a beacon: `courier map`.
//!
//! Everything is fitted together in f64: equations (3) and (9), lateral waves of mixed order, h, l, o', the coordination sensor's own
//! errors as a polynomial of seventh degree, and the two fields of displaced teeth as cubic B-splines with a node a pitch. The four
//! segments cross the same teeth at different times, and the coordination sensor measures the same motion: that is what tells the
//! teeth. Gauge: each field's mean (exchangeable with the beacon's place) and its slope along the measured direction (a scale: h and
//! the lever arm follow it) are zero. The span l_s against the beacon tells the slope to 0.3 um/mm, which is worse than to take the
//! platen's mean pitch over the map for the nominal one.
//!
//! `pose` (recording -> poses) -> `lattice` (fields) -> `unknowns` (order, priors) -> `model` (outputs) -> `constraint` (equations 5, 10,
//! 11) -> `fit` (Gauss-Newton) -> `estimate` (held-out judgement, trust) -> `file`.

mod constraint;
mod estimate;
mod file;
mod fit;
mod lattice;
mod model;
mod pose;
mod unknowns;

pub use estimate::{Evidence, Mapped, estimate};
pub use file::MapFile;
pub use pose::{Setup, TeethPose, poses_of};
