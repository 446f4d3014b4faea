//! Linear algebra and statistics that know no sensor.

pub(crate) mod cholesky;
pub(crate) mod envelope;
pub mod fourier;
pub(crate) mod normal_equations;
pub mod penalized;
pub(crate) mod products;
pub mod statistics;
pub mod symmetric;
