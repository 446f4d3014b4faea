//! Whether what a calibration left stays true at the courier's rests: the parity g_p wherever it is, and g_x and g_y under the beacon of a joint
//! calibration, each watched for a change alike everywhere, with the place, and with the temperature.
//!
//! A rest tells one pair of numbers ([`Rest`]), g_p and zero or g_x and g_y: the position by the segments less that by the coordination sensor,
//! without whole teeth, of which a start knows none. What a calibration leaves in them is the same each time the courier comes to a place, so a rest counts only in a
//! quarter of a tooth that its window has not seen. The first [`REFERENCE`] rests are the reference (phase I of a control chart; Montgomery
//! 2012, section 5.3): g_x and g_y, and what is left about them, sigma. Windows of [`WINDOW`] rests are compared
//! with it by Page's test (1954, Biometrika 41, 100), by axis and by offset or slope, up and down: three sigma are told, which leaves room
//! for what one place and another differ by. The rate of false alarms is stated by Lorden's bound (1971, Annals of Mathematical Statistics
//! 42, 1897). Which coordinate a change goes with, the place or the temperature, is what explains most of it.
//!
//! Pure: no clock, no allocation, no panic. Memory: 0.5 KiB for each kind.

mod kept;
mod reference;
mod rest;
mod scores;
mod state;
mod sums;
mod told;

pub use kept::RestKept;
pub use reference::stated_m;
pub use rest::{FASTEST_M_S, Glance, MOST_DEFLECTION, Rest, RestKind, Visit};
pub use state::{REFERENCE, RestWatch, WINDOW};
pub use told::{Goes, RestChange, RestVerdict};
