//! The courier's parts as they answer on the wire: bits, levels and bytes, in virtual time.
//!
//! `clock` is the one time of a simulation; `ad7606c` a converter chip, `converter` two of them with bus and pins,
//! `motion` the motion controller behind its serial line, `flash` a NOR flash, `fault` what can go wrong with any of them.

pub mod ad7606c;
pub mod clock;
pub mod converter;
pub mod fault;
pub mod flash;
pub mod link;
pub mod motion;
pub mod trajectory;
