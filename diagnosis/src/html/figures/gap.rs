//! The gap at a glance.

use super::{Figure, micro, strings};
use crate::html::plots::{self, Bar, MICRO};
use crate::html::svg::{AFTER, BEFORE, FLOOR, plot};
use crate::report::Diagnosis;

/// Residual rms of each channel: recording, with what is named, simulation.
pub fn gap(diagnosis: &Diagnosis) -> Figure {
    let channels = &diagnosis.held_out.channels;
    let groups = || -> Vec<(String, Vec<Bar>)> {
        channels
            .iter()
            .map(|c| {
                let bar = |value: f64, colour| Bar {
                    from: 0.0,
                    value: MICRO * value,
                    interval: None,
                    colour,
                };
                let after = Bar {
                    interval: Some(c.after_ci95_m.map(|v| MICRO * v)),
                    ..bar(c.after_rms_m, AFTER)
                };
                (
                    c.channel.replace('_', " "),
                    vec![
                        bar(c.before_rms_m, BEFORE),
                        after,
                        bar(c.floor_rms_m, FLOOR),
                    ],
                )
            })
            .collect()
    };
    let caption = channels
        .iter()
        .map(|c| {
            format!(
                "{}: {} µm before, {} µm after, floor {} µm",
                c.channel,
                micro(c.before_rms_m),
                micro(c.after_rms_m),
                micro(c.floor_rms_m)
            )
        })
        .collect::<Vec<_>>()
        .join("; ");
    let rows = channels
        .iter()
        .zip(&diagnosis.gap)
        .map(|(c, g)| {
            let interval = format!(
                "{} to {}",
                micro(c.after_ci95_m[0]),
                micro(c.after_ci95_m[1])
            );
            let excess = format!(
                "{} ({} to {})",
                micro(g.excess_rms_m),
                micro(g.excess_ci95_m[0]),
                micro(g.excess_ci95_m[1])
            );
            vec![
                c.channel.clone(),
                g.samples.to_string(),
                micro(c.before_rms_m),
                excess,
                micro(c.after_rms_m),
                interval,
                micro(c.floor_rms_m),
            ]
        })
        .collect();
    let header = strings([
        "channel",
        "samples",
        "recording, µm",
        "excess (95 %), µm",
        "after, µm",
        "after 95 %, µm",
        "simulation, µm",
    ]);
    Figure {
        id: "gap",
        title: "The gap at a glance".into(),
        plots: plot(
            &format!("Bars of held-out residuals. {caption}"),
            [1, 1],
            |area, narrow| plots::bars(area, narrow, &groups(), "held-out residual, rms, µm"),
        ),
        caption: format!("{caption}."),
        table: (header, rows),
    }
}
