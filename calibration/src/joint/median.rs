//! Median of a stream of squares, in little memory.

/// Bins of the square. Derived from four an octave, 2^-2 to 2^46: a length is then told to 9 %.
const BINS: usize = 192;
/// Smaller squares fall into the first bin. By definition of an f32, whose exponents are kept with 127 more.
const LEAST_EXPONENT: u32 = 127 - 2;
/// Bits of a number right of its exponent and two bits of mantissa. By definition of an f32: 23 less two.
const SHIFT: u32 = 21;

/// Histogram of up to 65,535 numbers that are not negative.
#[derive(Clone, Debug)]
pub struct Median {
    counts: [u16; BINS],
}

impl Median {
    /// Of nothing.
    #[must_use]
    pub const fn new() -> Self {
        Self { counts: [0; BINS] }
    }

    /// Forgets all.
    pub fn clear(&mut self) {
        self.counts.fill(0);
    }

    /// Adds a number; one that is none counts as infinite.
    pub fn add(&mut self, square: f32) {
        let bin = (square.to_bits() >> SHIFT).saturating_sub(LEAST_EXPONENT << 2) as usize;
        let count = &mut self.counts[bin.min(BINS - 1)];
        *count = count.saturating_add(1);
    }

    /// Bound above the median of `all` numbers added, within a quarter of an octave.
    #[must_use]
    pub fn upper(&self, all: usize) -> f32 {
        let mut sum = 0;
        let bin = self.counts.iter().position(|&count| {
            sum += usize::from(count);
            2 * sum >= all
        });
        f32::from_bits(((bin.unwrap_or(0) as u32 + 1) << SHIFT) + (LEAST_EXPONENT << 23))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_median_is_bounded_from_above_within_a_quarter_of_an_octave() {
        for middle in [0.3f32, 1.0, 77.0, 3.0e8] {
            let mut median = Median::new();
            for n in 0..1001 {
                median.add(middle * 1.01f32.powi(n - 500));
            }
            let upper = median.upper(1001);
            assert!(upper > middle && upper < 1.26 * middle, "{middle}: {upper}");
        }
    }

    #[test]
    fn what_is_no_number_is_far_out() {
        let mut median = Median::new();
        for square in [1.0, f32::NAN, 1.0, f32::INFINITY, 1.0] {
            median.add(square);
        }
        assert!((median.upper(5) - 1.25).abs() < 1.0e-6);
    }
}
