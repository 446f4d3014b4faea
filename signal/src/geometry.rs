//! Nominal geometry of the sensor, SI units.

use serde::{Deserialize, Serialize};

/// Lengths of equations (3), (4), (9), (10) and (11).
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Geometry {
    /// Tooth pitch, rho.
    pub pitch_m: f32,
    /// Distance between the segments of a pair, l_s.
    pub span_m: f32,
    /// Lateral offset of a segment from the pair's axis, l_o.
    pub lateral_m: f32,
    /// Beacon's height over the diode, h.
    pub height_m: f32,
    /// Lever arm from the platen sensor to the coordination sensor, l_x and l_y.
    pub lever_m: [f32; 2],
    /// tan(psi) at a normalised deflection of 1.
    pub tan_full_scale: f32,
}

impl Geometry {
    /// The paper's courier. h, l_y, l_o and the full scale are not in the text: values of a plausible build.
    pub const PAPER: Self = Self {
        pitch_m: 1.016e-3,
        span_m: 9.7e-3,
        lateral_m: 3.0e-3,
        height_m: 50.0e-3,
        lever_m: [90.0e-3, 5.0e-3],
        tan_full_scale: 0.1,
    };
}
