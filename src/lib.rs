//! Firmware of the courier's position sensor. The way of the data, in order:
//!
//! drivers -> frame::RawFrame -> step (quadrature, psd, model) -> frame::Frame -> calibration (session, lsq) -> record, link
//!
//! `docs/design.md` tells what each part may know. The library is `no_std` everywhere, also on the host.
#![no_std]

pub mod app;
#[cfg(target_os = "none")]
pub mod board;
pub mod calibration;
pub mod drivers;
pub mod emulation;
pub mod frame;
pub mod geometry;
mod lanes;
pub mod link;
pub mod lsq;
pub mod math;
pub mod model;
pub mod psd;
pub mod quadrature;
pub mod settings;
pub mod step;
pub mod swap;
