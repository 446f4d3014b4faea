//! Recordings drawn at random, and every command that reads one.
//!
//! [`draw`] makes a recording from a number: any subset, order, length, speed and repetition of motions, cut anywhere, with channels
//! that are missing, constant or frozen, values at the ends of their ranges, and stated values within theirs. Each is one that the
//! reader takes. [`through`] sends it through `diagnose`, `check`, `replay` and `map` and tells where one of them panics: an answer
//! and a refusal are both right, an error of the program never is. [`cuts`] holds the diagnosis against surveys that were cut short.
//!
//! The ordinary tests try some hundred; `cargo xtask robustness` tries as many as a night has room for.

pub mod cuts;
pub mod draw;
pub mod through;
