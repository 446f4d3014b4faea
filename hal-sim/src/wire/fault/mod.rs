//! What can go wrong with any part, as wrappers around it: the part itself stays as it is.
//!
//! A [`Switch`] says which fault acts and when; its clones are the same switch, so that a test turns a fault on and off while the
//! wrapped part is in the driver's hands. Everything is seeded: a run repeats exactly.

mod flash;
mod inputs;
mod pin;
mod serial;
mod spi;

pub use flash::{FaultyFlash, FlashFault};
pub use inputs::InputFault;
pub(crate) use inputs::spoil;
pub use pin::{FaultyPin, Level};
pub use serial::{FaultySerial, SerialFault};
pub use spi::{FaultySpi, SpiFault};

use effects::random::{ChaCha8Rng, SeedableRng, uniform};
use std::cell::RefCell;
use std::rc::Rc;

/// When a fault acts, counted in the part's own operations.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum When {
    /// At every operation.
    Always,
    /// At the next operations, so many.
    Next(u64),
    /// At each operation with this probability.
    Sometimes(f64),
}

struct State<F> {
    fault: Option<(F, When)>,
    rng: ChaCha8Rng,
    struck: u64,
}

/// Turns one kind of fault on and off.
pub struct Switch<F>(Rc<RefCell<State<F>>>);

impl<F> Clone for Switch<F> {
    fn clone(&self) -> Self {
        Self(self.0.clone())
    }
}

impl<F: Copy> Switch<F> {
    /// Off.
    pub fn new(seed: u64) -> Self {
        Self(Rc::new(RefCell::new(State {
            fault: None,
            rng: ChaCha8Rng::seed_from_u64(seed),
            struck: 0,
        })))
    }

    /// From now on this fault acts.
    pub fn set(&self, fault: F, when: When) {
        self.0.borrow_mut().fault = Some((fault, when));
    }

    /// From now on all is well.
    pub fn clear(&self) {
        self.0.borrow_mut().fault = None;
    }

    /// Operations that the fault has spoilt so far: a test whose fault never struck has shown nothing.
    pub fn struck(&self) -> u64 {
        self.0.borrow().struck
    }

    /// The fault, if it acts on the operation that begins now.
    fn strike(&self) -> Option<F> {
        let state = &mut *self.0.borrow_mut();
        let (fault, when) = state.fault.as_mut()?;
        let acts = match when {
            When::Always => true,
            When::Next(left) => {
                let acts = *left > 0;
                *left = left.saturating_sub(1);
                acts
            }
            When::Sometimes(probability) => uniform(&mut state.rng, 0.0, 1.0) < *probability,
        };
        state.struck += u64::from(acts);
        acts.then_some(*fault)
    }

    fn uniform(&self, high: f64) -> f64 {
        uniform(&mut self.0.borrow_mut().rng, 0.0, high)
    }

    /// Each bit of each byte flips with this probability.
    fn flip(&self, bytes: &mut [u8], probability: f64) {
        for byte in bytes {
            for bit in 0..8 {
                if self.uniform(1.0) < probability {
                    *byte ^= 1 << bit;
                }
            }
        }
    }
}
