//! How the readings of a pair go together.

/// The most correlation that is taken out: above, what is left of the offset's column is rounding. Derived from what is left: √(1
/// - 0.98²) is a fifth of the column.
const MOST_CORRELATION: f32 = 0.98;
/// Readings over which the parity's mean is followed. Derived from its noise: a mean over 64 adds 0.8 % to a reading's.
const MEAN_READINGS: f32 = 64.0;

/// How what the window before leaves of a pair's parities goes together: waves that it knows are no structure.
#[derive(Clone, Copy, Debug)]
pub(super) struct Lag {
    mean_m: f32,
    product: f32,
    square: f32,
}

impl Lag {
    /// Nothing is known.
    pub const ZERO: Self = Self {
        mean_m: 0.0,
        product: 0.0,
        square: 0.0,
    };

    /// Begins anew, with the mean that is known.
    pub fn begin(&mut self) {
        (self.product, self.square) = (0.0, 0.0);
    }

    /// Adds a pair, metres.
    pub fn note(&mut self, first_m: f32, second_m: f32) {
        self.mean_m += (first_m - self.mean_m) / MEAN_READINGS;
        let (first, second) = (first_m - self.mean_m, second_m - self.mean_m);
        self.product += first * second;
        self.square += 0.5 * (first * first + second * second);
    }

    /// Correlation of a pair.
    pub fn correlation(&self) -> f32 {
        #[allow(clippy::manual_clamp)] // nothing over nothing counts as none
        let bounded = (self.product / self.square).max(0.0).min(MOST_CORRELATION);
        bounded
    }
}
