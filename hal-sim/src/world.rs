//! The courier, its motion controller and the board's parts, joined by one virtual clock.
//!
//! [`World`] stands for everything outside the processor. A simulated board takes the embedded-hal parts from it; an
//! emulated one has its mailboxes answered by the same parts.

use crate::courier::{Courier, Sample, Truth};
use crate::spec::CourierSpec;
use crate::waveform::NotMonotonic;
use crate::wire::clock::Clock;
use crate::wire::converter::{AnalogInputs, ConverterWire};
use crate::wire::motion::{ControllerConfig, CourierMotion, MotionWire};
use courier_sensor::device::Device;
use effects::motion::{Motion, Pose};
use std::cell::RefCell;
use std::rc::Rc;

/// One conversion as seen from outside.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Witness {
    /// Instant of the conversion, nanoseconds.
    pub time_ns: u64,
    /// Interferometer's reading.
    pub reference: Pose,
    /// Tooth counts that belong to the counts.
    pub teeth: [i32; 4],
}

/// A reference mark of the machine: the board's input is on while the courier's middle is within it. For an end stop it reaches beyond
/// what the courier can.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Mark {
    /// Ends along x, metres on the platen.
    pub x_m: [f64; 2],
    /// Ends along y, metres.
    pub y_m: [f64; 2],
}

/// Everything outside the processor. Clones are the same world.
#[derive(Clone)]
pub struct World {
    /// Number by which the board introduces itself.
    pub number: Device,
    /// Virtual time of every part.
    pub clock: Clock,
    /// The motion controller and its serial line.
    pub motion: MotionWire,
    /// The converter chips.
    pub converter: ConverterWire,
    plant: Rc<RefCell<Plant>>,
}

impl World {
    /// A courier at rest at `home` on its platen, everything switched on.
    ///
    /// # Errors
    /// [`NotMonotonic`] if a segment's error has no unique inverse.
    pub fn new(
        spec: CourierSpec,
        controller: ControllerConfig,
        home: Pose,
        seed: u64,
    ) -> Result<Self, NotMonotonic> {
        let (clock, number) = (Clock::new(), spec.number);
        // Two streams: the controller's draws must not depend on how many samples are taken.
        let motion = MotionWire::new(clock.clone(), controller, home, seed ^ 0x6d6f_7469_6f6e);
        let plant = Rc::new(RefCell::new(Plant {
            courier: Courier::new(spec, seed)?,
            motion: motion.motion(),
            mark: None,
            witnesses: None,
            taken: 0,
            first: 0,
            first_ns: 0,
            last_ns: 0,
        }));
        let converter = ConverterWire::new(clock.clone(), Inputs(plant.clone()));
        Ok(Self {
            number,
            clock,
            motion,
            converter,
            plant,
        })
    }

    /// From the next conversion on, the interferometer is read at each; what it saw before is dropped.
    pub fn watch(&self) {
        self.plant.borrow_mut().witnesses = Some(Vec::new());
    }

    /// Ends [`World::watch`]: the number of the first conversion watched, counted from 0, and what was seen from there on.
    pub fn unwatch(&self) -> (u64, Vec<Witness>) {
        let mut plant = self.plant.borrow_mut();
        let seen = plant.witnesses.take().unwrap_or_default();
        (plant.taken - seen.len() as u64, seen)
    }

    /// The board has been set up: its frame of sequence number 0 is the next conversion's.
    pub fn begin_sampling(&self) {
        let mut plant = self.plant.borrow_mut();
        plant.first = plant.taken;
    }

    /// Number of the conversion of sequence number 0, counted as in [`World::conversions`].
    #[must_use]
    pub fn first_conversion(&self) -> u64 {
        self.plant.borrow().first
    }

    /// Instants of the conversion of sequence number 0 and of the last conversion, nanoseconds. Numbers between follow from time: at an
    /// instant that a board missed there may have been a conversion or none.
    #[must_use]
    pub fn sampled_ns(&self) -> [u64; 2] {
        let plant = self.plant.borrow();
        [plant.first_ns, plant.last_ns]
    }

    /// Conversions so far.
    #[must_use]
    pub fn conversions(&self) -> u64 {
        self.plant.borrow().taken
    }

    /// Reaches the courier, e.g. to switch its beacon.
    pub fn with_courier<R>(&self, f: impl FnOnce(&mut Courier) -> R) -> R {
        f(&mut self.plant.borrow_mut().courier)
    }

    /// Puts a reference mark there, or takes it away.
    pub fn set_mark(&self, mark: Option<Mark>) {
        self.plant.borrow_mut().mark = mark;
    }

    /// Whether the board's input of the reference mark is on now.
    #[must_use]
    pub fn is_at_mark(&self) -> bool {
        let plant = self.plant.borrow();
        plant.mark.is_some_and(|mark| {
            let at = plant.motion.pose(self.clock.now_ns() as f64 * 1.0e-9);
            (mark.x_m[0]..=mark.x_m[1]).contains(&at.x_m)
                && (mark.y_m[0]..=mark.y_m[1]).contains(&at.y_m)
        })
    }

    /// What the machine logs beside the readings at a time that is not far back: name of the column and its value. None where the courier
    /// has no effect that follows such a quantity.
    #[must_use]
    pub fn logged(&self, time_ns: u64) -> Option<(&'static str, f64)> {
        let plant = self.plant.borrow();
        plant
            .courier
            .logged_at(&plant.motion, time_ns as f64 * 1.0e-9)
    }

    /// The truth at the last conversion: for tests.
    #[must_use]
    pub fn truth(&self) -> Truth {
        *self.plant.borrow().courier.truth()
    }
}

struct Plant {
    courier: Courier,
    motion: CourierMotion,
    mark: Option<Mark>,
    witnesses: Option<Vec<Witness>>,
    taken: u64,
    first: u64,
    first_ns: u64,
    last_ns: u64,
}

/// The courier's electrical side at the converters' inputs.
struct Inputs(Rc<RefCell<Plant>>);

impl AnalogInputs for Inputs {
    fn sample(&mut self, now_ns: u64) -> [[i16; 8]; 2] {
        let plant = &mut *self.0.borrow_mut();
        let sample = plant
            .courier
            .counts_at(&plant.motion, now_ns as f64 * 1.0e-9);
        if plant.taken == plant.first {
            plant.first_ns = now_ns;
        }
        plant.last_ns = now_ns;
        plant.taken += 1;
        if let Some(witnesses) = &mut plant.witnesses {
            witnesses.push(Witness {
                time_ns: now_ns,
                reference: plant.courier.reference(&plant.motion),
                teeth: plant.courier.teeth(),
            });
        }
        channels(&sample)
    }
}

/// Counts as the converters' pins are wired: chip 0 the four pairs, chip 1 the electrodes on its first four channels.
fn channels(sample: &Sample) -> [[i16; 8]; 2] {
    let mut chips = [[0; 8]; 2];
    for (place, counts) in chips[0].iter_mut().zip(sample.quadrature.iter().flatten()) {
        *place = *counts;
    }
    chips[1][..4].copy_from_slice(&sample.electrodes);
    chips
}
