//! What `courier encoder` says, and the calibration that it writes.

use crate::terminal::{figure, micrometres, table};
use anyhow::{Result, anyhow};
use courier_sensor::calibration::record::Calibration;
use courier_sensor::geometry::Geometry;
use courier_sensor::model::{ErrorModel, Term, TermTable};
use courier_sensor::quadrature::PairCorrection;
use encoder::{Answer, Harmonic};
use serde_json::{Value, json};

/// The answer in words.
#[must_use]
pub fn text(place: &str, answer: &Answer) -> String {
    let [slow, fast] = answer.speeds_hz.map(figure);
    let mut text = format!(
        "{place}: {} samples, {} stretches of {} periods at {slow} to {fast} periods/s",
        answer.samples,
        answer.stretches,
        figure(answer.stretch_periods)
    );
    if let Some(rows) = channels(answer) {
        text += &format!("\n{}", table(&["channels", "value", "±"], &rows));
    }
    let rows: Vec<Vec<String>> = answer.harmonics.iter().map(order).collect();
    let header = [
        "order of the angle",
        "sine, µm",
        "cosine, µm",
        "±",
        "applied",
        "ripple, µm",
        "reverses, µm",
    ];
    text += &format!("\n{}", table(&header, &rows));
    if let Some(turn) = &answer.turn {
        let [before, after] =
            [turn.before_turns, turn.after_turns].map(|turns| micrometres(turns * answer.pitch_m));
        text += &format!(
            "\nturn of {} periods: {} orders, {before} -> {after} µm rms in periods that were held out",
            turn.periods,
            turn.orders.len()
        );
        if let Some(index) = &turn.index {
            text += &format!(
                "; counted from the phase zero at the index, which came {} times, {:.2} ± {:.2} periods from it",
                index.passes, index.after_periods, index.spread_periods
            );
        }
    }
    text += &format!(
        "\nleft within the median stretch: {} µm rms",
        micrometres(answer.noise_m)
    );
    for remark in &answer.remarks {
        text += &format!("\nnot told: {}; what tells: {}", remark.what, remark.tell);
    }
    text
}

fn channels(answer: &Answer) -> Option<Vec<Vec<String>>> {
    let channels = answer.channels.as_ref()?;
    let [sine, cosine] = answer.offsets()?;
    let unit = answer.unit.scale;
    let row =
        |name: &str, value: String, deviation: String| vec![name.to_owned(), value, deviation];
    let [order_3, order_4] = channels.radius_orders;
    let of_radius = |name: &str, [size, deviation]: [f64; 2]| {
        row(name, figure(100.0 * size), figure(100.0 * deviation))
    };
    Some(vec![
        row(
            "amplitude",
            figure(channels.amplitude_counts / unit),
            String::new(),
        ),
        row(
            "offset of the sine",
            figure(sine),
            figure(channels.offset_deviation_counts[0] / unit),
        ),
        row(
            "offset of the cosine",
            figure(cosine),
            figure(channels.offset_deviation_counts[1] / unit),
        ),
        row(
            "gain, cosine over sine",
            format!("{:.5}", channels.gain),
            format!("{:.5}", channels.gain_deviation),
        ),
        row(
            "angle from 90°, degrees",
            figure(channels.angle_rad.to_degrees()),
            figure(channels.angle_deviation_rad.to_degrees()),
        ),
        of_radius("radius, order 3, %", order_3),
        of_radius("radius, order 4, %", order_4),
    ])
}

fn order(harmonic: &Harmonic) -> Vec<String> {
    let size = |length_m: Option<f64>| length_m.map_or(String::new(), micrometres);
    let applied = if harmonic.applied { "yes" } else { "no" };
    vec![
        harmonic.order.to_string(),
        micrometres(harmonic.sine_m),
        micrometres(harmonic.cosine_m),
        micrometres(harmonic.deviation_m),
        applied.to_owned(),
        size(harmonic.ripple_m),
        size(harmonic.reversing_m),
    ]
}

/// The same for programs.
#[must_use]
pub fn as_json(place: &str, answer: &Answer) -> Value {
    let mut value = json!(answer);
    value["log"] = json!(place);
    value["offsets"] = json!(answer.offsets());
    value
}

/// A calibration with the pair and the orders of one segment; all other segments have none.
///
/// # Errors
/// It would be refused when it is read: counts that the board's converter does not have, or errors of over half a period.
pub fn calibration(
    answer: &Answer,
    segment: usize,
    geometry: &recording::Geometry,
) -> Result<Calibration> {
    let applied = answer.harmonics.iter().filter(|harmonic| harmonic.applied);
    let terms: Vec<Term> = applied
        .clone()
        .map(|harmonic| Term::own(harmonic.order as u8))
        .collect();
    let table = TermTable::new(&terms).map_err(|(_, error)| anyhow!("{error}"))?;
    let mut model = ErrorModel::zero(table);
    for (rows, harmonic) in model.coefficients.iter_mut().zip(applied) {
        rows[segment] = [harmonic.sine_m, harmonic.cosine_m].map(|k| k as f32);
    }
    let stated =
        |length_m: Option<f64>, paper: f32| length_m.map_or(paper, |length_m| length_m as f32);
    let mut calibration = Calibration::identity(Geometry {
        pitch_m: geometry.pitch_m as f32,
        span_m: stated(geometry.span_m, Geometry::PAPER.span_m),
        lateral_m: stated(geometry.lateral_m, Geometry::PAPER.lateral_m),
        ..Geometry::PAPER
    });
    calibration.model = model;
    if let Some(channels) = &answer.channels {
        calibration.pairs[segment] = PairCorrection {
            offset_counts: channels.offset_counts.map(|counts| counts as f32),
            gain: channels.gain as f32,
            angle_rad: channels.angle_rad as f32,
        };
        calibration.amplitude_counts[segment] = channels.amplitude_counts as f32;
    }
    calibration.validate()?;
    Ok(calibration)
}
