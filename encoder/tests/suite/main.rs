//! What `encoder::learn` learns, on simulated encoders and on recordings of real ones.

mod compiled;
mod forms;
mod index;
mod logs;
mod rings;
mod shared;
mod simulated;
mod spun;
mod waveforms;
