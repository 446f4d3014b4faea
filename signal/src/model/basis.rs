//! Functions of the error model at one instant: harmonics by products of measured sines and cosines.
//!
//! The estimator's regressors. The interrupt has the same rotation to lateral phases; [`super::further`] is its evaluation of terms.

use super::terms::{MAX_LATERAL_ORDER, MAX_OWN_ORDER, MAX_THETA_POWER, Term, TermTable};
use crate::frame::{Coordinate, Frame, SEGMENTS};
use crate::geometry::Geometry;
use crate::lanes::Lanes;
use crate::math;

/// Sine and cosine of one angle.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Sine.
    pub sine: f32,
    /// Cosine.
    pub cosine: f32,
}

impl Unit {
    /// The angle zero.
    pub const ZERO: Self = Self {
        sine: 0.0,
        cosine: 1.0,
    };

    /// From an angle in turns, |turns| < 2^20.
    #[inline(always)]
    pub fn from_turns(turns: f32) -> Self {
        let (sine, cosine) = math::sincos_turns(turns);
        Self { sine, cosine }
    }

    /// Of two angles, in less time than one by one.
    #[inline(always)]
    pub(crate) fn two_from_turns(turns: [f32; 2]) -> [Self; 2] {
        math::sincos_turns_of_two(Lanes(turns)).map(|(sine, cosine)| Self { sine, cosine })
    }

    /// The same as a call: for work that is not done at every sample.
    #[inline(never)]
    fn called_from_turns(turns: f32) -> Self {
        Self::from_turns(turns)
    }

    /// Sum of the angles. 6 operations.
    #[inline(always)]
    pub fn plus(self, other: Self) -> Self {
        Self {
            sine: self.sine * other.cosine + self.cosine * other.sine,
            cosine: self.cosine * other.cosine - self.sine * other.sine,
        }
    }

    /// Difference of the angles. 6 operations.
    #[inline(always)]
    pub fn minus(self, other: Self) -> Self {
        Self {
            sine: self.sine * other.cosine - self.cosine * other.sine,
            cosine: self.cosine * other.cosine + self.sine * other.sine,
        }
    }

    /// Twice the angle. 5 operations.
    #[inline(always)]
    pub fn doubled(self) -> Self {
        let product = self.sine * self.cosine;
        Self {
            sine: product + product,
            cosine: self.cosine * self.cosine - self.sine * self.sine,
        }
    }
}

/// Lateral phases of all segments, equation (9); `shift_turns` is l_o theta / pitch.
///
/// The phase of p_y is that of the sum of unit vectors of segments 2 and 4, and alike for p_x: right while a pair's
/// phases are less than half a turn apart (|theta| < 3.0° with the paper's 9.7 mm).
#[inline(always)]
pub(crate) fn lateral_units(own: &[Unit; SEGMENTS], shift_turns: f32) -> [Unit; SEGMENTS] {
    let shift = Unit::from_turns(shift_turns);
    let sine = Lanes([own[0].sine + own[2].sine, own[1].sine + own[3].sine]);
    let cosine = Lanes([own[0].cosine + own[2].cosine, own[1].cosine + own[3].cosine]);
    let inverse = math::inverse_sqrt(sine * sine + cosine * cosine + 1.0e-12);
    let (sine, cosine) = (sine * inverse, cosine * inverse);
    let [x, y] = [0, 1].map(|k| Unit {
        sine: sine.0[k],
        cosine: cosine.0[k],
    });
    [y.minus(shift), x.plus(shift), y.plus(shift), x.minus(shift)]
}

/// Mean unmodified angle times span over pitch: half the sum of both pairs' differences, turns.
#[inline(always)]
pub(crate) fn mean_angle_turns(p: &[Coordinate; SEGMENTS]) -> f32 {
    0.5 * (p[0].minus_turns(p[2]) + p[1].minus_turns(p[3]))
}

/// What the functions depend on: one frame's, or the average of a pose's.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Observation {
    /// Unmodified outputs.
    pub unmodified: [Coordinate; SEGMENTS],
    /// Own speeds, m/s.
    pub speed_m_s: [f32; SEGMENTS],
    /// Directions of travel, -1 to 1.
    pub direction: [f32; SEGMENTS],
    /// Temperature minus the calibration's, kelvin.
    pub temperature_delta_k: f32,
}

impl From<&Frame> for Observation {
    fn from(frame: &Frame) -> Self {
        Self {
            unmodified: frame.segments.map(|s| s.unmodified),
            speed_m_s: per_segment(frame.speed_m_s),
            direction: per_segment(frame.direction),
            temperature_delta_k: frame.raw.temperature_delta_k,
        }
    }
}

