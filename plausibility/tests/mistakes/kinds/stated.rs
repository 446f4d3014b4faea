//! Wrong values in recording.toml.

use super::findings::value;
use super::mistake::{BEACON, LONG_LEVER, Mistake, REFERENCE, stated};
use plausibility::Kind;
use recording::Meta;
use std::f64::consts::PI;

pub const KINDS: &[Mistake] = &[
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
];

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
