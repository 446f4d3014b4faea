//! What people do wrong with wires, columns and units: a line each.

use crate::draw::Needs;
use plausibility::{Finding, Kind};
use recording::{Meta, Recording, Row, Samples};
use std::f64::consts::{PI, TAU};

/// A mistake.
pub struct Mistake {
    /// Its name.
    pub name: &'static str,
    /// What a recording must hold for it to be seen.
    pub needs: Needs,
    /// Made in the stated values.
    pub meta: fn(&mut Meta),
    /// Made in a row.
    pub row: fn(&mut Row, &Meta),
    /// The finding that names it.
    pub right: fn(&Finding, &Meta) -> bool,
}

const NOTHING: Needs = Needs {
    beacon: false,
    reference: false,
    positions: false,
    single: false,
    long_lever: false,
};
const BEACON: Needs = Needs {
    beacon: true,
    ..NOTHING
};
const LONG_LEVER: Needs = Needs {
    long_lever: true,
    ..BEACON
};
const REFERENCE: Needs = Needs {
    reference: true,
    ..NOTHING
};
const POSITIONS: Needs = Needs {
    positions: true,
    ..BEACON
};
const SINGLE: Needs = Needs {
    single: true,
    ..REFERENCE
};

/// A mistake in the rows alone.
const fn rows(
    name: &'static str,
    needs: Needs,
    row: fn(&mut Row, &Meta),
    right: fn(&Finding, &Meta) -> bool,
) -> Mistake {
    Mistake {
        name,
        needs,
        meta: |_| {},
        row,
        right,
    }
}

/// A mistake in the stated values alone.
const fn stated(
    name: &'static str,
    needs: Needs,
    meta: fn(&mut Meta),
    right: fn(&Finding, &Meta) -> bool,
) -> Mistake {
    Mistake {
        name,
        needs,
        meta,
        row: |_, _| {},
        right,
    }
}

