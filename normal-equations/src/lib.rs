//! Least squares with a prior on every unknown, for thousands of unknowns: by normal equations, in f64.
//!
//! Unknowns are counted in deviations of their priors, so that each prior is a one on the diagonal. Rows are whitened: noise alone has
//! unit deviation.
//!
//! `products` (rows, chunk by chunk, to products of columns; `by_source` where a column is one number a sample) -> `symmetric` (their sums, at half the memory) -> `unit_priors`
//! (solution) by `cholesky` (factor, predicted deviations, evidence).

pub mod by_source;
pub mod cholesky;
pub mod products;
pub mod symmetric;
pub mod unit_priors;
