//! The tooth map: how far the platen's teeth are displaced over a bounded patch, and each segment's lateral waves, also of mixed
//! order.
//!
//! Estimated on a host (`courier map`), loaded over the link, applied by the interrupt after the error model: the places are the
//! calibrated outputs, so that a map belongs to the calibration it was estimated with. One field a direction, shared by the two
//! segments that measure it, over the place along it and across: cubic B-spline, a node a pitch, coefficients in nanometres
//! (a segment averages over some teeth, so that nothing finer is left; de Boor 1978). Places count from the board's tooth count
//! zero: a map does not outlive a restart. Gauge: each field's mean is zero.

use crate::frame::{Coordinate, Frame, SEGMENTS};
use crate::geometry::Geometry;
use crate::model::Unit;
use core::f32::consts::TAU;
use heapless::Vec;
use serde::{Deserialize, Serialize};

/// Nodes of both fields together.
pub const MAX_NODES: usize = 800;
/// Words of the cells' trust bits.
pub const TRUST_WORDS: usize = MAX_NODES.div_ceil(32);
/// Waves.
pub const MAX_WAVES: usize = 6;
/// Largest own and lateral order of a wave.
pub const MAX_WAVE_ORDER: u8 = 2;
/// Nodes along each direction that a place needs about it.
const SUPPORT: u8 = 4;
/// Sign of l_o theta in each segment's lateral argument, equation (9).
const LATERAL_SIGN: [f32; SEGMENTS] = [-1.0, 1.0, 1.0, -1.0];
/// Which side of the courier's middle each segment is on, across its own direction, in half spans: what makes a pair's
/// difference an angle, equation (4).
const SIDE: [f32; SEGMENTS] = [-1.0, 1.0, 1.0, -1.0];

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

/// A wave over own and lateral phase of every segment.
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Wave {
    /// Order of the own phase, 0 to [`MAX_WAVE_ORDER`].
    pub own_order: u8,
    /// Order of the lateral phase, to ±[`MAX_WAVE_ORDER`].
    pub lateral_order: i8,
    /// `[segment][sine, cosine]`, metres.
    pub coefficients_m: [[f32; 2]; SEGMENTS],
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
        "wave {index}: orders or coefficients out of range (orders to 2, coefficients to 0.1 mm)"
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
            let orders = wave.own_order <= MAX_WAVE_ORDER
                && wave.lateral_order.unsigned_abs() <= MAX_WAVE_ORDER;
            if !orders
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

    /// Nodes of both fields.
    #[must_use]
    pub fn nodes(&self) -> usize {
        self.grids.iter().map(Grid::count).sum()
    }
}

/// A map as the interrupt applies it; 1.9 KiB. Empty: nothing is corrected.
#[derive(Clone, Debug, Default)]
pub struct ToothMap {
    header: MapHeader,
    nodes_nm: Vec<i16, MAX_NODES>,
    scales: Scales,
}

/// Lengths in pitches.
#[derive(Clone, Copy, Debug, Default)]
struct Scales {
    half_span: f32,
    lateral: f32,
    /// l_o over 2 l_s: what of the outputs' turn comes into a lateral argument.
    lateral_of_turn: f32,
    per_metre: f32,
}

/// A segment's waves, pitches, and their derivatives by its own and its lateral place.
#[derive(Clone, Copy, Debug, Default)]
struct WaveSum {
    turns: f32,
    along: f32,
    across: f32,
}

impl ToothMap {
    /// Empty.
    #[must_use]
    pub const fn new() -> Self {
        Self {
            header: MapHeader {
                grids: [Grid {
                    first_teeth: [0; 2],
                    nodes: [0; 2],
                }; 2],
                waves: Vec::new(),
                trusted: Vec::new(),
            },
            nodes_nm: Vec::new(),
            scales: Scales {
                half_span: 0.0,
                lateral: 0.0,
                lateral_of_turn: 0.0,
                per_metre: 0.0,
            },
        }
    }

    /// Begins anew with a header.
    ///
    /// # Errors
    /// [`MapError`]; the map is then as before.
    pub fn begin(&mut self, header: &MapHeader, geometry: &Geometry) -> Result<(), MapError> {
        header.validate()?;
        self.header.clone_from(header);
        self.nodes_nm.clear();
        let per_metre = 1.0 / geometry.pitch_m;
        self.scales = Scales {
            half_span: 0.5 * geometry.span_m * per_metre,
            lateral: geometry.lateral_m * per_metre,
            lateral_of_turn: 0.5 * geometry.lateral_m / geometry.span_m,
            per_metre,
        };
        Ok(())
    }

    /// Adds nodes: x's field first, across running fastest.
    ///
    /// # Errors
    /// [`MapError::Nodes`] if there are more than the header says.
    pub fn extend(&mut self, nodes_nm: &[i16]) -> Result<(), MapError> {
        let (found, wanted) = (self.nodes_nm.len() + nodes_nm.len(), self.header.nodes());
        if found > wanted || self.nodes_nm.extend_from_slice(nodes_nm).is_err() {
            return Err(self.count_error(found));
        }
        Ok(())
    }

