//! Exchanged and inverted wires of segments and electrodes.

use super::findings::{exchanged, quadrature, reversed};
use super::mistake::{BEACON, Mistake, NOTHING, REFERENCE, SINGLE, rows};
use super::rows::{electrodes, mixed, rewired, swap};
use plausibility::Kind;

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
];
