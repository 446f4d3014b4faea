//! The tooth map, estimated from a recording under a beacon: `courier map`. `courier fleet` uses the same equations of a pose.
//!
//! Everything is fitted together in f64: equations (3) and (9), lateral waves of mixed order, h, l, o', the coordination sensor's own
//! errors as a polynomial of ninth degree, and the two fields of displaced teeth as cubic B-splines with a node a pitch. The four
//! segments cross the same teeth at different times, and the coordination sensor measures the same motion: that is what tells the
//! teeth. Gauge: each field's mean is zero (exchangeable with the beacon's place). Its slope along the measured direction is a scale
//! that h and the lever arm follow; the poses tell it weakly (l_s is known), and what they leave open the prior of independent nodes
//! and lines decides: the slope that needs the least displacement of teeth.
//!
//! `pose` (recording -> poses) -> `lattice` (fields) -> `unknowns` (order, priors) -> `model` (outputs) -> `constraint` (equations 5, 10,
//! 11) -> `fit` (Gauss-Newton) -> `estimate` (held-out judgement, trust; `predict`) -> `patch` (what fits a board), `anchor` (where it lies) -> `file`.

mod anchor;
mod constraint;
mod estimate;
mod file;
mod fit;
mod lattice;
mod model;
mod patch;
mod pose;
mod predict;
mod rulings;
mod unknowns;

pub use anchor::Anchor;
pub use constraint::{Left, Linear, by_raw_outputs, linear, misclosures};
pub use estimate::{Evidence, FIRST_NOISE, Mapped, check_turn, estimate, lattices, split};
pub use file::MapFile;
pub use fit::{Fit, Problem, add_rows, products};
pub use lattice::{FIELD, FieldKernel};
pub use model::places;
pub use pose::{Noise, Setup, TeethPose, poses_of};
pub use rulings::Rulings;
pub use unknowns::{NODE_M, Unknowns, WAVES};
