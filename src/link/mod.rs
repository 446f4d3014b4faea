//! The debug link: commands, replies and telemetry over byte channels. Pure, so that the host links the same code.
//!
//! `framing` puts messages on a byte channel (the motion port uses it too), `message` is what is said, `order` checks it,
//! `server` is the board's end, `client` the host's; `telemetry` packs samples, `report` tells of a calibration session.

pub mod client;
pub mod framing;
pub mod message;
mod order;
pub mod report;
pub mod server;
pub mod telemetry;

pub use order::JOINT_POSES;
