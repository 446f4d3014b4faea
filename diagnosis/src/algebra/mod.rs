//! Linear algebra and statistics that know no sensor.

pub(crate) mod envelope;
pub mod fourier;
pub(crate) mod normal_equations;
pub mod penalized;
pub mod statistics;
