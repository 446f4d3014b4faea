//! The catalogue of effects: one file each, with the plant side and the sensor side.
