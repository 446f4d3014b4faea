//! The answer of `courier fleet` for the terminal.

use crate::terminal::{figure, micrometres, table};
use fleet::{Answer, CourierAnswer, PlatenAnswer, RecordingAnswer, Told};

/// All of it: held-out poses by recording, then couriers, platens, and what none of it tells.
pub fn text(answer: &Answer) -> String {
    let recordings = table(
        &[
            "recording",
            "courier",
            "platen",
            "teeth",
            "poses",
            "held-out g_p, g_x, g_y, µm: plain",
            "with its own map",
            "fleet",
        ],
        &answer.recordings.iter().map(recording).collect::<Vec<_>>(),
    );
    let couriers = table(
        &[
            "courier",
            "waves, µm",
            "± alone",
            "± fleet",
            "span, µm",
            "± alone",
            "± fleet",
            "spans apart, µm",
            "± alone",
            "± fleet",
        ],
        &answer.couriers.iter().map(courier).collect::<Vec<_>>(),
    );
    let platens = table(
        &[
            "platen",
            "couriers",
            "cells",
            "field, µm",
            "± alone",
            "± fleet",
            "out of square, mrad",
            "± alone",
            "± fleet",
            "pitch x over y, 1e-3",
            "± alone",
            "± fleet",
        ],
        &answer.platens.iter().map(platen).collect::<Vec<_>>(),
    );
    let gauge: Vec<String> = answer
        .gauge
        .iter()
        .map(|line| format!("  {line}"))
        .collect();
    let astray = astray(answer);
    format!(
        "{recordings}\n\n{couriers}\n\n{platens}\n\n{astray}{} unknowns, {} steps\ntold by no recording of this kind:\n{}",
        answer.unknowns,
        answer.steps,
        gauge.join("\n")
    )
}

/// The courier that fits worst, if chance does not explain it: it spoils the fields for the others as well, so these are named once it is left out.
fn astray(answer: &Answer) -> String {
    let all = answer.couriers.iter().filter(|of| of.fits.is_astray());
    let worst = all.max_by(|a, b| a.fits.deviations.total_cmp(&b.fits.deviations));
    worst.map_or_else(String::new, |of| {
        format!(
            "{} does not fit the fields that it shares: they leave {} times as much of its g_p as fields of its own do, {} deviations of chance. It may be of another make, or its platen another one: fit without it, and it by itself\n\n",
            of.courier,
            figure(of.fits.ratio),
            figure(of.fits.deviations)
        )
    })
}

fn recording(of: &RecordingAnswer) -> Vec<String> {
    let three = |g_m: [f64; 3]| g_m.map(micrometres).join(", ");
    vec![
        of.recording.clone(),
        of.courier.clone(),
        of.platen.to_string(),
        of.shift_teeth.map(|teeth| format!("{teeth:+}")).join(", "),
        of.poses.to_string(),
        three(of.plain_m),
        three(of.alone_m),
        three(of.fleet_m),
    ]
}

fn courier(of: &CourierAnswer) -> Vec<String> {
    let mut row = vec![of.courier.clone()];
    for told in [of.waves_m, of.span_m, of.spans_apart_m] {
        row.extend(three(told, 1.0e6));
    }
    row
}

fn platen(of: &PlatenAnswer) -> Vec<String> {
    let mut row = vec![
        of.platen.to_string(),
        of.couriers.to_string(),
        format!("{} ({} by one)", of.cells, of.cells_alone),
    ];
    row.extend(three(of.field_m, 1.0e6));
    row.extend(three(of.out_of_square_rad, 1.0e3));
    row.extend(three(of.pitch_difference, 1.0e3));
    row
}

/// Value, and both deviations, where the data tell them.
fn three(told: Told, per_unit: f64) -> [String; 3] {
    let one = |is_told: bool, number: f64| match is_told {
        true => figure(per_unit * number),
        false => "not told".to_owned(),
    };
    [
        one(told.is_told(), told.value),
        one(told.is_told_alone(), told.alone),
        one(told.is_told(), told.deviation),
    ]
}

#[cfg(test)]
mod tests {
    use super::*;
    use fleet::Platen;

    /// As three couriers tell a skewed ruling that none of them tells alone (`fleet/tests/suite/sums.rs`).
    #[test]
    fn what_many_tell_and_none_alone_has_its_figures_beside_not_told() {
        let told = |value, alone, deviation, prior| Told {
            value,
            deviation,
            alone,
            prior,
        };
        let row = platen(&PlatenAnswer {
            platen: Platen {
                platen_id: "granite".into(),
                beacon_id: String::new(),
            },
            recordings: 3,
            couriers: 3,
            cells: 94,
            cells_alone: 67,
            field_m: told(2.0e-6, 0.7e-6, 0.6e-6, 3.0e-6),
            field: Vec::new(),
            pitch_difference: told(5.0e-5, 5.87e-4, 5.62e-4, 6.0e-4),
            out_of_square_rad: told(-1.99e-4, 5.64e-4, 5.25e-4, 6.0e-4),
        });
        let wanted = "granite, 3, 94 (67 by one), 2.00, 0.700, 0.600, -0.199, not told, 0.525, not told, not told, not told";
        assert_eq!(row.join(", "), wanted);
    }
}
