//! Whole sets of coefficients from the background to the interrupt, between two samples.
//!
//! Two [`StepConfig`]s exist. The interrupt owns one (in force), the background the other (spare). The background
//! writes its spare and sends the reference down a queue of one place; the interrupt, before a sample, takes it and sends
//! its old one up. So each set has one owner at any time, none is ever half-written, nothing is copied in the interrupt,
//! and the interrupt's cost is a few loads and stores whether or not there is a new set.
//!
//! Of the tooth map there is one only: the background's while it is being filled, the interrupt's while it is applied, and
//! asked back by a flag.

use crate::queue;
use crate::step::StepConfig;
use crate::teeth::ToothMap;
use core::sync::atomic::{AtomicBool, Ordering::Relaxed};
use heapless::spsc::{Consumer, Producer, Queue};

/// The two queues. Lives as long as both ends: in a static on the target.
pub struct SwapQueues<'c> {
    down: Queue<&'c mut StepConfig, 2>,
    up: Queue<&'c mut StepConfig, 2>,
    map_down: Queue<&'c mut ToothMap, 2>,
    map_up: Queue<&'c mut ToothMap, 2>,
    map_recalled: AtomicBool,
}

impl<'c> SwapQueues<'c> {
    /// Empty queues.
    pub const fn new() -> Self {
        Self {
            down: Queue::new(),
            up: Queue::new(),
            map_down: Queue::new(),
            map_up: Queue::new(),
            map_recalled: AtomicBool::new(false),
        }
    }

    /// Gives `active` to the interrupt's end, `spare` and the map's memory to the background's.
    pub fn split<'q>(
        &'q mut self,
        active: &'c mut StepConfig,
        spare: &'c mut StepConfig,
        map: &'c mut ToothMap,
    ) -> (SwapSender<'q, 'c>, SwapReceiver<'q, 'c>) {
        let (send, receive) = self.down.split();
        let (give_back, reclaim) = self.up.split();
        let (send_map, receive_map) = self.map_down.split();
        let (give_back_map, reclaim_map) = self.map_up.split();
        let recalled: &AtomicBool = &self.map_recalled;
        (
            SwapSender {
                spare: Some(spare),
                send,
                reclaim,
                map: Some(map),
                send_map,
                reclaim_map,
                recalled,
            },
            SwapReceiver {
                active,
                receive,
                give_back,
                map: None,
                receive_map,
                give_back_map,
                recalled,
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
    map: Option<&'c mut ToothMap>,
    send_map: Producer<'q, &'c mut ToothMap>,
    reclaim_map: Consumer<'q, &'c mut ToothMap>,
    recalled: &'q AtomicBool,
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

    /// The map's memory, for filling; none while the interrupt has it.
    pub fn map_mut(&mut self) -> Option<&mut ToothMap> {
        self.take_map_back();
        self.map.as_deref_mut()
    }

    /// Has the map applied from the next sample on, as it is.
    ///
    /// # Errors
    /// [`SwapBusy`] if it is not here: recall it first.
    pub fn apply_map(&mut self) -> Result<(), SwapBusy> {
        self.take_map_back();
        let map = self.map.take().ok_or(SwapBusy)?;
        self.recalled.store(false, Relaxed);
        self.send_map.enqueue(map).map_err(|map| {
            self.map = Some(map);
            SwapBusy
        })
    }

    /// Has it applied no longer; it is here within a sample's time.
    pub fn recall_map(&mut self) {
        self.take_map_back();
        self.recalled.store(self.map.is_none(), Relaxed);
    }

    fn take_map_back(&mut self) {
        self.map = self.map.take().or_else(|| self.reclaim_map.dequeue());
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
    map: Option<&'c mut ToothMap>,
    receive_map: Consumer<'q, &'c mut ToothMap>,
    give_back_map: Producer<'q, &'c mut ToothMap>,
    recalled: &'q AtomicBool,
}

impl SwapReceiver<'_, '_> {
    /// The set for the next sample: call once before each [`crate::step::step`]. No copy, no wait.
    #[inline(always)]
    pub fn current(&mut self) -> &StepConfig {
        // First what is rarely true and costs least.
        if self.receive.ready()
            && queue::has_room(&self.give_back)
            && let Some(new) = queue::dequeue(&mut self.receive)
        {
            let old = core::mem::replace(&mut self.active, new);
            // Ready was checked, and two sets cannot fill it.
            let _ = queue::enqueue(&mut self.give_back, old);
        }
        self.active
    }

    /// The same, and the tooth map if one is in force.
    #[inline(always)]
    pub fn current_with_map(&mut self) -> (&StepConfig, Option<&ToothMap>) {
        if self.recalled.load(Relaxed)
            && let Some(map) = self.map.take()
        {
            // There is one map: its place is free.
            let _ = queue::enqueue(&mut self.give_back_map, map);
        }
        if self.receive_map.ready()
            && let Some(map) = queue::dequeue(&mut self.receive_map)
        {
            self.map = Some(map);
        }
        self.current();
        (self.active, self.map.as_deref())
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
        let (mut active, mut spare, mut map) = (set(1.0), set(1.0), ToothMap::new());
        let mut queues = SwapQueues::new();
        let (mut background, mut interrupt) = queues.split(&mut active, &mut spare, &mut map);
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

    #[test]
    fn the_map_has_one_owner_at_any_time() {
        let (mut active, mut spare, mut map) = (set(1.0), set(1.0), ToothMap::new());
        let mut queues = SwapQueues::new();
        let (mut background, mut interrupt) = queues.split(&mut active, &mut spare, &mut map);
        assert!(interrupt.current_with_map().1.is_none());
        for _ in 0..3 {
            assert!(background.map_mut().is_some());
            background.apply_map().unwrap();
            assert!(background.map_mut().is_none());
            assert!(interrupt.current_with_map().1.is_some());
            assert_eq!(background.apply_map(), Err(SwapBusy));
            background.recall_map();
            assert!(background.map_mut().is_none());
            assert!(interrupt.current_with_map().1.is_none());
        }
        // Recalled before the interrupt has seen it.
        background.apply_map().unwrap();
        background.recall_map();
        interrupt.current_with_map();
        assert!(interrupt.current_with_map().1.is_none());
        assert!(background.map_mut().is_some());
    }
}
