//! Follows the stored tooth maps: waits for a beacon or a mark, finds the whole teeth by it, and watches whether the map that came in force fits.
//! Pure: frames and what is stored in, one order out.

use crate::frame::{Coordinate, Frame};
use crate::geometry::Geometry;
use crate::link::message::{Refusal, StoredMap};
use crate::maps::fit::{FitOfMap, MOST_CELLS};
use crate::maps::homing::{Anchor, Mean, Unusable, check, moved, whole_teeth};
use crate::maps::mark;
use crate::maps::{MOST_PLACES, MapInfo, SLOTS};
use heapless::Vec;

/// A window's time, seconds: vibrations of 10 Hz and above average out. A prior.
const WINDOW_S: f32 = 0.25;
/// Frames in it at the least, of the thousands that there are: the background sees those that it has time for. A prior.
const LEAST_FRAMES: u16 = 50;

/// A map that may be put in force.
#[derive(Clone, Debug)]
struct Candidate {
    slot: u8,
    anchor: Anchor,
    parity_m: f32,
}

impl Candidate {
    fn ahead(&self, frame: &Frame, geometry: &Geometry) -> [Coordinate; 2] {
        self.anchor.ahead(geometry, &frame.pose, frame.tan_psi)
    }
}

/// Whole teeth that were found.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Placed {
    /// The map.
    pub slot: u8,
    ahead: [Coordinate; 2],
    parity_m: f32,
}

impl Placed {
    /// By a mark: what the board counts ahead of the map, a whole number of teeth, and g_p that the map left.
    pub fn by_mark(slot: u8, ahead: [Coordinate; 2], parity_m: f32) -> Self {
        Self {
            slot,
            ahead,
            parity_m,
        }
    }

    /// The larger part of a tooth that is left over, along x or y.
    fn left_turns(&self) -> f32 {
        let [x, y] = self.ahead.map(|ahead| ahead.fraction_turns.abs());
        x.max(y)
    }

    /// Teeth by which the board's count is ahead of the map's.
    pub fn ahead_teeth(&self) -> [i32; 2] {
        self.ahead.map(|ahead| ahead.teeth)
    }
}

/// Owned by the background.
#[derive(Clone, Debug, Default)]
pub struct Homing {
    candidates: Vec<Candidate, MOST_PLACES>,
    /// Whether the place of a reference mark is kept beside one of them.
    has_mark: bool,
    /// Of what the board counts ahead of the first candidate.
    mean: Mean,
    /// Number of the window's first frame.
    from: u32,
    state: StoredMap,
    /// To be put in force.
    found: Option<Placed>,
    /// Of the map in force.
    fit: FitOfMap,
    left_m: f32,
}

impl Homing {
    /// Begins anew with what is stored. `map`: what a slot's map is of, whether it belongs to the calibration in force, and whether the
    /// place of a reference mark is kept beside it; `none` leaves all maps alone.
    #[inline(never)]
    pub fn begin(&mut self, none: bool, mut map: impl FnMut(u8) -> Option<(MapInfo, bool, bool)>) {
        *self = Self::default();
        for slot in (0..SLOTS as u8).filter(|_| !none) {
            match map(slot) {
                Some((info, true, has_mark)) => {
                    self.has_mark |= has_mark;
                    let candidate = Candidate {
                        slot,
                        anchor: info.anchor,
                        parity_m: info.parity_m,
                    };
                    // There are no more places.
                    let _ = self.candidates.push(candidate);
                }
                Some((_, false, _)) => self.state = StoredMap::OtherCalibration { slot },
                None => {}
            }
        }
        if !self.candidates.is_empty() {
            self.state = StoredMap::Looking;
        }
    }

    /// Leaves it to a host.
    pub fn leave(&mut self) {
        *self = Self {
            state: StoredMap::Ordered,
            ..Self::default()
        };
    }

    /// State of the stored maps.
    pub fn state(&self) -> StoredMap {
        match self.state {
            StoredMap::InForce {
                slot,
                ahead,
                uptime_s,
                ..
            } => StoredMap::InForce {
                slot,
                ahead,
                uptime_s,
                parity: self.fit.parity(self.left_m),
            },
            other => other,
        }
    }

    /// The map whose teeth were found, until [`Homing::placed`] has been told that it is in force or cannot be.
    pub fn found(&self) -> Option<Placed> {
        self.found
    }

    /// Takes a frame while no map is in force, or the courier is outside the one that is. `geometry`: the one in force, `rate_hz`: of
    /// sampling.
    #[inline(never)]
    pub fn look(&mut self, frame: &Frame, geometry: &Geometry, rate_hz: f32) {
        if self.candidates.is_empty() {
            return;
        }
        if let Err(lacks) = check(frame, geometry) {
            // What a board counts ahead is the same at every place: frames before and after a motion go together, and those at the ends of
            // a vibration. After a doubtful count or another beacon they do not.
            if matches!(lacks, Unusable::NoBeacon | Unusable::Doubtful) {
                self.mean = Mean::default();
            }
            let lacks = match lacks {
                Unusable::NoBeacon if self.has_mark => Unusable::NoBeaconNorMark,
                other => other,
            };
            self.wait(StoredMap::Waits(lacks));
            return;
        }
        self.wait(StoredMap::Looking);
        if let Some(nearest) = self.window(frame, geometry, rate_hz) {
            self.decide(nearest);
        }
    }

