//! The displaced teeth of a platen as a field over places, once for the tooth map and for the diagnosis.
//!
//! A segment averages over the teeth under it. Its reading of one direction's field is a sum over the nodes of a [`Lattice`], each
//! times its weight at the segment's place, and over whole lines of nodes:
//!
//! ```text
//! field(along, across) = sum_ij w(along - i) w(across - j) node_ij + sum_i w(along - i) line_i
//! ```
//!
//! Displacements of nodes and of lines are independent of each other before the data, with a stated deviation each. Both segments of
//! a pair read the same field. The displacements are fitted together with everything else by least squares with those priors
//! (`normal-equations`).
//!
//! ```text
//! kernel    the weights w, and how the readings at two places go together
//!   lattice   nodes under a place, nodes that a motion passed, deviation of a field
//!   values    a field told by its values on a mesh, with the same correlation
//!   teeth     what a diagnosis found: kernel, nodes, deviations
//! ```
//!
//! The two users differ in what they are asked, and in that alone:
//!
//! | | tooth map | diagnosis |
//! |---|---|---|
//! | kernel | [`CubicSpline`]: the board applies it, in whole numbers | [`ApertureKernel`], estimated; [`MeshKernel`] while it searches |
//! | nodes | a whole rectangle for each direction, as the board stores it | the nodes that the motion passed: each is a column beside those of other effects |
//! | deviation of a node | a prior from the paper | estimated with the kernel |
//! | field | one for each direction | the same; a field for each segment or for each constraint while it searches, which is coarser |

mod kernel;
mod lattice;
mod teeth;
pub mod values;

pub use kernel::{ApertureKernel, CubicSpline, Kernel, MeshKernel, correlations, cubic_b_spline};
pub use lattice::{Lattice, order_of_places};
pub use teeth::Teeth;
