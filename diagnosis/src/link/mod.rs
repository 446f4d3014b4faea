//! From what speaks for a named effect to the probability that it acts.
//!
//! The posterior's odds are frequencies only as far as its priors and its effects' forms are right. A *link* makes frequencies of them: a
//! logistic function of what speaks for the effect ([`Support`]), fitted on couriers whose effects are known and judged on others.
//! `link.csv` has its coefficients, and says of what they were fitted; the example `link` of the crate `blind` writes it.

mod fit;
mod logistic;
mod support;

pub use fit::Fitted;
pub use logistic::{Link, state_probabilities};
pub use support::Support;
