//! The check of a number that a user or a host states.

/// A number outside its range, or not one.
#[derive(Clone, Copy, Debug, PartialEq, thiserror::Error)]
#[error("{name} is {value}, wanted {low} to {high}")]
pub struct OutOfRange {
    /// Which.
    pub name: &'static str,
    /// Its value.
    pub value: f32,
    /// Smallest.
    pub low: f32,
    /// Largest.
    pub high: f32,
}

/// Checks a number.
///
/// # Errors
/// It is outside its range, or not a number.
#[inline(never)] // called some sixty times: inlined it is 1 KiB of flash
pub fn within(name: &'static str, value: f32, low: f32, high: f32) -> Result<(), OutOfRange> {
    if value >= low && value <= high {
        Ok(())
    } else {
        Err(OutOfRange {
            name,
            value,
            low,
            high,
        })
    }
}
