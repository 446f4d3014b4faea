//! What is told: a kind, the segments, the value that would be right, and a sentence.

use crate::fault::{ANGLES, AXES, Axes, FULL_SCALE_SHARE, Fault, LENGTHS, Source, unit_of};
use crate::quadrature::Reading;
use recording::Meta;
use serde::{Deserialize, Serialize};

/// Kinds of findings.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash, Serialize, Deserialize)]
#[serde(rename_all = "snake_case")]
#[non_exhaustive]
pub enum Kind {
    /// Two segments are exchanged, or those of x and y.
    SegmentsExchanged,
    /// Segments count backwards.
    SegmentReversed,
    /// Sine and cosine columns do not belong to the tooth counts.
    Quadrature,
    /// The stated pitch does not fit.
    Pitch,
    /// Logged positions are in another unit.
    PositionUnit,
    /// The stated span does not fit.
    Span,
    /// The reference's axes are exchanged.
    ReferenceAxes,
    /// The reference has the wrong sign.
    ReferenceSign,
    /// The reference is in another unit.
    ReferenceUnit,
    /// The reference holds readings of the sensor.
    ReferenceIsReading,
    /// Commanded poses disagree in axes, sign or unit.
    Commanded,
    /// Electrodes of the diode are exchanged.
    Electrodes,
    /// The diode is turned by quarter turns, or its axes are exchanged.
    DiodeAxes,
    /// Height times full scale does not fit.
    HeightOrFullScale,
    /// A lever arm does not fit.
    Lever,
}

/// One thing that cannot be as it is stated.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Finding {
    /// What kind.
    pub kind: Kind,
    /// The segments that it is about, 1 to 4; none where it is about something else.
    pub segments: Vec<usize>,
    /// The stated value, if there is one.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub stated: Option<f64>,
    /// The value by the data.
    #[serde(skip_serializing_if = "Option::is_none", default)]
    pub found: Option<f64>,
    /// Unit of both.
    #[serde(skip_serializing_if = "String::is_empty", default)]
    pub unit: String,
    /// What is wrong and what would be right, in a sentence.
    pub sentence: String,
    /// What explains the readings as well: each one instead of all findings.
    #[serde(skip_serializing_if = "Vec::is_empty", default)]
    pub or: Vec<Vec<Finding>>,
}

impl std::fmt::Display for Finding {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        f.write_str(&self.sentence)?;
        for other in &self.or {
            f.write_str("; or ")?;
            for (k, finding) in other.iter().enumerate() {
                f.write_str(if k > 0 { " and " } else { "" })?;
                f.write_str(&finding.sentence)?;
            }
        }
        Ok(())
    }
}

impl Finding {
    fn plain(kind: Kind, segments: &[usize], sentence: String) -> Self {
        Self {
            kind,
            segments: segments.iter().map(|s| s + 1).collect(),
            stated: None,
            found: None,
            unit: String::new(),
            sentence,
            or: Vec::new(),
        }
    }

    fn valued(kind: Kind, [stated, found]: [f64; 2], unit: &str, sentence: String) -> Self {
        Self {
            stated: Some(stated),
            found: Some(found),
            unit: unit.into(),
            ..Self::plain(kind, &[], sentence)
        }
    }

    /// From a fault of a recording with these stated values.
    pub(crate) fn new(fault: &Fault, meta: &Meta) -> Self {
        match fault {
            Fault::Pitch(_) | Fault::Positions(_) | Fault::Span(_) => lengths(fault, meta),
            Fault::Height(_)
            | Fault::LeverReversed(_)
            | Fault::LeversExchanged
            | Fault::Lever(..) => mounting(fault, meta),
            Fault::ElectrodesExchanged(..) | Fault::DiodeAxesExchanged | Fault::DiodeTurned(_) => {
                diode(fault)
            }
            Fault::PoseAxesExchanged(_)
            | Fault::PoseReversed(..)
            | Fault::PoseAllReversed(_)
            | Fault::PoseScale(..)
            | Fault::ReferenceIsReading(..) => pose(fault),
            _ => wires(fault),
        }
    }
}

/// Electrodes by index.
const ELECTRODES: [&str; 4] = ["psd_xp", "psd_xn", "psd_yp", "psd_yn"];

