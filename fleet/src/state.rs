//! Where the problem is linearised: values of all unknowns, what is known of them before the data, and whole teeth between recordings.

use crate::form::Aperture;
use crate::key::{DIODE_SHEAR, Key, Name, Platen, RULINGS, SPAN, SPANS_APART};
use crate::member::Member;
use anyhow::{Result, ensure};
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;
use tooth_map::{Setup, Unknowns};

/// Prior deviation of what both spans are longer by, m: an assembly places each of four arms to a millimetre (`span_error`'s prior).
pub const SPAN_M: f64 = 1.0e-3;
/// Prior deviation of the difference of both, m: its 5 µm at the 15 mrad rms of a turn by ±1.5° (`span_error`'s prior).
const SPANS_APART_M: f64 = 5.0e-6 / 15.0e-3;
/// Prior deviation of a ruling's shape: 3 µm over ±5 mm (`axis_skew`'s prior).
const RULING: f64 = 3.0e-6 / 5.0e-3;
/// Prior deviation of the angle between a diode's axes, rad: the product of its misalignment's two prior deviations, a turn of 0.1 rad and 0.1 of the gains.
/// Axes that are turned first and differ in gain then are no more at right angles. A diode that leans by eight degrees about its diagonal has as much.
const DIODE_SHEAR_RAD: f64 = 0.1 * 0.1;
/// Prior deviation of a bow, 1/m: a field of teeth under an aperture, 3 µm, bends over the ±2.5 mm that a recording under a beacon crosses. Nodes that
/// are independent of each other bend by less.
const BOW_PER_M: f64 = 3.0e-6 / (2.5e-3 * 2.5e-3);

/// Version of a state's file. By definition of its layout.
pub const STATE_VERSION: u64 = 7;

/// What is known of an unknown before the data, in its own unit.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Prior {
    /// Mean.
    pub mean: f64,
    /// Standard deviation.
    pub deviation: f64,
}

/// A recording's place in the problem.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Placed {
    /// Its courier.
    pub courier: Name,
    /// Its platen.
    pub platen: Platen,
    /// Teeth along x and y by which the platen's count is ahead of the recording's.
    pub shift_teeth: [i32; 2],
}

/// The point of linearisation.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct State {
    /// Version of the file.
    pub courier_fleet_state: u64,
    /// Steps taken so far.
    pub steps: u32,
    /// Weight by which the next step is held back.
    pub damping: f64,
    /// What was left at the state before, and that state, to go back to where a step made it more.
    pub before: Option<(f64, Box<State>)>,
    /// Whether fields are of splines half a pitch apart, which tell the aperture.
    pub is_halved: bool,
    /// Apertures that these have told, of which the likeliest will be taken.
    pub candidates: Vec<Aperture>,
    /// Whether the aperture was looked for.
    pub is_aperture_told: bool,
    /// How the segments read teeth; without it, fields are cubic B-splines.
    pub aperture: Option<Aperture>,
    /// How often the noise was told.
    pub noise_told: u32,
    /// Noise of a segment and of a displacement that weighs each recording, m.
    pub noise_m: BTreeMap<Name, [f64; 2]>,
    /// Values of what belongs to couriers, as the first recording of each tells them alone. The slopes of their waves weigh the poses: they stay as
    /// they are, so that no step changes a weight.
    #[serde(with = "pairs")]
    pub weighing: BTreeMap<Key, f64>,
    /// Where the beacon over each platen is seen, x and y, m from the platen's count zero: the shapes of rulings are told from there.
    #[serde(with = "pairs")]
    pub beacons_m: BTreeMap<Platen, [f64; 2]>,
    /// Recordings by name.
    pub recordings: BTreeMap<Name, Placed>,
    /// Values of what belongs to couriers and recordings, with their priors.
    #[serde(with = "pairs")]
    pub sensors: BTreeMap<Key, (f64, Prior)>,
    /// Values of what belongs to platens; what is not there is zero.
    #[serde(with = "pairs")]
    pub platens: BTreeMap<(Platen, Key), f64>,
}

/// A table whose keys are no text, as a list of pairs.
mod pairs {
    use serde::de::{Deserialize, Deserializer};
    use serde::ser::{Serialize, Serializer};
    use std::collections::BTreeMap;

    pub fn serialize<K: Serialize, V: Serialize, S: Serializer>(
        table: &BTreeMap<K, V>,
        serializer: S,
    ) -> Result<S::Ok, S::Error> {
        serializer.collect_seq(table)
    }

    pub fn deserialize<'de, K, V, D>(deserializer: D) -> Result<BTreeMap<K, V>, D::Error>
    where
        K: Deserialize<'de> + Ord,
        V: Deserialize<'de>,
        D: Deserializer<'de>,
    {
        let list: Vec<(K, V)> = Deserialize::deserialize(deserializer)?;
        Ok(list.into_iter().collect())
    }
}

impl State {
    /// Checks a state that was read from a file.
    ///
    /// # Errors
    /// It is of another version.
    pub fn check(&self) -> Result<()> {
        let found = self.courier_fleet_state;
        ensure!(
            found == STATE_VERSION,
            "courier_fleet_state: found {found}, wanted {STATE_VERSION}: made by another version of this command"
        );
        Ok(())
    }

    /// Value of an unknown; zero of one that nothing has been said of.
    #[must_use]
    pub fn value(&self, platen: &Platen, key: &Key) -> f64 {
        match key {
            Key::Courier(..) | Key::Recording(..) => {
                self.sensors.get(key).map_or(0.0, |(value, _)| *value)
            }
            _ => {
                let value = self.platens.get(&(platen.clone(), key.clone()));
                value.copied().unwrap_or(0.0)
            }
        }
    }

