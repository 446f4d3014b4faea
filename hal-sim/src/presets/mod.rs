//! Couriers that are asked for by name.

mod ideal;
mod make;
mod measured;
mod number;
mod paper;

pub use ideal::ideal;
pub use make::of_the_make;
pub use measured::{DEFAULT_RMS_M, MeasuredWaveforms, WaveformFileError, measured};
pub use number::device_number;
pub use paper::{paper, paper_on_platen};
