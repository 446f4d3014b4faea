//! Columns of positions and of the reference in other units, of another sign, or of something else.

use super::findings::{exchanged, reversed};
use super::mistake::{Mistake, POSITIONS, REFERENCE, SINGLE, rows};
use super::rows::{output, scaled};
use plausibility::Kind;
use std::f64::consts::PI;

pub const KINDS: &[Mistake] = &[
    rows(
        "positions in mm",
        POSITIONS,
        |r, _| r.position_m.iter_mut().flatten().for_each(|p| *p *= 1.0e3),
        |f, _| f.kind == Kind::PositionUnit && f.sentence.contains("mm?"),
    ),
    rows(
        "positions in inches",
        POSITIONS,
        |r, _| r.position_m.iter_mut().flatten().for_each(|p| *p /= 0.0254),
        |f, _| f.kind == Kind::PositionUnit && f.sentence.contains("inches?"),
    ),
    rows(
        "reference in mm",
        REFERENCE,
        |r, _| scaled(r, [1.0e3, 1.0e3, 1.0]),
        |f, _| f.kind == Kind::ReferenceUnit && f.sentence.contains("mm?"),
    ),
    rows(
        "reference in inches",
        REFERENCE,
        |r, _| scaled(r, [1.0 / 0.0254, 1.0 / 0.0254, 1.0]),
        |f, _| f.kind == Kind::ReferenceUnit && f.sentence.contains("inches?"),
    ),
    rows(
        "one segment, reference in µm",
        SINGLE,
        |r, _| scaled(r, [1.0e6, 1.0e6, 1.0]),
        |f, _| f.kind == Kind::ReferenceUnit && f.sentence.contains("µm?"),
    ),
    rows(
        "reference's angle in degrees",
        REFERENCE,
        |r, _| scaled(r, [1.0, 1.0, 180.0 / PI]),
        |f, _| f.kind == Kind::ReferenceUnit && f.sentence.contains("degrees?"),
    ),
    rows(
        "reference's angle in mrad",
        REFERENCE,
        |r, _| scaled(r, [1.0, 1.0, 1.0e3]),
        |f, _| f.kind == Kind::ReferenceUnit && f.sentence.contains("mrad?"),
    ),
    rows(
        "reference's x of the wrong sign",
        REFERENCE,
        |r, _| scaled(r, [-1.0, 1.0, 1.0]),
        |f, _| f.kind == Kind::ReferenceSign && f.sentence.starts_with("x "),
    ),
    rows(
        "reference's angle of the wrong sign",
        REFERENCE,
        |r, _| scaled(r, [1.0, 1.0, -1.0]),
        |f, _| f.kind == Kind::ReferenceSign && f.sentence.starts_with("theta "),
    ),
    rows(
        "reference's x and y exchanged",
        REFERENCE,
        |r, _| r.reference.swap(0, 1),
        |f, _| f.kind == Kind::ReferenceAxes || exchanged(f, &[1, 2, 3, 4]),
    ),
    rows(
        "one segment, reference of the wrong sign",
        SINGLE,
        |r, _| scaled(r, [-1.0, 1.0, 1.0]),
        |f, _| f.kind == Kind::ReferenceSign || reversed(f, &[1]),
    ),
    rows(
        "the reference is the sensor",
        REFERENCE,
        |r, m| r.reference[0] = output(r, m, 0),
        |f, _| f.kind == Kind::ReferenceIsReading,
    ),
];
