//! Fleets of simulated couriers: the plant is hal-sim's, which shares nothing with the fit.

mod crossed;
mod rulings;
mod simulated;
mod sums;
