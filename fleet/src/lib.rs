//! Several couriers over shared platens under beacons, in one crossed least-squares problem: `courier fleet`.
//!
//! What one courier reads over one platen is the sum of the sensor's own errors and of the platen's displaced teeth. Another courier over
//! the same teeth, and the same courier over other teeth, part the two. Unknowns belong to one of three owners:
//!
//! | owner | unknowns |
//! |---|---|
//! | courier | equation (3) of its segments, lateral waves, lever arms, the diode's own errors and the angle between its axes, both spans |
//! | platen (with its beacon) | displaced teeth of x's and y's field, rulings out of square, of unequal pitch or bent |
//! | recording | what a restart sets anew: offsets of parity and angle, the beacon's height and place |
//!
//! The equations of a pose are those of the tooth map (`tooth-map`). Each recording gives sums of products of its columns, at one
//! stated point of linearisation ([`Sums`]); sums of several recordings add, in any order and grouping. The platen's unknowns are
//! eliminated platen by platen, the couriers' are solved together, and the platen's follow (the Helmert block method: Wolf 1978).
//!
//! `member` (recording -> poses) -> `begin` (a recording alone) -> `register` (whole teeth between recordings, by `field_information`) ->
//! `sums` (at a `state`, by `linearised` poses) -> `solve` (posterior) -> `step` (the next state; once the
//! fields are near, `halved` `splines` tell the likeliest `aperture` by `blocks`, or splines a pitch apart in a `window` of a long field do, and its `teeth` take their place) -> `passes` (until settled; the bound, with
//! `aperture_derivatives`) -> `judge` (held-out poses) -> `answer`, with what was `separated`, the `straight` parts of platens' `lines` and each courier's `homogeneity`. `part` is the same for an engine that forms sums on many computers.

mod answer;
mod aperture;
mod aperture_derivatives;
mod begin;
mod blocks;
mod cache;
mod connected;
mod field_information;
mod form;
mod functions;
mod halved;
mod homogeneity;
mod judge;
mod key;
mod linearised;
mod lines;
mod member;
mod neighbours;
mod part;
mod passes;
mod register;
mod separated;
mod shown;
mod solve;
mod splines;
mod state;
mod step;
mod straight;
mod sums;
mod teeth;
mod told;
mod window;

pub use answer::{Answer, CourierAnswer, PlatenAnswer, RecordingAnswer, answer};
pub use begin::{Beginning, begin};
pub use functions::{
    Cells, Function, field_functions, off_plane, own_functions_of, value, visited,
    visited_by_segments,
};
pub use homogeneity::Fits;
pub use key::{DIODE_SHEAR, Key, Name, Platen, Ruling, SPAN, SPANS_APART};
pub use member::Member;
pub use part::{Part, Progress};
pub use passes::{Fitted, at, bound, fit};
pub use register::register;
pub use separated::{CellAnswer, WaveAnswer};
pub use shown::Shown;
pub use solve::{Posterior, Solution, solve};
pub use state::State;
pub use sums::{Sums, sums_of};
pub use told::Told;
