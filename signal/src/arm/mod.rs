//! What only the Cortex-M4F can do: its square root, and the estimator's rotations in assembly. The one place of `unsafe` in this
//! package.

pub mod fpu;
pub mod givens;
