//! Lines in spectra: of residuals, of amplitudes, of the light, over the deflection; and what a vibration's lines are on another recording.

pub(crate) mod deflection_waves;
pub(crate) mod flicker;
pub mod hum;
pub mod lines;
pub mod phase;
pub(crate) mod resonance;
