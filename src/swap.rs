//! Whole sets of coefficients from the background to the interrupt, between two samples.
//!
//! Two [`StepConfig`]s exist. The interrupt owns one (in force), the background the other (spare). The background
//! writes its spare and sends the reference down a queue of one place; the interrupt, before a sample, takes it and sends
//! its old one up. So each set has one owner at any time, none is ever half-written, nothing is copied in the interrupt,
//! and the interrupt's cost is a few loads and stores whether or not there is a new set.

use crate::step::StepConfig;
use heapless::spsc::{Consumer, Producer, Queue};

/// The two queues. Lives as long as both ends: in a static on the target.
pub struct SwapQueues<'c> {
    down: Queue<&'c mut StepConfig, 2>,
    up: Queue<&'c mut StepConfig, 2>,
}

impl<'c> SwapQueues<'c> {
    /// Empty queues.
    pub const fn new() -> Self {
        Self {
            down: Queue::new(),
            up: Queue::new(),
        }
    }

    /// Gives `active` to the interrupt's end and `spare` to the background's.
    pub fn split<'q>(
        &'q mut self,
        active: &'c mut StepConfig,
        spare: &'c mut StepConfig,
    ) -> (SwapSender<'q, 'c>, SwapReceiver<'q, 'c>) {
        let (send, receive) = self.down.split();
        let (give_back, reclaim) = self.up.split();
        (
            SwapSender {
                spare: Some(spare),
                send,
                reclaim,
            },
            SwapReceiver {
                active,
                receive,
                give_back,
            },
        )
    }
}

impl Default for SwapQueues<'_> {
    fn default() -> Self {
        Self::new()
    }
}

/// The interrupt has not taken the last set yet.
#[derive(Clone, Copy, Debug, PartialEq, Eq, thiserror::Error)]
#[error("the interrupt has not taken the last set of coefficients yet")]
pub struct SwapBusy;

/// The background's end.
pub struct SwapSender<'q, 'c> {
    spare: Option<&'c mut StepConfig>,
    send: Producer<'q, &'c mut StepConfig>,
    reclaim: Consumer<'q, &'c mut StepConfig>,
}

impl SwapSender<'_, '_> {
    /// The set that is not in force, to be written: [`SwapSender::send`] hands it over.
    ///
    /// # Errors
    /// [`SwapBusy`] while the last one waits: at most one sample's time while the interrupt runs.
    pub fn spare(&mut self) -> Result<&mut StepConfig, SwapBusy> {
        self.spare = self.spare.take().or_else(|| self.reclaim.dequeue());
        self.spare.as_deref_mut().ok_or(SwapBusy)
    }

    /// Puts the spare set in force from the next sample on.
    ///
    /// # Errors
    /// [`SwapBusy`] as for [`SwapSender::spare`].
    pub fn send(&mut self) -> Result<(), SwapBusy> {
        let spare = self.spare.take().ok_or(SwapBusy)?;
        self.send.enqueue(spare).map_err(|spare| {
            self.spare = Some(spare);
            SwapBusy
        })
    }

    /// Whether the interrupt has taken the last offered set.
    pub fn taken(&mut self) -> bool {
        self.spare().is_ok()
    }
}

/// The interrupt's end.
pub struct SwapReceiver<'q, 'c> {
    active: &'c mut StepConfig,
    receive: Consumer<'q, &'c mut StepConfig>,
    give_back: Producer<'q, &'c mut StepConfig>,
}

impl SwapReceiver<'_, '_> {
    /// The set for the next sample: call once before each [`crate::step::step`]. No copy, no wait.
    #[inline(always)]
    pub fn current(&mut self) -> &StepConfig {
        if self.give_back.ready()
            && let Some(new) = self.receive.dequeue()
        {
            let old = core::mem::replace(&mut self.active, new);
            // Ready was checked, and two sets cannot fill it.
            let _ = self.give_back.enqueue(old);
        }
        self.active
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::settings::Settings;

    fn set(rate_hz: f32) -> StepConfig {
        StepConfig::build(&Settings {
            rate_hz,
            ..Settings::default()
        })
        .unwrap()
    }

    #[test]
    fn a_set_is_in_force_from_the_next_sample_on() {
        let (mut active, mut spare) = (set(1.0), set(1.0));
        let mut queues = SwapQueues::new();
        let (mut background, mut interrupt) = queues.split(&mut active, &mut spare);
        assert_eq!(*interrupt.current(), set(1.0));
        for rate in 2..50 {
            let new = set(rate as f32);
            *background.spare().unwrap() = new.clone();
            background.send().unwrap();
            assert!(!background.taken());
            assert_eq!(background.spare().err(), Some(SwapBusy));
            assert_eq!(background.send(), Err(SwapBusy));
            assert_eq!(*interrupt.current(), new);
            assert!(background.taken());
            assert_eq!(*interrupt.current(), new);
        }
    }
}
