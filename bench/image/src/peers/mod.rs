//! The same work by other means: 8 counts to 4 phases, equation (3) on four segments, pose and parity, electrodes to tan psi.
//!
//! Less than our own does: no tooth count, no status beyond the amplitude's limits, no pair correction beyond the offset.

#[cfg(feature = "cmsis")]
pub mod cmsis;
pub mod libm;
pub mod qr;

/// What the peers read.
#[repr(C)]
pub struct Coefficients {
    /// Offsets of each pair, counts.
    pub offset: [[f32; 2]; 4],
    /// k_i,0 to k_i,8 of each segment, in the order of equation (3), metres.
    pub k: [[f32; 9]; 4],
    /// Tooth pitch, metres.
    pub pitch_m: f32,
    /// Distance of a pair's segments, metres.
    pub span_m: f32,
    /// Limits of the amplitude, counts.
    pub amplitude: [f32; 2],
    /// tan psi at a deflection of 1.
    pub full_scale: f32,
}

/// What they write.
#[repr(C)]
#[derive(Default)]
pub struct Outcome {
    /// p_x, p_y, theta_x, theta_y, theta.
    pub pose: [f32; 5],
    /// g_p.
    pub parity_m: f32,
    /// tan psi of both axes.
    pub tan_psi: [f32; 2],
    /// One bit an amplitude that is out of range.
    pub status: u32,
}

impl Coefficients {
    /// Plausible ones.
    pub fn new() -> Self {
        Self {
            offset: [[30.0, 20.0]; 4],
            k: core::array::from_fn(|i| {
                core::array::from_fn(|k| (1 + (3 * i + k) % 5) as f32 * 1.0e-6)
            }),
            pitch_m: 1.016e-3,
            span_m: 9.7e-3,
            amplitude: [4000.0, 32_000.0],
            full_scale: 0.1,
        }
    }
}
