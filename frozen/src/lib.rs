//! The diagnosis' answers to a set of specimens, kept in `answers.jsonl`, and today's answers compared with them.
//!
//! A change that only moves code must leave every answer as it was. A change that is meant to alter answers writes those anew
//! and says in its commit which they are.
//!
//! [`specimen`]: what is diagnosed, stated in full, so that a longer catalogue draws no other courier. [`answer`]: what is kept
//! of a diagnosis. [`mod@compare`]: how two answers may differ. [`rounding`]: what
//! another processor's arithmetic may do to an answer. [`list`]: the set. [`short`]: the many of it that are
//! answered in half a second each. [`mod@file`]: one line a specimen.

pub mod answer;
pub mod compare;
pub mod file;
pub mod list;
mod rigged;
pub mod rounding;
pub mod short;
pub mod specimen;

pub use answer::Answer;
pub use compare::{Difference, RELATIVE, compare};
pub use file::{Kept, read, write};
pub use specimen::Specimen;
