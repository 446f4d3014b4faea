//! What the residual channels are called.

/// Names of the channels.
pub const CHANNEL_NAMES: [&str; 7] = [
    "g_p",
    "g_x",
    "g_y",
    "segment_1",
    "segment_2",
    "segment_3",
    "segment_4",
];
