//! Whether a map that came in force by the beacon fits the platen under it: its g_p against what the map's own fit left.
//!
//! Whole teeth tell nothing of a beacon that was moved by whole teeth, or of another platen under the same beacon. There the map adds
//! another platen's errors to the platen's own, and g_p shows it as soon as the courier moves: on the paper's platen 4 to 6 µm in place of 1 µm.
//! Each visit to a cell of one tooth by one tooth counts once, by the mean of its frames, since g_p in a cell's frames is
//! one value and noise.

use crate::frame::{Frame, Status};
use serde::{Deserialize, Serialize};

/// Visits to cells until the map is judged. A derivation: the mean square of 8 normal values is over 6.25 times its expectation once in
/// 20 million. Neighbours are not independent, but the means of cells also have less noise than what they are compared with.
pub const CELLS: u16 = 8;
/// g_p in rms may be so many times what the map's fit left. A prior: for drift; another platen's teeth are four to ten times as much.
pub const MOST_TIMES: f32 = 2.5;
/// What a map leaves is at least so much. Data: what a position is known to with a map (docs/accuracy.md).
pub const LEAST_PARITY_M: f32 = 0.3e-6;
/// Visits after which the map is watched no longer: what comes later is drift, and no other platen. A prior.
pub const MOST_CELLS: u16 = 64;
/// Faster than this g_p has errors of its own: channels that are 10 µs apart are 0.5 µm. A prior.
pub const FASTEST_M_S: f32 = 0.05;
/// Bits that are no faults and say nothing against g_p.
const STATES: Status = Status::BEACON_MISSING.union(Status::CALIBRATION_DRIFT);
/// Frames after which a mean forgets half of what it has, so that its sum stays small; a derivation: noise is averaged long before.
const LONGEST: u16 = 4096;

/// How a map's g_p compares with what its fit left.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ParityOfMap {
    /// Cells that were passed.
    pub cells: u16,
    /// g_p in them, metres rms.
    pub parity_m: f32,
    /// At most that is wanted, metres rms.
    pub wanted_m: f32,
}

impl ParityOfMap {
    /// Whether the map fits (true) or does not; none: too few cells to say so.
    pub fn fits(&self) -> Option<bool> {
        (self.cells >= CELLS).then_some(self.parity_m <= self.wanted_m)
    }
}

/// Sums over cells.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct FitOfMap {
    cell: Option<[i32; 2]>,
    sum_m: f32,
    frames: u16,
    square_m2: f32,
    cells: u16,
}

impl FitOfMap {
    /// Takes a frame. Outside the map's trusted cells, with a fault and in fast motion it counts for nothing.
    pub fn add(&mut self, frame: &Frame) {
        let is_well = (frame.status - STATES).is_empty();
        // Not a number fails as well.
        let is_slow = frame
            .speed_m_s
            .iter()
            .all(|speed| speed.abs() <= FASTEST_M_S);
        if !(is_well && is_slow) {
            return;
        }
        let cell = [frame.pose.x.teeth, frame.pose.y.teeth];
        if self.cell != Some(cell) {
            self.end_cell();
            self.cell = Some(cell);
        }
        self.sum_m += frame.parity_m;
        self.frames = self.frames.saturating_add(1);
        if self.frames == LONGEST {
            (self.sum_m, self.frames) = (0.5 * self.sum_m, LONGEST / 2);
        }
    }

    fn end_cell(&mut self) {
        if self.frames > 0 && self.cells < u16::MAX {
            let mean_m = self.sum_m / f32::from(self.frames);
            self.square_m2 += mean_m * mean_m;
            self.cells += 1;
        }
        (self.sum_m, self.frames) = (0.0, 0);
    }

    /// What the cells have shown, beside what the map's fit left, metres rms.
    pub fn parity(&self, left_m: f32) -> ParityOfMap {
        let mean_m2 = self.square_m2 / f32::from(self.cells.max(1));
        ParityOfMap {
            cells: self.cells,
            parity_m: crate::math::sqrt(mean_m2),
            wanted_m: MOST_TIMES * left_m.max(LEAST_PARITY_M),
        }
    }
}
