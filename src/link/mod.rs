//! The debug link: commands, replies and telemetry over byte channels. Pure, so that the host links the same code.
//!
//! `framing` puts messages on a byte channel (the motion port uses it too), `telemetry` packs samples.

pub mod framing;
pub mod telemetry;
