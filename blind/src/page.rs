//! The scores as a page with plots, in the report's style.

use crate::claim::CLAIM_WITHIN;
use crate::detection::Detection;
use crate::judged::Judged;
use crate::tally::Score;
use crate::words::{self, matrix};
use maud::html;
use report::html::figures::Figure;
use report::html::plots::{self, Bar, BarAxis, Claimed, Group, bars, heights};
use report::html::svg::{AFTER, BEFORE, plot, short};
use report::html::{Origin, document, drawn, origin, table};

/// One self-contained HTML file.
#[must_use]
pub fn page(score: &Score, origin: &Origin) -> String {
    let (header, rows) = words::figures(score);
    let reliability = words::reliability(score);
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
            @if let Some(figure) = detection(score) { (drawn(&figure)) }
            @if let Some(figure) = claims(score) { (drawn(&figure)) }
            section aria-labelledby="reliability" { h2 id="reliability" { "Stated probability against what is true" } (table(&reliability.0, &reliability.1)) }
            section aria-labelledby="effects" { h2 id="effects" { "Right answers, effect by size" } (table(&effects.0, &effects.1)) }
            section aria-labelledby="shrinkage" { h2 id="shrinkage" { "Claimed against true shrinkage" } (table(&shrinkage.0, &shrinkage.1)) }
            section aria-labelledby="confusion" { h2 id="confusion" { "Truth (rows) by answer (columns)" } (table(&confusion_header, &confusion)) }
            (origin::section(origin))
        }
    };
    document("Blind check of the diagnosis", &body)
}

/// Single effects by their size, without classes that no case fell into; none where no case had a single effect.
fn detection(score: &Score) -> Option<Figure> {
    let classes: Vec<&Detection> = score.detection.iter().filter(|d| d.cases > 0).collect();
    let group = |d: &&Detection| {
        let name = words::sizes(d);
        let bar = |what: &str, count: usize, colour| {
            let share = 100.0 * count as f64 / d.cases as f64;
            Bar {
                value: share,
                was: None,
                interval: None,
                colour,
                label: format!("{count} of {}", d.cases),
                told: format!("{name}: {what} in {count} of {} cases", d.cases),
            }
        };
        let bars = vec![
            bar("gap seen", d.detected, BEFORE),
            bar("cause right", d.named, AFTER),
        ];
        (name.clone(), bars)
    };
    let groups: Vec<Group> = classes.iter().map(group).collect();
    let caption = "Couriers with one effect, by its size (rms of what it does): how many show a gap, and of how many the cause that is named first is right.";
    let axis = BarAxis {
        title: "% of the cases",
        line: None,
    };
    (!groups.is_empty()).then(|| Figure {
        id: "detection",
        title: "Detection against effect size".into(),
        caption: caption.into(),
        plots: plot(caption, heights(groups.len(), 2), |area, narrow| {
            bars(area, narrow, &groups, &axis)
        }),
        legend: vec![("before", "gap seen"), ("after", "cause right")],
        table: words::detection(score),
    })
}

/// Claims beside what a second recording showed, the farthest off first; none where no claim was checked.
fn claims(score: &Score) -> Option<Figure> {
    let claim = |j: &Judged| {
        let claim = j.claim.as_ref()?;
        Some((j.case.number, claim.claimed, claim.confirmed?))
    };
    let mut pairs: Vec<(usize, f64, f64)> = score.judged.iter().filter_map(claim).collect();
    let off = |(_, claimed, confirmed): &(usize, f64, f64)| claimed / confirmed - 1.0;
    pairs.sort_by(|a, b| off(b).abs().total_cmp(&off(a).abs()));
    let right = pairs
        .iter()
        .filter(|p| off(p).abs() <= CLAIM_WITHIN)
        .count();
    let caption = format!(
        "The gap after, as it was claimed from one recording, beside what the same model left on a second one of the same courier. \
         {right} of {} claims are within {:.0} % (the grey band). Squares at the edge are farther off than the plot is high.",
        pairs.len(),
        100.0 * CLAIM_WITHIN
    );
    let told = |pair: &(usize, f64, f64)| Claimed {
        confirmed: pair.2,
        off: off(pair),
        told: format!(
            "case {}: {} claimed, {} came true (times the floor)",
            pair.0,
            short(pair.1),
            short(pair.2)
        ),
    };
    let list: Vec<Claimed> = pairs.iter().map(told).collect();
    let row = |p: &(usize, f64, f64)| {
        let off = format!("{} %", short(100.0 * off(p)));
        vec![format!("case {}", p.0), short(p.1), short(p.2), off]
    };
    let header = [
        "case",
        "claimed, × floor",
        "came true, × floor",
        "too large by",
    ];
    (!pairs.is_empty()).then(|| Figure {
        id: "claims",
        title: "Claimed against true gap".into(),
        plots: plot(&caption, [340, 300], |area, narrow| {
            plots::claims(area, narrow, &list, CLAIM_WITHIN)
        }),
        caption,
        legend: vec![
            ("after", "right"),
            ("before", "farther off"),
            ("floor", "counted as right"),
        ],
        table: (
            header.map(Into::into).to_vec(),
            pairs.iter().map(row).collect(),
        ),
    })
}
