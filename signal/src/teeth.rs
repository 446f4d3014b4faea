//! The tooth map: how far the platen's teeth are displaced over a bounded patch, and each segment's lateral waves, also of mixed
//! order.
//!
//! Estimated on a host (`courier map`), loaded over the link, applied by the interrupt after the error model: the places are the
//! calibrated outputs, so that a map belongs to the calibration it was estimated with. One field a direction, shared by the two
//! segments that measure it, over the place along it and across: cubic B-spline, a node a pitch, coefficients in nanometres
//! (a segment averages over some teeth, so that nothing finer is left; de Boor 1978). Places count from the board's tooth count
//! zero, so that a map is placed anew after each start. Gauge: each field's mean is zero.

mod field;
mod waves;

pub use self::waves::Wave;

use self::waves::{SegmentWaves, WaveSum};
use crate::equations::LATERAL_SIGN;
use crate::frame::{Coordinate, Frame, SEGMENTS};
use crate::geometry::Geometry;
use crate::model::Unit;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Nodes of both fields together. A bound on the work: a map that needs more is refused where it is made, and a place of flash
/// has room for as many (`maps::store`).
pub const MAX_NODES: usize = 800;
/// Words of the cells' trust bits. Derived from 32 bits a word.
pub const TRUST_WORDS: usize = MAX_NODES.div_ceil(32);
/// Waves. By definition the waves that a tooth map has (`tooth-map/src/unknowns.rs`).
pub const MAX_WAVES: usize = 6;
/// Nodes along each direction that a place needs about it. By definition of a cubic spline.
const SUPPORT: u8 = 4;

/// The lattice of one direction's field.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq, Serialize, Deserialize)]
pub struct Grid {
    /// Tooth count of the first node, along the direction and across.
    pub first_teeth: [i32; 2],
    /// Nodes along and across, 4 or more.
    pub nodes: [u8; 2],
}

impl Grid {
    /// Nodes in all.
    #[must_use]
    pub fn count(&self) -> usize {
        usize::from(self.nodes[0]) * usize::from(self.nodes[1])
    }
}

/// What comes before a map's nodes.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct MapHeader {
    /// Field of x (segments 1 and 3) and of y.
    pub grids: [Grid; 2],
    /// Waves; equation (9)'s own term is one of them.
    pub waves: Vec<Wave, MAX_WAVES>,
    /// A bit for each cell, numbered as its first node: whether places in it are corrected.
    pub trusted: Vec<u32, TRUST_WORDS>,
}

/// Why a map cannot be used.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Serialize, Deserialize, thiserror::Error)]
#[non_exhaustive]
pub enum MapError {
    /// It does not fit the board.
    #[error("the map has {nodes} nodes, wanted at most {MAX_NODES}")]
    TooLarge {
        /// Nodes.
        nodes: u16,
    },
    /// A field is narrower than one place needs.
    #[error("a field of {along} by {across} nodes, wanted 4 or more either way")]
    TooNarrow {
        /// Nodes along.
        along: u8,
        /// Nodes across.
        across: u8,
    },
    /// A wave's order or size.
    #[error(
        "wave {index}: orders or coefficients out of range (orders 0,1; 0,2; 1,±1; 2,±1; coefficients to 0.1 mm)"
    )]
    Wave {
        /// From 0.
        index: u8,
    },
    /// Nodes are missing or too many came.
    #[error("{found} nodes came, wanted {wanted}")]
    Nodes {
        /// What came.
        found: u16,
        /// What the header says.
        wanted: u16,
    },
    /// Not every cell has its bit.
    #[error("{found} words of trust bits, wanted {wanted}")]
    Trust {
        /// What came.
        found: u8,
        /// What the nodes need.
        wanted: u8,
    },
}

