//! Firmware update on two simulated banks: refusals, choices, and a power cut at every step.

mod choices;
mod log;
mod maps;
mod orders;
mod power_cuts;
mod refused;
mod rig;
