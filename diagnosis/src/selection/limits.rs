//! Limits that several parts of the selection share.

/// A gap shows if the whitened rms exceeds the simulator's own by this factor, or if shapes stand out beyond chance. A
/// definition: what is told as a gap (`docs/reading-a-diagnosis.md`).
pub const VISIBLE_GAP_RATIO: f64 = 1.05;
/// White noise is named from this factor on.
pub const NOISY_RATIO: f64 = 1.10;
/// Beyond this factor the found effects' second order and lines of the spectrum may be what is left, and all is compared anew.
pub const CLOSE_RATIO: f64 = 1.03;
/// Times that all is compared anew about what was found, while that finds more. A bound on the work: what the last finds is told.
pub const RELINEARIZATIONS: usize = 2;
/// About what was found no more than this many times as much as before must be left: else the places strayed with it.
pub const DIVERGED_RATIO: f64 = 1.5;
/// More of the gap than this left over, and located, is a gap that nothing named explains.
pub const UNEXPLAINED_SHARE: f64 = 0.10;
/// What is found moves the places that shapes are evaluated at if it leaves less than this share.
pub const TRUSTED_BELOW: f64 = 0.3;
/// What is found explains little if it leaves more than this share.
pub const EXPLAINS_LITTLE_ABOVE: f64 = 0.7;
/// A gap of which all shapes together leave more than this share lies nowhere yet: shorter waves are looked for.
pub const UNLOCATED_ABOVE: f64 = 0.85;
/// They are taken over the unmodified phase if that leaves less than this share.
pub const OTHER_PHASE_LEAVES: f64 = 0.7;
/// All else is compared over it only where the harmonics themselves take this share more of what they leave.
pub const OTHER_PHASE_TAKES: f64 = 0.1;
/// Shapes that describe a field where the courier did not go far.
pub const FIELD_COORDINATES: [&str; 2] =
    ["place on the platen", "own tooth phase, fractional orders"];
/// A further effect must take this many whitened squares. Derived from chi-square: of a candidate with twenty columns as many
/// come by chance once in 140,000, and of the best of twenty once in 7,000.
pub const MINIMUM_SQUARES: f64 = 60.0;
/// What takes this share of what is left without it is no stand-in, however small a share of the whole gap it is, and though what
/// is left without it hardly shows.
pub const COMPLETING_SHARE: f64 = 0.8;
/// Beyond chance as well: this many whitened squares, four times what the search asks of any.
pub const COMPLETING_SQUARES: f64 = 4.0 * MINIMUM_SQUARES;
/// Fitted about itself it completes what is found, or takes this share of what is left if to first order no shape without a name takes as
/// much: the shape that such a stand-in replaces would.
pub const LEADING_SHARE: f64 = 0.6;
/// An effect that takes this share of what is left stands in for nothing that lacks.
pub const LARGELY_COMPLETES: f64 = 0.9;
/// What is left would be a gap by itself from so many times the noise, rms, on.
pub const STAYS_VISIBLE: f64 = 1.0 + 2.0 * (VISIBLE_GAP_RATIO - 1.0);
/// No amount is larger than so many prior sizes. The largest of 150 recordings with effects of up to 4 µm rms is 4.3.
pub const LARGEST_PRIOR_SIZES: f64 = 8.0;
