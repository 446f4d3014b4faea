//! A pin with faults.

use super::Switch;
use embedded_hal::digital::{ErrorType as PinErrorType, InputPin, OutputPin};

/// Faults of a pin: the line is stuck at this level, whatever is on the other side.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Level(pub bool);

/// A pin with faults.
pub struct FaultyPin<P> {
    part: P,
    switch: Switch<Level>,
}

impl<P> FaultyPin<P> {
    /// Wraps a pin.
    pub fn new(part: P, switch: Switch<Level>) -> Self {
        Self { part, switch }
    }
}

impl<P: PinErrorType> PinErrorType for FaultyPin<P> {
    type Error = P::Error;
}

impl<P: InputPin> InputPin for FaultyPin<P> {
    fn is_high(&mut self) -> Result<bool, P::Error> {
        // Read in any case: a look at a pin takes time.
        let high = self.part.is_high()?;
        Ok(self.switch.strike().map_or(high, |level| level.0))
    }

    fn is_low(&mut self) -> Result<bool, P::Error> {
        self.is_high().map(|high| !high)
    }
}

impl<P: OutputPin> OutputPin for FaultyPin<P> {
    fn set_high(&mut self) -> Result<(), P::Error> {
        match self.switch.strike() {
            Some(Level(false)) => self.part.set_low(),
            _ => self.part.set_high(),
        }
    }

    fn set_low(&mut self) -> Result<(), P::Error> {
        match self.switch.strike() {
            Some(Level(true)) => self.part.set_high(),
            _ => self.part.set_low(),
        }
    }
}