    /// Adds to the value of an unknown.
    pub fn add(&mut self, platen: &Platen, key: &Key, step: f64) {
        match key {
            Key::Courier(..) | Key::Recording(..) => {
                if let Some((value, _)) = self.sensors.get_mut(key) {
                    *value += step;
                }
            }
            _ => {
                let key = (platen.clone(), key.clone());
                *self.platens.entry(key).or_default() += step;
            }
        }
    }

    /// Order and priors of a recording's unknowns.
    #[must_use]
    pub fn unknowns(&self, member: &Member) -> Unknowns {
        let halved = || Unknowns::of_half_splines(member.grids);
        match &self.aperture {
            None if self.is_halved => halved().unwrap_or_else(|| Unknowns::new(member.grids)),
            None => Unknowns::new(member.grids),
            Some(aperture) => {
                Unknowns::under_aperture(member.grids, aperture.kernel, aperture.deviations_m)
            }
        }
    }

    /// Teeth by which a platen's count is ahead of a recording's.
    #[must_use]
    pub fn shift_teeth(&self, recording: &str) -> [i32; 2] {
        let placed = self.recordings.get(recording);
        placed.map_or([0; 2], |placed| placed.shift_teeth)
    }

    /// The place from which shapes of a platen's rulings are told, m.
    #[must_use]
    pub fn beacon_m(&self, platen: &Platen) -> [f64; 2] {
        self.beacons_m.get(platen).copied().unwrap_or_default()
    }

    /// Recordings of a recording's courier, and over its platen.
    #[must_use]
    pub fn counts(&self, of: &Placed) -> [f64; 2] {
        let all = self.recordings.values();
        let courier = all.clone().filter(|other| other.courier == of.courier);
        let platen = all.filter(|other| other.platen == of.platen);
        [courier.count(), platen.count()].map(|count| count.max(1) as f64)
    }
}

/// The key of each of the tooth map's unknowns in a recording's problem.
#[must_use]
pub fn keys_of(member: &Member, unknowns: &Unknowns, shift_teeth: [i32; 2]) -> Vec<Key> {
    let of_courier = |i: usize| Key::Courier(member.courier.clone(), i as u16);
    let mut keys: Vec<Key> = (0..unknowns.field(0)).map(of_courier).collect();
    let mounting = unknowns.mounting();
    let of_recording = [
        unknowns.parity(),
        unknowns.angle(),
        mounting,
        mounting + 3,
        mounting + 4,
    ];
    for (number, at) in of_recording.into_iter().enumerate() {
        keys[at] = Key::Recording(member.recording.clone(), number as u16);
    }
    let per_tooth = 1.0 / unknowns.lattice().step_pitches[0];
    let shift_teeth = shift_teeth.map(|teeth| teeth * per_tooth as i32);
    for direction in 0..2 {
        let grid = &unknowns.grids[direction];
        let shift = [shift_teeth[direction], shift_teeth[1 - direction]];
        let [along, across] = grid.nodes.map(i32::from);
        for i in 0..along {
            for j in 0..across {
                let node = [
                    grid.first_teeth[0] + i + shift[0],
                    grid.first_teeth[1] + j + shift[1],
                ];
                keys.push(Key::Node(direction as u8, node));
            }
        }
    }
    for direction in 0..2 {
        let grid = &unknowns.grids[direction];
        let first = grid.first_teeth[0] + shift_teeth[direction];
        let lines = i32::from(grid.nodes[0]);
        keys.extend((0..lines).map(|i| Key::Line(direction as u8, first + i)));
    }
    keys
}

/// How many unknowns the tooth map has not. By definition of [`further`].
pub const FURTHER: usize = 7;

/// Unknowns that the tooth map has not: their keys and deviations.
#[must_use]
pub fn further(member: &Member) -> [(Key, f64); FURTHER] {
    let of_courier = |which| Key::Courier(member.courier.clone(), which);
    let [pitch, square, bow_of_x, bow_of_y] = RULINGS;
    [
        (pitch, RULING),
        (square, RULING),
        (bow_of_x, BOW_PER_M),
        (bow_of_y, BOW_PER_M),
        (of_courier(SPAN), SPAN_M),
        (of_courier(SPANS_APART), SPANS_APART_M),
        (of_courier(DIODE_SHEAR), DIODE_SHEAR_RAD),
    ]
}

/// Values and priors of a recording's own and its courier's unknowns, by the values of a fit of this recording alone.
#[must_use]
pub fn sensors_of(
    member: &Member,
    unknowns: &Unknowns,
    values: &[f64],
) -> BTreeMap<Key, (f64, Prior)> {
    let setup: &Setup = &member.setup;
    let (start, mut deviations) = (unknowns.start(setup), unknowns.deviations(setup));
    // An offset of the angle is one with a diode that is mounted turned and lever arms that are turned with it: gauge, but for the angle by
    // which a platen's rulings, out of square, turn all that is over them.
    deviations[unknowns.angle()] = 2.0 * setup.span_m * RULING;
    let keys = keys_of(member, unknowns, [0; 2]);
    let of_map = keys.into_iter().enumerate().take(unknowns.field(0));
    let mut sensors: BTreeMap<Key, (f64, Prior)> = of_map
        .map(|(i, key)| {
            let prior = Prior {
                mean: start[i],
                deviation: deviations[i],
            };
            (key, (values[i], prior))
        })
        .collect();
    for (key, deviation) in further(member) {
        if key.courier().is_some() {
            let prior = Prior {
                mean: 0.0,
                deviation,
            };
            sensors.insert(key, (0.0, prior));
        }
    }
    sensors
}
