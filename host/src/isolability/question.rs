//! What is asked of a planned self-motion.

use courier_sensor::geometry::Geometry;
use serde::Serialize;

/// A planned self-motion.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Motion {
    /// Poses.
    pub poses: u32,
    /// Range in x and y, metres.
    pub travel_m: f32,
    /// Largest angle to either side, radians.
    pub turn_rad: f32,
    /// Turning about the coordination sensor under a beacon: g_x and g_y are there as well as g_p.
    pub beacon: bool,
    /// Whether poses are chosen instead of drawn.
    pub chosen: bool,
    /// Of the pose generator.
    pub seed: u64,
}

/// What is asked.
#[derive(Clone, Debug)]
pub struct Question {
    /// Geometry.
    pub geometry: Geometry,
    /// The motion.
    pub motion: Motion,
    /// Noise of a pose's averaged readings, metres.
    pub noise_m: f32,
    /// Whether the diode's own errors are among the unknowns.
    pub sensor_terms: bool,
}
