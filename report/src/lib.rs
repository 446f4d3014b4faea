//! Tells a [`diagnosis::Diagnosis`]: [`headline`] in a sentence, [`advice`] what to record next, [`remainder`] what is known of what no effect explains, [`units`] amounts in the
//! units that a reader expects, [`html`] all of it on a page with plots.
//!
//! Nothing here decides anything: what is told is in the diagnosis and in its evidence.

pub mod advice;
pub mod headline;
pub mod html;
pub mod motions;
pub mod remainder;
pub mod units;
