//! Firmware of the courier's position sensor. The way of the data, in order:
//!
//! drivers -> frame::RawFrame -> step (quadrature, psd, model) -> frame::Frame -> calibration (session, lsq) -> record, link
//!
//! `docs/design.md` tells what each part may know. The library is `no_std` everywhere, also on the host.
#![no_std]

pub mod app;
#[cfg(target_os = "none")]
pub mod board;
pub mod drivers;
pub mod emulation;
pub mod event_log;
pub mod health;
pub mod link;
pub mod maps;
pub mod selftest;
pub mod update;

pub use courier_calibration as calibration;
pub use courier_calibration::device;
use courier_calibration::sink;
pub use courier_signal::{
    beacon, diode, encoder, equations, frame, geometry, lsq, math, model, psd, quadrature, queue,
    range, settings, step, swap, teeth,
};