fn wires(fault: &Fault) -> Finding {
    let exchanged =
        |segments: &[usize], text: String| Finding::plain(Kind::SegmentsExchanged, segments, text);
    let reversed =
        |segments: &[usize], text: String| Finding::plain(Kind::SegmentReversed, segments, text);
    match *fault {
        Fault::SegmentsExchanged(a, b) if a % 2 == b % 2 => exchanged(
            &[a, b],
            format!(
                "segments {} and {} are exchanged: they turn against the other pair",
                a + 1,
                b + 1
            ),
        ),
        Fault::SegmentsExchanged(a, b) => {
            let along = |segment: usize| AXES[1 - segment % 2];
            exchanged(
                &[a, b],
                format!(
                    "segments {} and {} are exchanged: segment {} follows {}, segment {} follows {}",
                    a + 1,
                    b + 1,
                    a + 1,
                    along(a),
                    b + 1,
                    along(b)
                ),
            )
        }
        Fault::AxesExchanged => exchanged(
            &[0, 1, 2, 3],
            "segments 1 and 3 follow y, segments 2 and 4 follow x".into(),
        ),
        Fault::SegmentReversed(segment) => reversed(
            &[segment],
            format!(
                "segment {} counts backwards: its sine and cosine are exchanged, or one of them has the wrong sign",
                segment + 1
            ),
        ),
        Fault::PairReversed(axis) => reversed(
            &[axis, axis + 2],
            format!(
                "segments {} and {} count backwards: {} has the wrong sign",
                axis + 1,
                axis + 3,
                AXES[axis]
            ),
        ),
        Fault::AllReversed => reversed(&[0, 1, 2, 3], "all four segments count backwards".into()),
        Fault::Quadrature(Reading::Exchanged(a, b)) => Finding::plain(
            Kind::Quadrature,
            &[a, b],
            format!(
                "sine and cosine of segments {} and {} are exchanged, their tooth counts are not",
                a + 1,
                b + 1
            ),
        ),
        Fault::Quadrature(Reading::Turned { segment, mix }) => {
            let s = segment + 1;
            let mut text = Vec::new();
            if mix.exchanged {
                text.push(format!("q{s}s and q{s}c are exchanged"));
            }
            if mix.sine {
                text.push(format!("q{s}s has the wrong sign"));
            }
            if mix.cosine {
                text.push(format!("q{s}c has the wrong sign"));
            }
            Finding::plain(
                Kind::Quadrature,
                &[segment],
                format!("{} against the tooth counts n{s}", text.join(", ")),
            )
        }
        _ => Finding::plain(Kind::Quadrature, &[], "a wire is wrong".into()),
    }
}

fn lengths(fault: &Fault, meta: &Meta) -> Finding {
    let geometry = &meta.geometry;
    match *fault {
        Fault::Positions(unit) => Finding::plain(
            Kind::PositionUnit,
            &[],
            format!(
                "the positions p1_m to p4_m are {} too large: {}?",
                times(unit.factor),
                unit.name
            ),
        ),
        Fault::Pitch(factor) => {
            let stated = geometry.pitch_m;
            let text = format!(
                "pitch {} mm by the data, {} mm stated",
                millimetres(stated / factor),
                millimetres(stated)
            );
            Finding::valued(Kind::Pitch, [stated, stated / factor], "m", text)
        }
        Fault::Span(factor) => {
            let stated = geometry.span_m.unwrap_or(f64::NAN);
            let text = format!(
                "span {} mm by the data, {} mm stated",
                millimetres(stated * factor),
                millimetres(stated)
            );
            Finding::valued(Kind::Span, [stated, stated * factor], "m", text)
        }
        _ => wires(fault),
    }
}

fn mounting(fault: &Fault, meta: &Meta) -> Finding {
    let stated = meta.coordination.unwrap_or_default();
    let lever = [stated.lever_x_m, stated.lever_y_m];
    match *fault {
        Fault::Height(factor) => {
            let full = stated.height_m * stated.tan_full_scale;
            let unit = unit_of(1.0 / factor, &ANGLES[..1], FULL_SCALE_SHARE)
                .map(|_| ": tan_full_scale in degrees?".to_owned())
                .or_else(|| {
                    let unit = unit_of(1.0 / factor, &LENGTHS, FULL_SCALE_SHARE)?;
                    Some(format!(": height_m in {}?", unit.name))
                })
                .unwrap_or_default();
            let text = format!(
                "height_m times tan_full_scale is {} mm by the data, {} mm stated (a height of {} mm at the stated full scale, a full scale of {:.4} \
                 at the stated height){unit}",
                millimetres(full * factor),
                millimetres(full),
                millimetres(stated.height_m * factor),
                stated.tan_full_scale * factor
            );
            Finding::valued(Kind::HeightOrFullScale, [full, full * factor], "m", text)
        }
        Fault::LeverReversed(axis) => {
            let text = format!(
                "lever_{}_m has the wrong sign: {} mm by the data, {} mm stated",
                AXES[axis],
                millimetres(-lever[axis]),
                millimetres(lever[axis])
            );
            Finding::valued(Kind::Lever, [lever[axis], -lever[axis]], "m", text)
        }
        Fault::LeversExchanged => Finding::valued(
            Kind::Lever,
            lever,
            "m",
            format!(
                "lever_x_m and lever_y_m are exchanged: {} and {} mm by the data",
                millimetres(lever[1]),
                millimetres(lever[0])
            ),
        ),
        Fault::Lever(axis, found) => {
            let unit = unit_of(lever[axis] / found, &LENGTHS, FULL_SCALE_SHARE);
            let unit = unit.map_or_else(String::new, |u| format!(": {}?", u.name));
            let text = format!(
                "lever_{}_m is {} mm by the data, {} mm stated{unit}",
                AXES[axis],
                millimetres(found),
                millimetres(lever[axis])
            );
            Finding::valued(Kind::Lever, [lever[axis], found], "m", text)
        }
        _ => wires(fault),
    }
}

