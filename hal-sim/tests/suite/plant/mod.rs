//! The plant against the equations, from the sensor's side; the presets against the figures they are sized for.

mod batch;
mod measured;
mod paper;
mod physics;
