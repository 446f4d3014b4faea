//! Incremental linear least squares in f32: rows -> triangle -> solution, rank, covariance.
//!
//! The problem is `row * x = rhs`, one equation a call. Rows are rotated into an upper-triangular factor (Givens 1958;
//! Golub and Van Loan, sec. 5.2), so memory does not grow with their number and the normal equations, whose condition
//! number is squared, are never formed. All arithmetic is plain multiply and add, never fused: host and target give
//! the same bits. No allocation, no panic on any input. Runs below the interrupt.
//!
//! * `packed`: where things lie; `rotate`: a row into the factor, four square-root-free rotations a pass;
//! * `triangle`: the factor, its right-hand side, residual and count; `downdate` takes a row out, `predict` foretells one,
//!   `shift` counts the unknowns from another point, `block` takes the last unknowns by themselves;
//! * `upper`: the factor as it is solved, with ordinary rotations (`givens`); `spectrum`: its singular values;
//!   `null`: a direction it does not determine;
//! * `solve`: rank, condition number, solution, covariance.
//!
//! Sizes are const generics: `N` unknowns at most and `P = packed_len(N)`; fewer unknowns may be in use at run time.

mod block;
mod downdate;
mod givens;
mod null;
mod packed;
mod predict;
mod rotate;
mod shift;
mod solve;
mod spectrum;
mod triangle;
mod upper;

pub use packed::packed_len;
pub use predict::Prediction;
pub use solve::{Estimator, Solution, SolveError};
pub use triangle::{RowError, Triangle};