/// A value of each axis as one of each segment.
fn per_segment([x, y]: [f32; 2]) -> [f32; SEGMENTS] {
    [x, y, x, y]
}

/// All phases and multipliers of one instant, ready to give any term of any segment.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Basis {
    pub(crate) own: [Unit; SEGMENTS],
    pub(crate) lateral: [Unit; SEGMENTS],
    pub(crate) theta_rad: f32,
    pub(crate) speed_m_s: [f32; SEGMENTS],
    pub(crate) direction: [f32; SEGMENTS],
    pub(crate) temperature_delta_k: f32,
}

impl Basis {
    /// From an observation; the phases go through [`math::sincos_turns`], everything after is the interrupt's own code.
    pub fn new(geometry: &Geometry, seen: &Observation) -> Self {
        let own = seen
            .unmodified
            .map(|p| Unit::called_from_turns(p.fraction_turns));
        let angle_turns = mean_angle_turns(&seen.unmodified);
        Self {
            own,
            lateral: lateral_units(&own, angle_turns * (geometry.lateral_m / geometry.span_m)),
            theta_rad: angle_turns * (geometry.pitch_m / geometry.span_m),
            speed_m_s: seen.speed_m_s,
            direction: seen.direction,
            temperature_delta_k: seen.temperature_delta_k,
        }
    }

    /// Mean unmodified angle, rad.
    pub fn theta_rad(&self) -> f32 {
        self.theta_rad
    }

    /// Everything of one segment, 0 to 3 (any other reads as 3), up to an own order and a lateral order.
    pub fn segment(&self, segment: usize, own_order: u8, lateral_order: u8) -> SegmentBasis {
        let i = segment.min(SEGMENTS - 1);
        SegmentBasis {
            own: multiples(self.own[i], own_order),
            lateral: multiples(self.lateral[i], lateral_order),
            theta_rad: self.theta_rad,
            multipliers: [
                1.0,
                self.speed_m_s[i],
                self.temperature_delta_k,
                self.direction[i],
            ],
        }
    }

    /// Fills `out` with one segment's columns in the order of [`TermTable::columns`] and returns how many there were
    /// room for. Constants are not among them: their column is 1.
    pub fn regressors(&self, table: &TermTable, segment: usize, out: &mut [f32]) -> usize {
        let basis = self.segment(segment, MAX_OWN_ORDER, MAX_LATERAL_ORDER);
        let mut slots = out.iter_mut();
        let mut count = 0;
        for term in table.iter() {
            let pair = basis.term(term);
            for value in pair.into_iter().skip(usize::from(!term.periodic())) {
                let Some(slot) = slots.next() else {
                    return count;
                };
                *slot = value;
                count += 1;
            }
        }
        count
    }
}

/// Harmonics and multipliers of one segment at one instant.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct SegmentBasis {
    own: [Unit; MAX_OWN_ORDER as usize + 1],
    lateral: [Unit; MAX_LATERAL_ORDER as usize + 1],
    theta_rad: f32,
    multipliers: [f32; 4],
}

impl SegmentBasis {
    /// `[sine, cosine]` function of one term, multiplier and power of theta included. Orders above those that the basis
    /// was made for read as zero. The sine of a term without phase is zero.
    #[inline]
    pub fn term(&self, term: &Term) -> [f32; 2] {
        let own = self.own[usize::from(term.own_order.min(MAX_OWN_ORDER))];
        let across =
            self.lateral[usize::from(term.lateral_order.unsigned_abs().min(MAX_LATERAL_ORDER))];
        let unit = if term.lateral_order < 0 {
            own.minus(across)
        } else {
            own.plus(across)
        };
        let factor = self.multipliers[term.multiplier as usize & 3];
        let factor = (0..term.theta_power.min(MAX_THETA_POWER))
            .fold(factor, |product, _| product * self.theta_rad);
        [factor * unit.sine, factor * unit.cosine]
    }
}

/// Multiples 0 to `order` of an angle; those above are zero.
fn multiples<const N: usize>(unit: Unit, order: u8) -> [Unit; N] {
    const NOTHING: Unit = Unit {
        sine: 0.0,
        cosine: 0.0,
    };
    let (mut table, mut multiple) = ([NOTHING; N], Unit::ZERO);
    for slot in table.iter_mut().take(usize::from(order) + 1) {
        *slot = multiple;
        multiple = multiple.plus(unit);
    }
    table
}
