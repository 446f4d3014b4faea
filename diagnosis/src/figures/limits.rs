//! Limits that several parts share.

/// A gap shows if the whitened rms exceeds the simulator's own by this factor, or if shapes stand out beyond chance. A
/// definition: what is told as a gap (`docs/reading-a-diagnosis.md`).
pub const VISIBLE_GAP_RATIO: f64 = 1.05;
/// White noise is named from this factor on.
/// By definition: noise is called louder than stated from a tenth more.
pub const NOISY_RATIO: f64 = 1.10;
/// From this factor over the noise on, what a field that is named leaves may be told by single teeth.
pub const CLOSE_RATIO: f64 = 1.03;
/// More of the gap than this left over, and located, is a gap that nothing named explains.
/// By definition: a name explains nine tenths (`docs/reading-a-diagnosis.md`).
pub const UNEXPLAINED_SHARE: f64 = 0.10;
/// Shapes that describe a field where the courier did not go far.
pub const FIELD_COORDINATES: [&str; 2] =
    ["place on the platen", "own tooth phase, fractional orders"];
/// A further effect must take this many whitened squares. Derived from chi-square: of a candidate with twenty columns as many
/// come by chance once in 140,000, and of the best of twenty once in 7,000.
pub const MINIMUM_SQUARES: f64 = 60.0;
/// What is left would be a gap by itself from so many times the noise, rms, on.
pub const STAYS_VISIBLE: f64 = 1.0 + 2.0 * (VISIBLE_GAP_RATIO - 1.0);
/// No amount is larger than so many prior sizes. The largest of 150 recordings with effects of up to 4 µm rms is 4.3.
pub const LARGEST_PRIOR_SIZES: f64 = 8.0;
