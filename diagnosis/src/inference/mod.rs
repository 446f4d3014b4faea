//! What fits say: held-out residuals, likelihoods, prior sizes, covariances, intervals.

pub(crate) mod aperture;
pub mod ard;
pub(crate) mod bootstrap;
pub mod covariance;
pub mod cross_validation;
pub mod fit;
pub mod fit_scatter;
pub mod left_out;
pub mod posterior;
pub mod residuals;
pub mod schur;
