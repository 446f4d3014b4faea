//! What is wanted of the lines. The times are the board's own ([`timing`]); here they are seconds, with what a board may be off.

use courier_sensor::drivers::ad7606c::FRAME_BYTES;
use courier_sensor::drivers::converter::timing;

const NS: f64 = 1.0e-9;

/// What the board's clock may be off, a share: its internal oscillator leaves the factory within 0.75 % and changes by up to 1 % between 0 and
/// 85 °C (STM32G474 data sheet DS12288, HSI16), rounded up.
pub const CLOCK_SHARE: f64 = 0.02;
/// How long an edge of a line takes at most, seconds: where in it an instrument sees the change is not known (DS12288, output of a pin
/// of low speed; the bring-up guide asks for edges below this).
pub const EDGE_S: f64 = 25.0 * NS;
/// From one pulse of CONVST to the next, seconds.
pub const PERIOD_S: f64 = 1.0 / timing::RATE_HZ as f64;
/// CONVST's pulse, seconds.
pub const CONVST_HIGH_S: f64 = timing::CONVST_HIGH_NS as f64 * NS;
/// From CONVST to BUSY at most, seconds.
pub const BUSY_RISES_WITHIN_S: f64 = timing::BUSY_RISES_WITHIN_NS as f64 * NS;
/// BUSY's pulse is shorter than this, seconds.
pub const BUSY_BELOW_S: f64 = timing::BUSY_BELOW_NS as f64 * NS;
/// From BUSY's fall to a chip select, and from one chip select to the other, at most, seconds.
pub const SELECTED_WITHIN_S: f64 = timing::SELECTED_WITHIN_NS as f64 * NS;
/// A chip is selected for so long, least and most, seconds.
pub const SELECTED_S: [f64; 2] = [
    timing::SELECTED_NS[0] as f64 * NS,
    timing::SELECTED_NS[1] as f64 * NS,
];
/// The buses' clock, hertz.
pub const SCLK_HZ: f64 = timing::SCLK_HZ as f64;
/// Clocks of a frame: eight channels and the check sum.
pub const FRAME_BITS: usize = 8 * FRAME_BYTES;
