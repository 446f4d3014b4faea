//! What the sensor board's lines to the converters do, and when: the board's code makes these times, and `courier trace` judges a recording
//! of the lines by them.

/// Sampling instants, and so pulses of CONVST, a second.
pub const RATE_HZ: u32 = 20_000;
/// CONVST is high so long, nanoseconds. The timer makes it: 10 ns are enough for the chips (AD7606C-16 data sheet), and slow edges of the
/// line take 25 ns of it.
pub const CONVST_HIGH_NS: u32 = 500;
/// BUSY rises so long after CONVST at most, nanoseconds (AD7606C-16 data sheet, t_D_CNV_BSY).
pub const BUSY_RISES_WITHIN_NS: u32 = 25;
/// BUSY is high for less than this, nanoseconds. Without oversampling, which is off while the board samples, a conversion takes 1 us at most,
/// and with the least of it up to 3 us (Analog Devices' no-OS driver, `tconv_max`).
pub const BUSY_BELOW_NS: u32 = 2_000;
/// Both chips are selected so long after BUSY falls at most, nanoseconds: the interrupt's entry and the some 100 cycles up to its two stores take
/// 700 ns without wait states.
pub const SELECTED_WITHIN_NS: u32 = 1_000;
/// Clock of both buses, hertz: 170 MHz / 8. The chips take 60 MHz at 3.3 V (AD7606C-16 data sheet).
pub const SCLK_HZ: u32 = 21_250_000;
/// A chip is selected for so long, nanoseconds, least and most: a frame's 144 clocks take 6.8 us, and start and end of the transfer some 60 cycles
/// more; the most is for an interrupt at the transfer's end that waits.
pub const SELECTED_NS: [u32; 2] = [7_000, 10_000];
