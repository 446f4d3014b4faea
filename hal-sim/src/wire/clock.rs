//! Virtual time: it passes when a part takes time, never by itself.

use std::cell::Cell;
use std::rc::Rc;

/// Shared clock in nanoseconds; clones are the same clock.
#[derive(Clone, Debug, Default)]
pub struct Clock(Rc<Cell<u64>>);

impl Clock {
    /// A clock at zero.
    pub fn new() -> Self {
        Self::default()
    }

    /// Nanoseconds since the simulation began.
    pub fn now_ns(&self) -> u64 {
        self.0.get()
    }

    /// Seconds since the simulation began.
    pub fn now_s(&self) -> f64 {
        self.0.get() as f64 * 1e-9
    }

    /// Lets time pass.
    pub fn advance_ns(&self, duration_ns: u64) {
        self.0.set(self.0.get() + duration_ns);
    }

    /// Lets time pass until an instant; nothing if it is past. Tells whether it was still ahead.
    pub fn advance_to_ns(&self, instant_ns: u64) -> bool {
        let ahead = instant_ns > self.0.get();
        if ahead {
            self.0.set(instant_ns);
        }
        ahead
    }
}

impl embedded_hal::delay::DelayNs for Clock {
    fn delay_ns(&mut self, ns: u32) {
        self.advance_ns(u64::from(ns));
    }
}
