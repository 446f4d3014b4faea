//! The catalogue: sizes of effects, and the clip model.
//!
//! One program of many files: each further program would be linked, and its helpers compiled, once more.

mod clip;
mod sizes;
