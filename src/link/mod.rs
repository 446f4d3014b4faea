//! The debug link: commands, replies and telemetry over byte channels. Pure, so that the host links the same code.
//!
//! `framing` puts messages on a byte channel (the motion port uses it too), `message` is what is said, `order` checks it,
//! `refusal`, `status` and `health` are parts of the answers, `server` is the board's end, `client` the host's; `telemetry` packs samples, `report` tells of a calibration session.

pub mod client;
pub mod framing;
mod health;
pub mod message;
mod order;
mod refusal;
pub mod report;
pub mod server;
mod status;
pub mod telemetry;

pub use order::{JOINT_POSES, LEAST_JOINT_POSES, LEAST_PLATEN_POSES, PLATEN_POSES};