impl MapHeader {
    /// Checks everything but the nodes.
    ///
    /// # Errors
    /// The first thing that is out of range.
    #[inline] // built with the image, for size
    pub fn validate(&self) -> Result<(), MapError> {
        let nodes = self.nodes();
        if nodes > MAX_NODES {
            return Err(MapError::TooLarge {
                nodes: nodes.min(usize::from(u16::MAX)) as u16,
            });
        }
        for grid in &self.grids {
            let [along, across] = grid.nodes;
            if along < SUPPORT || across < SUPPORT {
                return Err(MapError::TooNarrow { along, across });
            }
        }
        for (index, wave) in self.waves.iter().enumerate() {
            if !wave.has_its_place()
                || !wave
                    .coefficients_m
                    .iter()
                    .flatten()
                    .all(|c| c.abs() <= 1.0e-4)
            {
                return Err(MapError::Wave { index: index as u8 });
            }
        }
        let wanted = nodes.div_ceil(32) as u8;
        if self.trusted.len() != usize::from(wanted) {
            return Err(MapError::Trust {
                found: self.trusted.len() as u8,
                wanted,
            });
        }
        Ok(())
    }

    /// Moves the lattices by so many teeth along x and y.
    pub fn move_by(&mut self, teeth: [i32; 2]) {
        for (direction, grid) in self.grids.iter_mut().enumerate() {
            for (side, first) in grid.first_teeth.iter_mut().enumerate() {
                *first = first.wrapping_add(teeth[(direction + side) % 2]);
            }
        }
    }

    /// Nodes of both fields.
    #[must_use]
    pub fn nodes(&self) -> usize {
        self.grids.iter().map(Grid::count).sum()
    }
}

/// A map as the interrupt applies it; 1.9 KiB. Empty: nothing is corrected.
#[derive(Clone, Debug, Default)]
pub struct ToothMap {
    grids: [Grid; 2],
    trusted: Vec<u32, TRUST_WORDS>,
    nodes_nm: Vec<i16, MAX_NODES>,
    waves: [SegmentWaves; SEGMENTS],
    scales: Scales,
}

/// Lengths in pitches.
#[derive(Clone, Copy, Debug, Default)]
struct Scales {
    half_span: f32,
    lateral: f32,
    /// l_o over 2 l_s: what of the outputs' turn comes into a lateral argument.
    lateral_of_turn: f32,
    /// Of a field's sum.
    per_unit: f32,
}

impl Scales {
    const ZERO: Self = Self {
        half_span: 0.0,
        lateral: 0.0,
        lateral_of_turn: 0.0,
        per_unit: 0.0,
    };
}

