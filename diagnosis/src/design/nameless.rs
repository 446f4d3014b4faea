//! Shapes that no effect owns: how a column's name calls a channel, and their prior size.

/// Channels that a shape may act in directly.
pub const CHANNEL: [&str; 3] = ["g_p", "g_x", "g_y"];
/// Prior size of a free shape, rms m: what calibration leaves of a segment, 2 to 3 µm by the 4.1 to 5.5 µm that it leaves of the
/// parity of four (paper, 3.1.2).
pub const SIZE_M: f64 = 3.0e-6;
