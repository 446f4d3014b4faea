//! Columns of the baseline, of the effects and of shapes over coordinates, and their products.

pub mod assembly;
mod column_values;
pub mod coordinate_basis;
pub mod errors_in_variables;
pub mod excitation;
pub(crate) mod fine_basis;
pub(crate) mod frequency_basis;
pub mod gram;
pub mod knots;
pub(crate) mod nameless;
pub(crate) mod single_teeth;
pub mod thinned;
pub mod training;
pub mod unlisted;
