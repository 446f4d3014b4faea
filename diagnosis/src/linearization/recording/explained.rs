//! What is known of what changes the amplitudes.

/// What place and time explain of the amplitudes, by segment and sample; empty where nothing is explained.
#[derive(Clone, Debug, Default)]
pub struct Amplitudes {
    /// Part of the logarithm that the place explains; `None` where that was not looked for.
    pub by_place: Option<[Vec<f64>; 4]>,
    /// Part of the logarithm that offsets which change with the place explain; empty where they do not.
    pub by_offsets: [Vec<f64>; 4],
    /// Offset of sine and cosine, gain and angle, less [`Self::mean_flaws`].
    pub pair_course: [Vec<[f64; 4]>; 4],
    /// Their means over the time, or those of another recording that this one is told by ([`super::ReferenceValues`]).
    pub mean_flaws: [Vec<f64>; 4],
}
