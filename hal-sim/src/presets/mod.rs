//! Couriers that are asked for by name.

mod ideal;

pub use ideal::ideal;