impl ToothMap {
    /// Empty.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            grids: [Grid {
                first_teeth: [0; 2],
                nodes: [0; 2],
            }; 2],
            trusted: Vec::new(),
            nodes_nm: Vec::new(),
            waves: [SegmentWaves::NONE; SEGMENTS],
            scales: Scales::ZERO,
        }
    }

    /// Begins anew with a header.
    ///
    /// # Errors
    /// [`MapError`]; the map is then as before.
    #[inline] // built with the image, for size
    pub fn begin(&mut self, header: &MapHeader, geometry: &Geometry) -> Result<(), MapError> {
        header.validate()?;
        self.grids = header.grids;
        self.trusted.clone_from(&header.trusted);
        self.nodes_nm.clear();
        let per_metre = 1.0 / geometry.pitch_m;
        for (segment, waves) in self.waves.iter_mut().enumerate() {
            *waves = SegmentWaves::new(&header.waves, segment, per_metre);
        }
        self.scales = Scales {
            half_span: 0.5 * geometry.span_m * per_metre,
            lateral: geometry.lateral_m * per_metre,
            lateral_of_turn: 0.5 * geometry.lateral_m / geometry.span_m,
            per_unit: 1.0e-9 * per_metre / field::UNITS,
        };
        Ok(())
    }

    /// Adds nodes: x's field first, across running fastest.
    ///
    /// # Errors
    /// [`MapError::Nodes`] if there are more than the header says.
    #[inline] // built with the image, for size
    pub fn extend(&mut self, nodes_nm: &[i16]) -> Result<(), MapError> {
        let (found, wanted) = (self.nodes_nm.len() + nodes_nm.len(), self.wanted());
        if found > wanted || self.nodes_nm.extend_from_slice(nodes_nm).is_err() {
            return Err(self.count_error(found));
        }
        Ok(())
    }

    /// Whether all nodes came.
    ///
    /// # Errors
    /// [`MapError::Nodes`].
    #[inline] // built with the image, for size
    pub fn complete(&self) -> Result<(), MapError> {
        if self.nodes_nm.len() == self.wanted() && !self.nodes_nm.is_empty() {
            Ok(())
        } else {
            Err(self.count_error(self.nodes_nm.len()))
        }
    }

    /// Nodes of both fields, as the header said.
    fn wanted(&self) -> usize {
        self.grids.iter().map(Grid::count).sum()
    }

    #[inline] // built with the image, for size
    fn count_error(&self, found: usize) -> MapError {
        MapError::Nodes {
            found: found as u16,
            wanted: self.wanted() as u16,
        }
    }

    /// The lattices.
    #[must_use]
    pub fn grids(&self) -> &[Grid; 2] {
        &self.grids
    }

    /// What is to be added to each segment's calibrated output, pitches, and whether every place was in a trusted cell; the
    /// fields' part is zero where one is not. Waves have their phases where field and waves have moved the outputs, to first order:
    /// 5 um are 0.03 rad. In the interrupt; cost: `cargo xtask bench`.
    #[must_use]
    pub fn errors_turns(&self, frame: &Frame) -> ([f32; SEGMENTS], bool) {
        let mut moved = [0.0; SEGMENTS];
        let mut sums = [WaveSum::NONE; SEGMENTS];
        let mut inside = true;
        let lateral = self.scales.lateral * frame.pose.theta_rad;
        let across = lateral + self.scales.half_span;
        for (i, sum) in sums.iter_mut().enumerate() {
            let direction = i % 2;
            let own = frame.segments[i].calibrated;
            let other = if direction == 0 {
                frame.pose.y
            } else {
                frame.pose.x
            };
            let lateral_turns = other.fraction_turns + LATERAL_SIGN[i] * lateral;
            let aside = Coordinate {
                fraction_turns: other.fraction_turns + LATERAL_SIGN[i] * across,
                ..other
            };
            let phases = Unit::two_from_turns([own.fraction_turns, lateral_turns]);
            *sum = self.waves[i].sum(phases);
            let field = self.field_turns(direction, own, aside);
            inside &= field.is_some();
            moved[i] = sum.turns + field.unwrap_or(0.0);
        }
        (self.at_moved_phases(moved, &sums), inside)
    }

    /// Errors of fields and waves, the waves' phases moved by them.
    #[inline(always)]
    fn at_moved_phases(
        &self,
        moved: [f32; SEGMENTS],
        waves: &[WaveSum; SEGMENTS],
    ) -> [f32; SEGMENTS] {
        let [x, y] = [0.5 * (moved[0] + moved[2]), 0.5 * (moved[1] + moved[3])];
        let turned = (moved[0] - moved[2]) + (moved[1] - moved[3]);
        let turn = turned * self.scales.lateral_of_turn;
        core::array::from_fn(|i| {
            let across = if i % 2 == 0 { y } else { x } + LATERAL_SIGN[i] * turn;
            moved[i] + waves[i].along * moved[i] + waves[i].across * across
        })
    }

    /// One direction's field at a place, pitches; `None` outside the trusted cells.
    #[inline(never)]
    fn field_turns(&self, direction: usize, own: Coordinate, across: Coordinate) -> Option<f32> {
        let grid = &self.grids[direction % 2];
        let offset = if direction % 2 == 0 {
            0
        } else {
            self.grids[0].count()
        };
        let (i, along) = field::spline(own, grid.first_teeth[0], grid.nodes[0])?;
        let (j, aside) = field::spline(across, grid.first_teeth[1], grid.nodes[1])?;
        let row = usize::from(grid.nodes[1]);
        let first = offset + i * row + j;
        let word = self.trusted.get(first / 32)?;
        if word >> (first % 32) & 1 == 0 {
            return None;
        }
        let sum = field::sum(self.nodes_nm.get(first..)?, row, along, aside)?;
        Some(sum as f32 * self.scales.per_unit)
    }
}
