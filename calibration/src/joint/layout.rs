//! Order and groups of the joint calibration's unknowns.
//!
//! Gauge, by construction: of the four constants k_i,0 only two combinations are unknowns. The parity's,
//! `k_1 - k_2 - k_3 + k_4`, is determined by g_p. The angle's, `k_1 + k_2 - k_3 - k_4`, turns every pose by a constant angle;
//! equation (11) determines it, weakly, unless the diode's own angle in its mount is an unknown too: a common turn of
//! both and of the lever arm changes nothing, so the two are never free together. Each pair's mean constant moves the
//! beacon's place and nothing else: it is zero. The diode's centre moves the lever arm, its mean gain the height: neither is
//! an unknown.

use crate::frame::SEGMENTS;
use crate::model::{ErrorModel, MAX_LATERAL_ORDER, MAX_OWN_ORDER, Multiplier, Term};

/// Most terms of the error model that can be fitted together. A bound on the work: for a model with more there is no layout, and
/// the order is refused.
pub const MAX_FITTED: usize = 6;
/// Unknowns that are no coefficients of the error model.
const OTHERS: usize = 2 + MOUNTING + MISALIGNMENT + NONLINEARITY;
/// Height, lever arm (x, y), beacon's place (x, y). A definition: one, two and two.
pub(super) const MOUNTING: usize = 5;
/// Difference of the axes' gains, angle of the diode. A definition: one and one.
pub(super) const MISALIGNMENT: usize = 2;
/// Terms of second and third degree.
pub(super) const NONLINEARITY: usize = 2 * crate::diode::AXIS_TERMS;
/// Most unknowns.
pub const JOINT_UNKNOWNS: usize = SEGMENTS * 2 * MAX_FITTED + OTHERS;

/// Values of all unknowns of a [`Layout`].
pub type Values = [f32; JOINT_UNKNOWNS];

bitflags::bitflags! {
    /// Groups of unknowns that are free, or not, together.
    #[derive(Clone, Copy, Debug, Default, PartialEq, Eq, serde::Serialize, serde::Deserialize)]
    pub struct Groups: u8 {
        /// Coefficients of the own phase, equation (3).
        const OWN = 1;
        /// Coefficients of all other terms, equation (9).
        const LATERAL = 1 << 1;
        /// The parity's combination of the constants.
        const PARITY_OFFSET = 1 << 2;
        /// The angle's combination of the constants.
        const ANGLE_OFFSET = 1 << 3;
        /// Height, lever arm, beacon's place, equations (10) and (11).
        const MOUNTING = 1 << 4;
        /// Difference of the diode's gains, its angle in the mount.
        const MISALIGNMENT = 1 << 5;
        /// The diode's terms of second and third degree.
        const NONLINEARITY = 1 << 6;
        /// What g_p alone is fitted for.
        const PLATEN = Self::OWN.bits() | Self::PARITY_OFFSET.bits();
        /// The paper's 3.2.
        const PAPER = Self::PLATEN.bits() | Self::LATERAL.bits() | Self::ANGLE_OFFSET.bits() | Self::MOUNTING.bits();
        /// The coordination sensor's own errors.
        const SENSOR = Self::MISALIGNMENT.bits() | Self::NONLINEARITY.bits();
    }
}

/// One unknown, for people.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Unknown {
    /// Coefficient of a term of the error model; the part is 0 for the sine, 1 for the cosine.
    Coefficient {
        /// Segment, from 0.
        segment: usize,
        /// The term.
        term: Term,
        /// Sine or cosine.
        part: usize,
    },
    /// `k_1 - k_2 - k_3 + k_4`, metres.
    ParityOffset,
    /// `k_1 + k_2 - k_3 - k_4`, metres.
    AngleOffset,
    /// h, metres.
    Height,
    /// l_x or l_y, metres.
    Lever(usize),
    /// Beacon's place: the platen sensor's position under it at angle zero, metres.
    Place(usize),
    /// Half the difference of the axes' gains.
    GainDifference,
    /// Angle of the diode in its mount, radians.
    Turn,
    /// Coefficient of a term of the diode, axis and index into [`crate::diode::TERMS`].
    Nonlinearity(usize, usize),
}

impl core::fmt::Display for Unknown {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        let axis = |i: usize| if i == 0 { 'x' } else { 'y' };
        match *self {
            Self::Coefficient {
                segment,
                term,
                part,
            } => {
                let function = if part == 0 { "sin" } else { "cos" };
                write!(f, "segment {} {function}", segment + 1)?;
                match (term.own_order, term.lateral_order) {
                    (own, 0) => write!(f, " order {own}")?,
                    (0, lateral) => write!(f, " lateral order {lateral}")?,
                    (own, lateral) => write!(f, " order {own} lateral {lateral}")?,
                }
                if term.theta_power > 0 {
                    write!(f, " theta^{}", term.theta_power)
                } else {
                    Ok(())
                }
            }
            Self::ParityOffset => write!(f, "parity offset"),
            Self::AngleOffset => write!(f, "angle offset"),
            Self::Height => write!(f, "h"),
            Self::Lever(i) => write!(f, "l_{}", axis(i)),
            Self::Place(i) => write!(f, "beacon's place {}", axis(i)),
            Self::GainDifference => write!(f, "diode gain difference"),
            Self::Turn => write!(f, "diode angle"),
            Self::Nonlinearity(i, term) => {
                let (own, other) = crate::diode::TERMS[term];
                write!(f, "diode {} u^{own} v^{other}", axis(i))
            }
        }
    }
}

