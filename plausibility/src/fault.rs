//! What can be wrong with wires, columns and stated values, and how readily it happens.

use crate::quadrature::Reading;

/// Axes of a pose by index.
pub(crate) const AXES: [&str; 3] = ["x", "y", "theta"];

/// One thing that is wrong. Segments and electrodes are indices from 0, axes 0 to 2 for x, y and theta.
#[derive(Clone, Debug, PartialEq)]
pub(crate) enum Fault {
    /// Two segments are exchanged.
    SegmentsExchanged(usize, usize),
    /// A segment counts backwards.
    SegmentReversed(usize),
    /// Both segments of an axis count backwards.
    PairReversed(usize),
    /// All segments count backwards.
    AllReversed,
    /// Segments 1 and 3 are those of y.
    AxesExchanged,
    /// Sine and cosine columns do not belong to the tooth counts.
    Quadrature(Reading),
    /// All lengths along the teeth are this many times the true ones.
    Pitch(f64),
    /// Logged positions are in this unit.
    Positions(Unit),
    /// The true span is this many times the stated one.
    Span(f64),
    /// The reference's x and y are exchanged.
    PoseAxesExchanged(Source),
    /// An axis of a pose column has the wrong sign.
    PoseReversed(Source, usize),
    /// All axes of a pose column have the wrong sign.
    PoseAllReversed(Source),
    /// A pose column holds this many times the true value; the axes that do.
    PoseScale(Source, Axes, f64),
    /// Two electrodes are exchanged.
    ElectrodesExchanged(usize, usize),
    /// The diode's axes are exchanged.
    DiodeAxesExchanged,
    /// The diode is mounted turned by so many degrees.
    DiodeTurned(u32),
    /// Height times full scale is this many times the stated one.
    Height(f64),
    /// A lever arm has the wrong sign.
    LeverReversed(usize),
    /// The two lever arms are exchanged.
    LeversExchanged,
    /// A lever arm is this long, m.
    Lever(usize, f64),
    /// The reference holds the readings of a segment.
    ReferenceIsReading(usize, usize),
}

/// Which pose columns.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Source {
    /// `ref_*`.
    Reference,
    /// `cmd_*`.
    Commanded,
}

/// Which axes of a pose a scale is of.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(crate) enum Axes {
    /// x and y, or the one of them that there is.
    Lengths,
    /// One of x and y alone.
    One(usize),
    /// The angle.
    Angle,
}

/// A unit that is taken for the one of the layout.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) struct Unit {
    /// Its name.
    pub name: &'static str,
    /// How many of it make a metre or a radian.
    pub factor: f64,
}

/// Units of length: the numbers are larger than metres by the factor. An inch is 25.4 mm.
pub(crate) const LENGTHS: [Unit; 4] = [
    unit("mm", 1.0e3),
    unit("µm", 1.0e6),
    unit("inches", 1.0 / 0.0254),
    unit("cm", 1.0e2),
];

/// Units of angle: the numbers are larger than radians by the factor.
pub(crate) const ANGLES: [Unit; 4] = [
    unit("degrees", 180.0 / std::f64::consts::PI),
    unit("mrad", 1.0e3),
    unit("minutes of arc", 10_800.0 / std::f64::consts::PI),
    unit("seconds of arc", 648_000.0 / std::f64::consts::PI),
];

const fn unit(name: &'static str, factor: f64) -> Unit {
    Unit { name, factor }
}

/// A factor within this share of a unit's is that unit's: a scale error of the reading comes beside it.
const UNIT_TOLERANCE: f64 = 0.02;

/// The unit whose factor this is.
pub(crate) fn unit_of(factor: f64, units: &[Unit], share: f64) -> Option<Unit> {
    let of = |unit: &&Unit| (factor / unit.factor - 1.0).abs() <= share;
    units.iter().find(of).copied()
}

impl Fault {
    /// How seldom it is, in units of one plain slip of the hand: what is wrong is what costs least. Priors, not data: a value that is off by
    /// the factor of a unit is a slip like an exchanged wire, any other value is somewhat rarer; commanded columns are wrong more easily than
    /// wires, since nothing depends on them.
    pub fn cost(&self) -> f64 {
        let scaled = |factor: f64, units: &[Unit]| {
            if unit_of(factor, units, UNIT_TOLERANCE).is_some() {
                1.0
            } else {
                1.4
            }
        };
        match self {
            Self::PoseAxesExchanged(Source::Commanded)
            | Self::PoseReversed(Source::Commanded, _)
            | Self::PoseAllReversed(Source::Commanded) => 0.9,
            Self::PoseScale(source, axes, factor) => {
                let units = if *axes == Axes::Angle {
                    &ANGLES
                } else {
                    &LENGTHS
                };
                let easier = if *source == Source::Commanded {
                    0.1
                } else {
                    0.0
                };
                scaled(*factor, units) - easier
            }
            Self::Pitch(_) | Self::Lever(..) => 1.2,
            Self::Span(_) => 1.15,
            Self::Height(factor) => {
                let full_scale = unit_of(1.0 / factor, &ANGLES[..1], FULL_SCALE_SHARE);
                let height = unit_of(1.0 / factor, &LENGTHS, UNIT_TOLERANCE);
                if full_scale.or(height).is_some() {
                    1.0
                } else {
                    1.1
                }
            }
            Self::Positions(unit) if unit.name != "mm" => 1.2,
            _ => 1.0,
        }
    }

    /// True of what is the commanded columns' alone: it is told and left aside elsewhere, and nothing is wrong with the readings.
    pub fn of_commands(&self) -> bool {
        matches!(
            self,
            Self::PoseAxesExchanged(Source::Commanded)
                | Self::PoseReversed(Source::Commanded, _)
                | Self::PoseAllReversed(Source::Commanded)
                | Self::PoseScale(Source::Commanded, ..)
        )
    }
}

/// A full scale in degrees is atan, not 57.3 times the tangent: at a tangent of 0.3 the two differ by 3 %. Derived from the arc's
/// series: x²/3, and as much again for the scale itself.
pub(crate) const FULL_SCALE_SHARE: f64 = 0.05;

/// Values within this share of one another are one value, as far as a sentence goes.
const VALUE_TOLERANCE: f64 = 0.05;

impl Fault {
    /// True of the same fault with about the same value.
    pub fn alike(&self, other: &Self) -> bool {
        let near = |a: f64, b: f64| (a - b).abs() <= VALUE_TOLERANCE * a.abs().max(b.abs());
        match (self, other) {
            (Self::Pitch(a), Self::Pitch(b))
            | (Self::Span(a), Self::Span(b))
            | (Self::Height(a), Self::Height(b)) => near(*a, *b),
            (Self::Lever(axis, a), Self::Lever(of, b)) => axis == of && near(*a, *b),
            (Self::PoseScale(s, x, a), Self::PoseScale(t, y, b)) => {
                s == t && x == y && near(*a, *b)
            }
            _ => self == other,
        }
    }
}