/// All of them.
pub const KINDS: &[Mistake] = &[
    rows(
        "segments 1 and 2 exchanged",
        BEACON,
        |r, _| swap(r, 0, 1),
        |f, _| exchanged(f, &[1, 2]),
    ),
    rows(
        "segments 1 and 3 exchanged",
        BEACON,
        |r, _| swap(r, 0, 2),
        |f, _| exchanged(f, &[1, 3]),
    ),
    rows(
        "segments 1 and 4 exchanged",
        BEACON,
        |r, _| swap(r, 0, 3),
        |f, _| exchanged(f, &[1, 4]),
    ),
    rows(
        "segments 2 and 3 exchanged",
        REFERENCE,
        |r, _| swap(r, 1, 2),
        |f, _| exchanged(f, &[2, 3]),
    ),
    rows(
        "segments 2 and 4 exchanged",
        REFERENCE,
        |r, _| swap(r, 1, 3),
        |f, _| exchanged(f, &[2, 4]),
    ),
    rows(
        "segments 3 and 4 exchanged, no beacon",
        NOTHING,
        |r, _| swap(r, 2, 3),
        |f, _| exchanged(f, &[3, 4]) || exchanged(f, &[1, 2]),
    ),
    rows(
        "x and y exchanged",
        BEACON,
        |r, _| {
            swap(r, 0, 1);
            swap(r, 2, 3);
        },
        |f, _| exchanged(f, &[1, 2, 3, 4]),
    ),
    rows(
        "x and y exchanged against a reference",
        REFERENCE,
        |r, _| {
            swap(r, 0, 1);
            swap(r, 2, 3);
        },
        |f, _| exchanged(f, &[1, 2, 3, 4]) || f.kind == Kind::ReferenceAxes,
    ),
    rows(
        "sine and cosine of segment 1 exchanged",
        BEACON,
        |r, m| rewired(r, m, 0, |[s, c]| [c, s]),
        |f, _| reversed(f, &[1]),
    ),
    rows(
        "sine of segment 2 inverted, no beacon",
        NOTHING,
        |r, m| rewired(r, m, 1, |[s, c]| [-s, c]),
        |f, _| reversed(f, &[2]),
    ),
    rows(
        "cosine of segment 3 inverted",
        REFERENCE,
        |r, m| rewired(r, m, 2, |[s, c]| [s, -c]),
        |f, _| reversed(f, &[3]),
    ),
    rows(
        "sine and cosine of segment 4 exchanged",
        NOTHING,
        |r, m| rewired(r, m, 3, |[s, c]| [c, s]),
        |f, _| reversed(f, &[4]),
    ),
    rows(
        "segments 1 and 3 reversed",
        BEACON,
        |r, m| {
            rewired(r, m, 0, |[s, c]| [c, s]);
            rewired(r, m, 2, |[s, c]| [c, s]);
        },
        |f, _| reversed(f, &[1, 3]),
    ),
    rows(
        "segments 2 and 4 reversed",
        REFERENCE,
        |r, m| {
            rewired(r, m, 1, |[s, c]| [c, s]);
            rewired(r, m, 3, |[s, c]| [c, s]);
        },
        |f, _| reversed(f, &[2, 4]),
    ),
    rows(
        "columns q2s and q2c exchanged",
        BEACON,
        |r, _| mixed(r, 1, |[s, c]| [c, s]),
        |f, _| quadrature(f, &[2]),
    ),
    rows(
        "column q3s inverted",
        NOTHING,
        |r, _| mixed(r, 2, |[s, c]| [-s, c]),
        |f, _| quadrature(f, &[3]),
    ),
    rows(
        "column q1c inverted",
        REFERENCE,
        |r, _| mixed(r, 0, |[s, c]| [s, -c]),
        |f, _| quadrature(f, &[1]),
    ),
    rows(
        "columns of 2 and 4 exchanged, counts not",
        BEACON,
        |r, _| r.quadrature_counts.swap(1, 3),
        |f, _| quadrature(f, &[2, 4]),
    ),
    rows(
        "one segment's sine and cosine columns exchanged",
        SINGLE,
        |r, _| mixed(r, 0, |[s, c]| [c, s]),
        |f, _| quadrature(f, &[1]),
    ),
    rows(
        "electrodes of x exchanged",
        BEACON,
        |r, _| electrodes(r, [1, 0, 2, 3]),
        |f, _| f.kind == Kind::Electrodes && f.sentence.contains("psd_xp and psd_xn"),
    ),
    rows(
        "electrodes of y exchanged",
        BEACON,
        |r, _| electrodes(r, [0, 1, 3, 2]),
        |f, _| f.kind == Kind::Electrodes && f.sentence.contains("psd_yp and psd_yn"),
    ),
    rows(
        "electrodes x- and y+ exchanged",
        BEACON,
        |r, _| electrodes(r, [0, 2, 1, 3]),
        |f, _| f.kind == Kind::Electrodes && f.sentence.contains("psd_xn and psd_yp"),
    ),
    rows(
        "electrodes x+ and y+ exchanged",
        BEACON,
        |r, _| electrodes(r, [2, 1, 0, 3]),
        |f, _| f.kind == Kind::Electrodes && f.sentence.contains("psd_xp and psd_yp"),
    ),
    rows(
        "diode's axes exchanged",
        BEACON,
        |r, _| electrodes(r, [2, 3, 0, 1]),
        |f, _| f.kind == Kind::DiodeAxes && f.sentence.contains("exchanged"),
    ),
    rows(
        "diode turned by a quarter",
        BEACON,
        |r, _| electrodes(r, [2, 3, 1, 0]),
        |f, _| f.kind == Kind::DiodeAxes && f.sentence.contains("turned"),
    ),
    rows(
        "diode turned by half",
        BEACON,
        |r, _| electrodes(r, [1, 0, 3, 2]),
        |f, _| f.kind == Kind::DiodeAxes && f.sentence.contains("turned by 180"),
    ),
    stated(
        "lever_x of the wrong sign",
        BEACON,
        |m| coordination(m).lever_x_m *= -1.0,
        |f, m| value(f, Kind::Lever, -of(m).lever_x_m, 0.1),
    ),
    stated(
        "lever_y of the wrong sign",
        LONG_LEVER,
        |m| coordination(m).lever_y_m *= -1.0,
        |f, m| value(f, Kind::Lever, -of(m).lever_y_m, 0.1),
    ),
    stated(
        "levers exchanged",
        BEACON,
        |m| {
            let c = coordination(m);
            std::mem::swap(&mut c.lever_x_m, &mut c.lever_y_m);
        },
        |f, _| f.kind == Kind::Lever && f.sentence.contains("exchanged"),
    ),
    stated(
        "lever_x in inches",
        BEACON,
        |m| coordination(m).lever_x_m /= 0.0254,
        |f, m| {
            value(f, Kind::Lever, of(m).lever_x_m * 0.0254, 0.1) && f.sentence.contains("inches?")
        },
    ),
    stated(
        "full scale in degrees",
        BEACON,
        |m| {
            let c = coordination(m);
            c.tan_full_scale = c.tan_full_scale.atan() * 180.0 / PI;
        },
        |f, _| f.kind == Kind::HeightOrFullScale && f.sentence.contains("degrees?"),
    ),
    stated(
        "height in inches",
        BEACON,
        |m| coordination(m).height_m /= 0.0254,
        |f, _| f.kind == Kind::HeightOrFullScale && f.sentence.contains("inches?"),
    ),
    stated(
        "height doubled",
        BEACON,
        |m| coordination(m).height_m *= 2.0,
        |f, m| {
            value(
                f,
                Kind::HeightOrFullScale,
                of(m).height_m * of(m).tan_full_scale / 2.0,
                0.1,
            )
        },
    ),
    stated(
        "pitch doubled",
        BEACON,
        |m| m.geometry.pitch_m *= 2.0,
        |f, m| value(f, Kind::Pitch, m.geometry.pitch_m / 2.0, 0.1),
    ),
    stated(
        "pitch doubled against a reference",
        REFERENCE,
        |m| m.geometry.pitch_m *= 2.0,
        |f, m| value(f, Kind::Pitch, m.geometry.pitch_m / 2.0, 0.01),
    ),
    stated(
        "pitch in inches",
        BEACON,
        |m| m.geometry.pitch_m /= 0.0254,
        |f, m| value(f, Kind::Pitch, m.geometry.pitch_m * 0.0254, 0.1),
    ),
    stated(
        "pitch 1 % off against a reference",
        REFERENCE,
        |m| m.geometry.pitch_m *= 1.01,
        |f, m| value(f, Kind::Pitch, m.geometry.pitch_m / 1.01, 0.003),
    ),
    stated(
        "span doubled",
        BEACON,
        |m| m.geometry.span_m = m.geometry.span_m.map(|s| 2.0 * s),
        |f, m| value(f, Kind::Span, span(m) / 2.0, 0.1),
    ),
    stated(
        "span halved against a reference",
        REFERENCE,
        |m| m.geometry.span_m = m.geometry.span_m.map(|s| s / 2.0),
        |f, m| value(f, Kind::Span, 2.0 * span(m), 0.1),
    ),
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

/// The recording with the mistake made.
pub fn made(mistake: &Mistake, right: &Recording) -> Recording {
    let mut samples = Samples::default();
    for k in 0..right.samples.len() {
        let mut row = right.samples.row(k);
        (mistake.row)(&mut row, &right.meta);
        samples.push(&row);
    }
    let mut meta = right.meta.clone();
    (mistake.meta)(&mut meta);
    Recording {
        meta,
        samples,
        warnings: Vec::new(),
    }
}

/// True if a finding names the mistake, alone or as one of what explains the readings equally well.
pub fn recognised(mistake: &Mistake, findings: &[Finding], meta: &Meta) -> bool {
    let named = |f: &Finding| (mistake.right)(f, meta);
    let instead = findings
        .iter()
        .flat_map(|f| &f.or)
        .any(|or| or.iter().any(named));
    findings.iter().any(named) || instead
}

fn swap(row: &mut Row, a: usize, b: usize) {
    row.quadrature_counts.swap(a, b);
    row.teeth.swap(a, b);
    row.position_m.swap(a, b);
}

/// A pair that was wired otherwise and counted by the board: the tooth count follows the wrong phase.
fn rewired(row: &mut Row, meta: &Meta, segment: usize, wire: fn([f64; 2]) -> [f64; 2]) {
    let (Some(output_m), Some(pair)) = (output(row, meta, segment), row.quadrature_counts[segment])
    else {
        return;
    };
    // Where the wrong phase is zero, the true one is that of this pair.
    let [sine, cosine] = wire([0.0, 1.0]);
    let start = sine.atan2(cosine) / TAU;
    let turns = start - output_m / meta.geometry.pitch_m;
    let wrong = wire(pair);
    row.quadrature_counts[segment] = Some(wrong);
    row.teeth[segment] = Some((turns - wrong[0].atan2(wrong[1]) / TAU).round() as i32);
}

/// Columns of a file that were mixed up: the tooth count is right.
fn mixed(row: &mut Row, segment: usize, mix: fn([f64; 2]) -> [f64; 2]) {
    row.quadrature_counts[segment] = row.quadrature_counts[segment].map(mix);
}

fn electrodes(row: &mut Row, order: [usize; 4]) {
    row.electrode_counts = row.electrode_counts.map(|e| order.map(|k| e[k]));
}

fn scaled(row: &mut Row, factors: [f64; 3]) {
    for (value, factor) in row.reference.iter_mut().zip(factors) {
        *value = value.map(|v| v * factor);
    }
}

fn output(row: &Row, meta: &Meta, segment: usize) -> Option<f64> {
    let (teeth, pair) = (row.teeth[segment]?, row.quadrature_counts[segment]?);
    Some(recording::unmodified_m(teeth, pair, meta.geometry.pitch_m))
}

fn coordination(meta: &mut Meta) -> &mut recording::Coordination {
    meta.coordination
        .as_mut()
        .expect("a recording with a beacon")
}

fn of(meta: &Meta) -> recording::Coordination {
    meta.coordination.expect("a recording with a beacon")
}

fn span(meta: &Meta) -> f64 {
    meta.geometry.span_m.expect("four segments")
}

fn exchanged(finding: &Finding, segments: &[usize]) -> bool {
    finding.kind == Kind::SegmentsExchanged && finding.segments == segments
}

fn reversed(finding: &Finding, segments: &[usize]) -> bool {
    finding.kind == Kind::SegmentReversed && finding.segments == segments
}

fn quadrature(finding: &Finding, segments: &[usize]) -> bool {
    finding.kind == Kind::Quadrature && finding.segments == segments
}

fn value(finding: &Finding, kind: Kind, wanted: f64, share: f64) -> bool {
    finding.kind == kind
        && finding
            .found
            .is_some_and(|f| (f / wanted - 1.0).abs() < share)
}
