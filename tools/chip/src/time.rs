//! Virtual time: ticks of 1/1360 MHz, of which the 16 MHz oscillator, 170 MHz and 32 kHz are whole numbers.

/// Instant or duration, ticks since power-on.
pub type Ticks = u64;

/// Ticks a second: the least common multiple of 16 MHz and 170 MHz.
pub const TICK_HZ: u64 = 1_360_000_000;

/// An instant that never comes.
pub const NEVER: Ticks = Ticks::MAX;

/// Ticks of a duration in nanoseconds.
pub const fn from_ns(ns: u64) -> Ticks {
    ns * 34 / 25
}

/// Ticks of a duration in microseconds.
pub const fn from_us(us: u64) -> Ticks {
    from_ns(1000 * us)
}

/// Nanoseconds of a number of ticks.
pub const fn to_ns(ticks: Ticks) -> u64 {
    // In two parts, so that it does not overflow within years.
    ticks / 34 * 25 + ticks % 34 * 25 / 34
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_second_is_whole_in_every_unit() {
        assert_eq!(from_us(1_000_000), TICK_HZ);
        assert_eq!(to_ns(TICK_HZ), 1_000_000_000);
        assert_eq!(to_ns(TICK_HZ * 1_000_000), 1_000_000_000_000_000);
        for hz in [16_000_000, 170_000_000, 85_000_000, 32_000] {
            assert_eq!(TICK_HZ % hz, 0, "{hz}");
        }
    }
}
