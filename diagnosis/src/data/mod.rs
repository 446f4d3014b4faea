//! From a recording to observations: what is read, repaired, marked and left aside.

pub mod adequacy;
pub mod channel_names;
pub mod channels;
pub mod clip;
pub mod commanded;
pub(crate) mod coverage;
pub(crate) mod faint;
pub mod folds;
pub(crate) mod held_reference;
pub(crate) mod interpolation;
pub(crate) mod lacking;
pub mod late;
pub mod late_segment;
pub(crate) mod local_fit;
pub mod motion;
pub mod observations;
pub(crate) mod one_way;
pub mod outliers;
pub mod play_operator;
pub mod prepare;
pub(crate) mod recurring;
pub mod restarts;
pub mod slips;
pub(crate) mod spot;
pub mod thinning;
pub mod tooth_counts;
