//! With CMSIS-DSP's functions, in C: bench/peers/cmsis.c.

use super::{Coefficients, Outcome};
use courier_sensor::frame::RawFrame;

unsafe extern "C" {
    fn peer_step(
        c: *const Coefficients,
        quadrature: *const [i16; 2],
        electrodes: *const i16,
        out: *mut Outcome,
    );
}

/// The same pipeline.
#[inline(never)]
pub fn step(c: &Coefficients, raw: &RawFrame, out: &mut Outcome) {
    // SAFETY: reads 4 pairs and 4 electrodes, writes one outcome; both structures have C's layout.
    unsafe {
        peer_step(
            c,
            raw.quadrature_counts.as_ptr(),
            raw.electrode_counts.as_ptr(),
            out,
        )
    };
}
