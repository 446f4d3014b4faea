//! Fleets of simulated couriers: the plant is hal-sim's, which shares nothing with the fit.

mod crossed;
mod simulated;
mod sums;
