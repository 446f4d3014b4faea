//! The report: one HTML file that needs nothing else, for a desk and a phone, by day and by night, on paper.
//!
//! `figures` says what is shown and says it again in words and tables, `plots` draws, `svg` fits plots to the page,
//! `telling` finds the coordinate to draw over, `spectrum` its spectra, `passed` which of them the motion shows. The parts of the page
//! are `head`, `effects`, `place`, `next`, `geometry`, `origin` and `glossary`.

mod effects;
pub mod figures;
mod geometry;
mod glossary;
mod head;
mod next;
pub mod origin;
mod passed;
mod place;
pub mod plots;
pub mod spectrum;
pub mod svg;
mod table;
pub mod telling;

pub use origin::{Origin, stated};
pub use table::table;

use crate::headline::Headline;
use diagnosis::verdict::answer::Diagnosis;
use diagnosis::verdict::evidence::Evidence;
use figures::Figure;
use maud::{DOCTYPE, Markup, PreEscaped, html};

/// What a page says in its head of who made it.
pub const MADE_BY: &str = "<meta name=\"generator\" content=\"courier\">";

const STYLE: &str = include_str!("style.css");
/// Shows values under a pointer. Nothing is lost without it.
const SCRIPT: &str = include_str!("hover.js");
/// A page may use what is in it, and ask for nothing.
const POLICY: &str =
    "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

/// The whole page. The headline tells what the gap is held against, the origin where the page comes from.
#[must_use]
pub fn page(
    diagnosis: &Diagnosis,
    evidence: &Evidence,
    headline: &Headline,
    origin: &Origin,
) -> String {
    let mut first = Vec::new();
    if !diagnosis.held_out.channels.is_empty() {
        first.push(figures::gap(diagnosis));
    }
    first.extend(figures::waterfall(evidence));
    let (further, left_out) = further_figures(diagnosis, evidence);
    let body = html! {
        (head::section(diagnosis, evidence, headline))
        main {
            @for figure in &first { (drawn(figure)) }
            (effects::section(diagnosis))
            (next::section(diagnosis, evidence, origin))
            (place::section(diagnosis))
            @for figure in &further { (drawn(figure)) }
            (nothing_seen(&left_out))
            (geometry::section(diagnosis))
            (origin::section(origin))
        }
    };
    document(&format!("Diagnosis of {}", diagnosis.recording), &body)
}

/// A page with the report's style and script around a body, and the terms that it uses.
#[must_use]
pub fn document(title: &str, body: &Markup) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                link rel="icon" href="data:,";
                (PreEscaped(MADE_BY))
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                (body)
                (glossary::section(body))
                script { (PreEscaped(SCRIPT)) }
            }
        }
    }
    .into_string()
}

/// Figures of the channel and the coordinate that show the gap best, and what is not drawn, with its reason.
fn further_figures(diagnosis: &Diagnosis, evidence: &Evidence) -> (Vec<Figure>, Vec<String>) {
    let places: Vec<&str> = diagnosis
        .place
        .iter()
        .take(1)
        .map(|p| p.coordinate.as_str())
        .collect();
    let Some((trace, coordinate)) = telling::telling(evidence, &places) else {
        return (Vec::new(), Vec::new());
    };
    let segments: Vec<usize> = match trace.segment {
        Some(segment) => vec![segment],
        None => (0..4).filter(|s| evidence.setting.segments[*s]).collect(),
    };
    let mut list = Vec::new();
    let mut left_out = Vec::new();
    list.extend(figures::telling(evidence, trace, &coordinate));
    // Across a segment that is alone nothing is known.
    let phases = if evidence.setting.is_courier() {
        &[false, true][..]
    } else {
        &[false]
    };
    for lateral in phases {
        let orders = figures::orders(evidence, trace, &segments, *lateral);
        list.extend(orders.figure);
        left_out.extend(orders.left_out);
    }
    let places = diagnosis.place.iter().chain(&diagnosis.unexplained.place);
    if places
        .into_iter()
        .any(|p| p.coordinate.contains("fractional"))
    {
        list.extend(figures::fractions(evidence, trace, &segments));
    }
    let frequencies = figures::frequencies(evidence, trace);
    if frequencies.is_none() {
        left_out.push(format!(
            "Over frequency: no line of {} stands out of what chance gives.",
            trace.channel
        ));
    }
    list.extend(frequencies);
    list.extend(figures::map(evidence, trace));
    (list, left_out)
}

/// What was looked at and is not drawn.
fn nothing_seen(reasons: &[String]) -> Markup {
    if reasons.is_empty() {
        return html! {};
    }
    html! {
        section aria-labelledby="nothing" {
            h2 id="nothing" { "Looked at and not drawn" }
            ul { @for reason in reasons { li { (reason) } } }
        }
    }
}

/// A figure with its caption and table.
pub fn drawn(figure: &Figure) -> Markup {
    html! {
        section aria-labelledby=(figure.id) {
            h2 id=(figure.id) { (figure.title) }
            figure {
                @if !figure.legend.is_empty() {
                    p.legend aria-hidden="true" { @for (class, name) in &figure.legend { span class=(class) { (name) } } }
                }
                @for plot in &figure.plots {
                    div class=(if plot.narrow { "plot narrow" } else { "plot wide" }) { (PreEscaped(&plot.svg)) }
                }
                figcaption { (figure.caption) }
            }
            details { summary { "The same as a table" } (table(&figure.table.0, &figure.table.1)) }
        }
    }
}