    /// Adds a frame to the window; at its end the map that is nearest to whole teeth.
    fn window(&mut self, frame: &Frame, geometry: &Geometry, rate_hz: f32) -> Option<Placed> {
        if self.mean.frames() == 0 {
            self.from = frame.sequence;
        }
        let first = self.candidates.first()?;
        self.mean.add(&first.ahead(frame, geometry));
        let passed = frame.sequence.wrapping_sub(self.from) as f32;
        if passed < WINDOW_S * rate_hz || self.mean.frames() < LEAST_FRAMES {
            return None;
        }
        let nearest = self.nearest(frame, geometry);
        self.mean = Mean::default();
        nearest
    }

    /// The reference mark was crossed while no map is in force, at this place in the board's count. `mark`: its place in the count of a
    /// slot's map, if one is kept.
    #[inline(never)]
    pub fn crossed(
        &mut self,
        counted: &[Coordinate; 2],
        mut mark: impl FnMut(u8) -> Option<[Coordinate; 2]>,
    ) {
        let placed = self.candidates.iter().filter_map(|candidate| {
            let ahead = mark::ahead_at(counted, &mark(candidate.slot)?);
            Some(Placed::by_mark(candidate.slot, ahead, candidate.parity_m))
        });
        if let Some(nearest) = nearest_of(placed) {
            self.decide(nearest);
        }
    }

    fn decide(&mut self, nearest: Placed) {
        let Placed { slot, ahead, .. } = nearest;
        let in_force = self.in_force();
        if whole_teeth(&ahead).is_some() {
            self.found = Some(nearest).filter(|_| in_force != Some(slot));
        } else if in_force.is_none() {
            self.state = StoredMap::NotWhole { slot, ahead };
        }
    }

    /// Slot of the map in force.
    fn in_force(&self) -> Option<u8> {
        match self.state {
            StoredMap::InForce { slot, .. } => Some(slot),
            _ => None,
        }
    }

    /// What was found, as far as one could look, stays told until a map is in force.
    fn wait(&mut self, state: StoredMap) {
        if matches!(self.state, StoredMap::Waits(_) | StoredMap::Looking) {
            self.state = state;
        }
    }

    /// The map that is nearest to whole teeth; none if the frames disagree. Maps differ by what they differ at the window's last frame,
    /// whose noise they share.
    fn nearest(&self, last: &Frame, geometry: &Geometry) -> Option<Placed> {
        let mean = self.mean.mean()?;
        let first = self.candidates.first()?.ahead(last, geometry);
        nearest_of(self.candidates.iter().map(|candidate| {
            let here = candidate.ahead(last, geometry);
            Placed {
                slot: candidate.slot,
                ahead: [0, 1].map(|axis| moved(mean[axis], here[axis], first[axis])),
                parity_m: candidate.parity_m,
            }
        }))
    }

    /// Notes how putting the map in force went; `uptime_s` since the board's start.
    pub fn placed(&mut self, placed: &Placed, result: Result<(), Refusal>, uptime_s: f32) {
        match result {
            Ok(()) => {
                self.fit = FitOfMap::default();
                self.left_m = placed.parity_m;
                self.state = StoredMap::InForce {
                    slot: placed.slot,
                    ahead: placed.ahead,
                    uptime_s,
                    parity: self.fit.parity(self.left_m),
                };
            }
            // The interrupt has yet to give something back: again at the next turn.
            Err(Refusal::SwapBusy | Refusal::MapBusy) => return,
            Err(refusal) => self.give_up(
                placed.slot,
                StoredMap::Refused {
                    slot: placed.slot,
                    refusal,
                },
            ),
        }
        self.found = None;
    }

    /// Takes a frame while a stored map is in force; true once if the map does not fit the platen and is to go.
    pub fn watch(&mut self, frame: &Frame) -> bool {
        let Some(slot) = self.in_force() else {
            return false;
        };
        if self.fit.parity(self.left_m).cells >= MOST_CELLS {
            return false;
        }
        self.fit.add(frame);
        let parity = self.fit.parity(self.left_m);
        let is_wrong = parity.fits() == Some(false);
        if is_wrong {
            self.give_up(slot, StoredMap::OtherPlaten { slot, parity });
        }
        is_wrong
    }

    /// A map that is not tried again until the board restarts or something else is stored; others are.
    fn give_up(&mut self, slot: u8, state: StoredMap) {
        self.candidates.retain(|candidate| candidate.slot != slot);
        self.state = state;
    }
}

/// The one that is nearest to whole teeth.
fn nearest_of(placed: impl Iterator<Item = Placed>) -> Option<Placed> {
    placed.reduce(
        |nearest, other| match other.left_turns() < nearest.left_turns() {
            true => other,
            false => nearest,
        },
    )
}
