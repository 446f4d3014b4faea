//! Whether what was calibrated stays true: the parity of ordinary motion, watched for a change of one segment's error at one order.
//!
//! Rows come one at a time ([`Reading`]), as the courier happens to move. A *window* of them ([`Window`]) is a regression of the parity on
//! the functions of equation (3), with what else the parity holds in the same equation: an offset that may wander, shapes of both
//! directions' phases together (products of an own and a lateral order, which no calibration by the parity fits), what a change leaves of
//! orders 3 and 5, and noise that is not
//! white, which is whitened by its own correlation (Cochrane and Orcutt 1949). What windows say is compared with a *reference*, which the
//! first ones after a calibration determine (phase I of a control chart; Montgomery 2012, section 5.3), and summed by Page's test for each
//! segment, order and direction of the wave (`scores`; Page 1954, Biometrika 41, 100). Its rate of false alarms is stated by Lorden's bound
//! (1971, Annals of Mathematical Statistics 42, 1897).
//!
//! What is watched is seen by the parity alone. A change that both segments of a pair share exactly, phase for phase, leaves none in it
//! where the courier does not turn; its segment is told by the turning of ordinary motion.
//!
//! Pure: no clock, no allocation, no panic. Memory: a window 13 KiB, what outlives it 0.5 KiB.

mod cells;
mod config;
mod follow;
mod kept;
mod lag;
mod places;
mod row;
mod scores;
mod state;
mod told;
mod turning;
mod verdict;
mod window;
mod windowed;

pub(crate) use cells::Cells;
pub(crate) use config::LEFT_ALONE;
pub use config::WatchConfig;
pub use follow::{AMOUNTS, Amounts, Follower, Whole};
pub use kept::{KEPT_BYTES, Kept};
pub(crate) use kept::{seal, unseal};
pub use places::{PLACES, Place};
pub use row::Reading;
pub(crate) use scores::MOST;
pub use state::Watch;
pub(crate) use state::{REFERENCE_WINDOWS, TAKEN_BACK};
pub use verdict::{Change, Standing, Verdict};
pub use window::Window;
pub use windowed::Windowed;