fn diode(fault: &Fault) -> Finding {
    let (kind, text) = match *fault {
        Fault::ElectrodesExchanged(a, b) => (
            Kind::Electrodes,
            format!("{} and {} are exchanged", ELECTRODES[a], ELECTRODES[b]),
        ),
        Fault::DiodeAxesExchanged => (
            Kind::DiodeAxes,
            "the electrodes of the diode's x and y are exchanged".into(),
        ),
        Fault::DiodeTurned(degrees) => (
            Kind::DiodeAxes,
            format!("the diode is mounted turned by {degrees} degrees"),
        ),
        _ => (Kind::Electrodes, String::new()),
    };
    Finding::plain(kind, &[], text)
}

fn pose(fault: &Fault) -> Finding {
    let name = |source: Source| match source {
        Source::Reference => "reference",
        Source::Commanded => "commanded pose",
    };
    let kind = |source: Source, of_reference: Kind| match source {
        Source::Reference => of_reference,
        Source::Commanded => Kind::Commanded,
    };
    match *fault {
        Fault::PoseAxesExchanged(source) => Finding::plain(
            kind(source, Kind::ReferenceAxes),
            &[],
            format!(
                "x and y of the {} are exchanged, or those of the segments",
                name(source)
            ),
        ),
        Fault::PoseReversed(source, axis) => Finding::plain(
            kind(source, Kind::ReferenceSign),
            &[],
            format!("{} of the {} has the wrong sign", AXES[axis], name(source)),
        ),
        Fault::PoseAllReversed(source) => Finding::plain(
            kind(source, Kind::ReferenceSign),
            &[],
            format!(
                "the {} has the wrong sign, or all segments have",
                name(source)
            ),
        ),
        Fault::PoseScale(source, axes, factor) => {
            let (what, units) = match axes {
                Axes::Lengths => ("lengths", &LENGTHS),
                Axes::One(axis) => (AXES[axis], &LENGTHS),
                Axes::Angle => ("angle", &ANGLES),
            };
            let unit = unit_of(factor, units, FULL_SCALE_SHARE);
            let unit = unit.map_or_else(String::new, |u| format!(": {}?", u.name));
            let size = if factor > 1.0 {
                format!("{} too large", times(factor))
            } else {
                format!("{} too small", times(1.0 / factor))
            };
            let text = format!("the {}'s {what}: {size}{unit}", name(source));
            Finding {
                found: Some(factor),
                stated: Some(1.0),
                ..Finding::plain(kind(source, Kind::ReferenceUnit), &[], text)
            }
        }
        Fault::ReferenceIsReading(segment, axis) => Finding::plain(
            Kind::ReferenceIsReading,
            &[segment],
            format!(
                "the reference's {} holds the readings of segment {}: a reference is an instrument of its own",
                AXES[axis],
                segment + 1
            ),
        ),
        _ => wires(fault),
    }
}

/// "a thousand times", "25.4 times".
fn times(factor: f64) -> String {
    match factor {
        f if (f / 1.0e3 - 1.0).abs() < 1.0e-3 => "a thousand times".into(),
        f if (f / 1.0e6 - 1.0).abs() < 1.0e-3 => "a million times".into(),
        f if (f / 1.0e2 - 1.0).abs() < 1.0e-3 => "a hundred times".into(),
        f => format!("{f:.4} times"),
    }
}

/// A length in mm to four digits.
fn millimetres(length_m: f64) -> String {
    let value = 1.0e3 * length_m;
    let digits = (3 - value.abs().max(1e-9).log10().floor() as i32).clamp(0, 6) as usize;
    format!("{value:.digits$}")
}
