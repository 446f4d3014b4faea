//! The scores as a page with plots, in the report's style.

use super::tally::Score;
use super::words::{self, matrix, row};
use crate::html::figures::Figure;
use crate::html::plots::{Axes, Bar, bars, scatter};
use crate::html::svg::{AFTER, BEFORE, FLOOR, plot, short};
use crate::html::{document, drawn, table};
use maud::html;

/// One self-contained HTML file.
#[must_use]
pub fn page(score: &Score) -> String {
    let rows: Vec<Vec<String>> = score.figures.iter().map(row).collect();
    let header: Vec<String> = ["figure", "measured", "95 % interval", "cases", "wanted", ""]
        .map(Into::into)
        .to_vec();
    let (effects, shrinkage) = (words::effects(score), words::shrinkage(score));
    let (confusion_header, confusion) = matrix(score);
    let body = html! {
        header {
            p.over { "Blind check of the diagnosis" }
            h1 { (score.cases) " couriers, their effects withheld" }
            p.small { "Seal: " code { (score.seal) } }
        }
        main {
            section aria-labelledby="figures" { h2 id="figures" { "Figures" } (table(&header, &rows)) }
            (drawn(&detection(score)))
            (drawn(&claims(score)))
            section aria-labelledby="effects" { h2 id="effects" { "Right answers, effect by size" } (table(&effects.0, &effects.1)) }
            section aria-labelledby="shrinkage" { h2 id="shrinkage" { "Claimed against true shrinkage" } (table(&shrinkage.0, &shrinkage.1)) }
            section aria-labelledby="confusion" { h2 id="confusion" { "Truth (rows) by answer (columns)" } (table(&confusion_header, &confusion)) }
        }
    };
    document("Blind check of the diagnosis", &body)
}

fn detection(score: &Score) -> Figure {
    let classes = || {
        score.detection.iter().map(|d| {
            let name = words::sizes(d);
            let share = |count: usize, colour| Bar {
                from: 0.0,
                value: 100.0 * count as f64 / d.cases.max(1) as f64,
                interval: None,
                colour,
            };
            (name, vec![share(d.detected, FLOOR), share(d.named, AFTER)])
        })
    };
    let caption = "Single effects by their size: share with a gap seen (grey), and with the right cause named first (blue).";
    Figure {
        id: "detection",
        title: "Detection against effect size".into(),
        caption: caption.into(),
        plots: plot(caption, [1, 1], |area, narrow| {
            bars(
                area,
                narrow,
                &classes().collect::<Vec<_>>(),
                "% of the cases",
            )
        }),
        table: words::detection(score),
    }
}

fn claims(score: &Score) -> Figure {
    let pairs: Vec<(usize, f64, f64)> = score
        .judged
        .iter()
        .filter_map(|j| {
            j.claim
                .as_ref()
                .and_then(|c| Some((j.case.number, c.confirmed?, c.claimed)))
        })
        .collect();
    let top = pairs.iter().map(|p| p.1.max(p.2)).fold(1.5, f64::max) * 1.05;
    let caption = "Gap after as claimed, over the gap after by check on a second recording; rms over the simulator's own scatter. The line is equality.";
    let points: Vec<(f64, f64)> = pairs.iter().map(|p| (p.1, p.2)).collect();
    let draw = |area: &crate::html::svg::Area, narrow: bool| {
        let axes = Axes {
            x: 0.9..top,
            y: 0.9..top,
            x_title: "confirmed",
            y_title: "claimed",
            title: "",
        };
        scatter(
            area,
            narrow,
            &axes,
            &points,
            &[(0.9, 0.9), (top, top)],
            BEFORE,
        )
    };
    let rows = pairs
        .iter()
        .map(|(n, confirmed, claimed)| {
            vec![format!("case {n}"), short(*claimed), short(*confirmed)]
        })
        .collect();
    Figure {
        id: "claims",
        title: "Claimed against true gap".into(),
        caption: caption.into(),
        plots: plot(caption, [1, 1], draw),
        table: (
            ["case", "claimed", "confirmed"].map(Into::into).to_vec(),
            rows,
        ),
    }
}