/// Which unknown is where, for the terms of one model. Only terms without a multiplier are fitted: the others need motion
/// or warmth that a standing courier does not have.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Layout {
    pub(super) terms: heapless::Vec<(u8, Term), MAX_FITTED>,
}

impl Layout {
    /// For a model; `None` if more than [`MAX_FITTED`] of its terms can be fitted, or none.
    #[must_use]
    pub fn new(model: &ErrorModel) -> Option<Self> {
        let mut terms = heapless::Vec::new();
        let fitted = |term: &Term| term.periodic() && term.multiplier == Multiplier::None;
        for (index, term) in model
            .terms
            .iter()
            .enumerate()
            .filter(|(_, term)| fitted(term))
        {
            terms.push((index as u8, *term)).ok()?;
        }
        (!terms.is_empty()).then_some(Self { terms })
    }

    /// Coefficients of one segment.
    pub(super) fn columns(&self) -> usize {
        2 * self.terms.len()
    }

    /// Number of unknowns, free or not.
    #[must_use]
    pub fn len(&self) -> usize {
        self.parity_offset() + OTHERS
    }

    /// Never.
    #[must_use]
    pub fn is_empty(&self) -> bool {
        false
    }

    pub(super) fn parity_offset(&self) -> usize {
        SEGMENTS * self.columns()
    }

    pub(super) fn angle_offset(&self) -> usize {
        self.parity_offset() + 1
    }

    pub(super) fn height(&self) -> usize {
        self.parity_offset() + 2
    }

    pub(super) fn lever(&self) -> usize {
        self.height() + 1
    }

    pub(super) fn place(&self) -> usize {
        self.height() + 3
    }

    pub(super) fn gain_difference(&self) -> usize {
        self.height() + MOUNTING
    }

    pub(super) fn turn(&self) -> usize {
        self.gain_difference() + 1
    }

    pub(super) fn nonlinearity(&self) -> usize {
        self.gain_difference() + MISALIGNMENT
    }

    /// What an index means.
    #[must_use]
    pub fn unknown(&self, index: usize) -> Unknown {
        let columns = self.columns();
        if index < self.parity_offset() {
            let column = index % columns;
            let term = self.terms.get(column / 2).map(|t| t.1).unwrap_or_default();
            return Unknown::Coefficient {
                segment: index / columns,
                term,
                part: column % 2,
            };
        }
        match index - self.parity_offset() {
            0 => Unknown::ParityOffset,
            1 => Unknown::AngleOffset,
            2 => Unknown::Height,
            i @ 3..=4 => Unknown::Lever(i - 3),
            i @ 5..=6 => Unknown::Place(i - 5),
            7 => Unknown::GainDifference,
            8 => Unknown::Turn,
            i => Unknown::Nonlinearity(
                (i - 9) / (NONLINEARITY / 2) % 2,
                (i - 9) % (NONLINEARITY / 2),
            ),
        }
    }

    /// Which group an index belongs to.
    #[must_use]
    pub fn group(&self, index: usize) -> Groups {
        match self.unknown(index) {
            Unknown::Coefficient { term, .. }
                if term.lateral_order == 0 && term.theta_power == 0 =>
            {
                Groups::OWN
            }
            Unknown::Coefficient { .. } => Groups::LATERAL,
            Unknown::ParityOffset => Groups::PARITY_OFFSET,
            Unknown::AngleOffset => Groups::ANGLE_OFFSET,
            Unknown::Height | Unknown::Lever(_) | Unknown::Place(_) => Groups::MOUNTING,
            Unknown::GainDifference | Unknown::Turn => Groups::MISALIGNMENT,
            Unknown::Nonlinearity(..) => Groups::NONLINEARITY,
        }
    }

    /// Indices of the unknowns of some groups, in order. The angle's offset is not free together with the diode's angle.
    pub fn free(&self, groups: Groups) -> heapless::Vec<u8, JOINT_UNKNOWNS> {
        let mut groups = groups;
        if groups.contains(Groups::MISALIGNMENT) {
            groups.remove(Groups::ANGLE_OFFSET);
        }
        (0..self.len())
            .filter(|&i| groups.contains(self.group(i)))
            .map(|i| i as u8)
            .collect()
    }

    /// Highest orders, for [`crate::model::Basis::segment`].
    pub(super) const ORDERS: (u8, u8) = (MAX_OWN_ORDER, MAX_LATERAL_ORDER);
}