    /// Whether all nodes came.
    ///
    /// # Errors
    /// [`MapError::Nodes`].
    pub fn complete(&self) -> Result<(), MapError> {
        if self.nodes_nm.len() == self.header.nodes() && !self.nodes_nm.is_empty() {
            Ok(())
        } else {
            Err(self.count_error(self.nodes_nm.len()))
        }
    }

    fn count_error(&self, found: usize) -> MapError {
        MapError::Nodes {
            found: found as u16,
            wanted: self.header.nodes() as u16,
        }
    }

    /// What is known of it beside its nodes.
    #[must_use]
    pub fn header(&self) -> &MapHeader {
        &self.header
    }

    /// What is to be added to each segment's calibrated output, pitches, and whether every place was in a trusted cell; the
    /// fields' part is zero where one is not. Waves have their phases where field and waves have moved the outputs, to first order:
    /// 5 um are 0.03 rad. In the interrupt; cost: `cargo xtask bench`.
    #[must_use]
    pub fn errors_turns(&self, frame: &Frame) -> ([f32; SEGMENTS], bool) {
        let mut moved = [0.0; SEGMENTS];
        let mut waves = [WaveSum::default(); SEGMENTS];
        let mut inside = true;
        let pose = &frame.pose;
        for i in 0..SEGMENTS {
            let own = frame.segments[i].calibrated;
            let other = if i % 2 == 0 { pose.y } else { pose.x };
            let lateral = Coordinate {
                fraction_turns: other.fraction_turns
                    + LATERAL_SIGN[i] * self.scales.lateral * pose.theta_rad,
                ..other
            };
            let across = Coordinate {
                fraction_turns: lateral.fraction_turns + SIDE[i] * self.scales.half_span,
                ..lateral
            };
            waves[i] = self.waves(i, own, lateral);
            moved[i] = waves[i].turns;
            match self.field_turns(i % 2, own, across) {
                Some(field) => moved[i] += field,
                None => inside = false,
            }
        }
        (self.at_moved_phases(moved, &waves), inside)
    }

    /// Errors of fields and waves, the waves' phases moved by them.
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

    fn waves(&self, segment: usize, own: Coordinate, lateral: Coordinate) -> WaveSum {
        let multiples = |unit: Unit| [Unit::ZERO, unit, unit.doubled()];
        let own = multiples(Unit::from_turns(own.fraction_turns));
        let lateral = multiples(Unit::from_turns(lateral.fraction_turns));
        let mut sum = WaveSum::default();
        for wave in &self.header.waves {
            // Orders were checked; the remainder is for the compiler.
            let along = own[usize::from(wave.own_order) % 3];
            let across = lateral[usize::from(wave.lateral_order.unsigned_abs()) % 3];
            let unit = if wave.lateral_order < 0 {
                along.minus(across)
            } else {
                along.plus(across)
            };
            let [a, b] = wave.coefficients_m[segment % SEGMENTS];
            let slope = a * unit.cosine - b * unit.sine;
            sum.turns += a * unit.sine + b * unit.cosine;
            sum.along += slope * f32::from(wave.own_order);
            sum.across += slope * f32::from(wave.lateral_order);
        }
        let per_turn = TAU * self.scales.per_metre;
        WaveSum {
            turns: sum.turns * self.scales.per_metre,
            along: sum.along * per_turn,
            across: sum.across * per_turn,
        }
    }

    /// One direction's field at a place; `None` outside the trusted cells.
    fn field_turns(&self, direction: usize, own: Coordinate, across: Coordinate) -> Option<f32> {
        let grid = &self.header.grids[direction % 2];
        let offset = if direction % 2 == 0 {
            0
        } else {
            self.header.grids[0].count()
        };
        let (i, along) = spline(own, grid.first_teeth[0], grid.nodes[0])?;
        let (j, aside) = spline(across, grid.first_teeth[1], grid.nodes[1])?;
        let row = usize::from(grid.nodes[1]);
        let first = offset + i * row + j;
        let word = self.header.trusted.get(first / 32)?;
        if word >> (first % 32) & 1 == 0 {
            return None;
        }
        let mut sum = 0.0;
        for (k, along) in along.into_iter().enumerate() {
            let nodes = self.nodes_nm.get(first + k * row..)?.first_chunk::<4>()?;
            let line: f32 = nodes
                .iter()
                .zip(aside)
                .map(|(&node, w)| f32::from(node) * w)
                .sum();
            sum += along * line;
        }
        Some(sum * (1.0e-9 * self.scales.per_metre))
    }
}

/// First of the four nodes about a place, and their weights; `None` outside.
fn spline(place: Coordinate, first_teeth: i32, nodes: u8) -> Option<(usize, [f32; 4])> {
    let position = place.teeth.wrapping_sub(first_teeth) as f32 + place.fraction_turns;
    // The first node's cell begins at the second node. NaN is outside.
    if !(position >= 1.0 && position < f32::from(nodes) - 2.0) {
        return None;
    }
    let cell = position as usize;
    let t = position - cell as f32;
    let (s, t2) = (1.0 - t, t * t);
    let t3 = t2 * t;
    const SIXTH: f32 = 1.0 / 6.0;
    let weights = [
        s * s * s * SIXTH,
        (3.0 * t3 - 6.0 * t2 + 4.0) * SIXTH,
        (3.0 * (t + t2 - t3) + 1.0) * SIXTH,
        t3 * SIXTH,
    ];
    Some((cell - 1, weights))
}
