//! The chip's CRC unit, set to the converters' polynomial. The sampling interrupt alone uses it.

use crate::drivers::ad7606c::{CHANNELS, CRC16};
use stm32_metapac::crc::vals::Polysize;
use stm32_metapac::{CRC, RCC};

/// Sets it up: 16 bits, most significant bit first, from zero.
pub fn start() {
    RCC.ahb1enr().modify(|w| w.set_crcen(true));
    CRC.init().write_value(u32::from(CRC16.algorithm.init));
    CRC.pol().write_value(u32::from(CRC16.algorithm.poly));
    CRC.cr().write(|w| w.set_polysize(Polysize::POLYSIZE16));
}

/// CRC of a conversion frame's data, as words whose most significant byte came first. A word takes the unit four cycles; a store that comes earlier waits.
#[inline(always)]
pub fn of([a, b, c, d]: [u32; CHANNELS / 2]) -> u16 {
    CRC.cr().write(|w| {
        w.set_polysize(Polysize::POLYSIZE16);
        w.set_reset(true);
    });
    // Written out: the image is built for size, which leaves loops as they are.
    CRC.dr32().write_value(a);
    CRC.dr32().write_value(b);
    CRC.dr32().write_value(c);
    CRC.dr32().write_value(d);
    CRC.dr32().read() as u16
}
