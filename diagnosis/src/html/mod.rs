//! The report: one HTML file that needs nothing else, for a desk and a phone, by day and by night.
//!
//! `figures` says what is shown and says it again in words and tables, `plots` draws, `svg` fits plots to the page,
//! `telling` finds the coordinate to draw over, `spectrum` its spectra.

pub mod figures;
pub mod plots;
pub mod spectrum;
pub mod svg;
pub mod telling;

use crate::advice::{headline, next_measurements, percent, sentence};
use crate::evidence::Evidence;
use crate::report::{Diagnosis, Named, Share, Verdict};
use figures::Figure;
use maud::{DOCTYPE, Markup, PreEscaped, html};
use svg::short;

/// What a page says in its head of who made it.
pub const MADE_BY: &str = "<meta name=\"generator\" content=\"courier\">";

const STYLE: &str = include_str!("style.css");

/// The whole page.
#[must_use]
pub fn page(diagnosis: &Diagnosis, evidence: &Evidence) -> String {
    let body = html! {
        header {
            p.over { "Diagnosis of " code { (diagnosis.recording) } }
            h1 { span class={ "pill " (verdict(diagnosis.verdict)) } { (verdict(diagnosis.verdict).replace('_', " ")) } " " (headline(diagnosis)) }
            (facts(diagnosis, evidence))
        }
        main {
            @for figure in first_figures(diagnosis, evidence) { (drawn(&figure)) }
            (effects_section(diagnosis))
            (where_section(diagnosis))
            @for figure in further_figures(diagnosis, evidence) { (drawn(&figure)) }
            (next_section(diagnosis))
        }
        footer { p { "All figures are of held-out data: blocks that no fit has seen. The floor is the simulator's own scatter under the stated noise." } }
    };
    document(&format!("Diagnosis of {}", diagnosis.recording), &body)
}

/// A page with the report's style around a body.
#[must_use]
pub fn document(title: &str, body: &Markup) -> String {
    html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                link rel="icon" href="data:,";
                (PreEscaped(MADE_BY))
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body { (body) }
        }
    }
    .into_string()
}

fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NoGap => "no_gap",
        Verdict::Named => "named",
        Verdict::Alias => "alias",
        Verdict::Unknown => "unknown",
        Verdict::InsufficientData => "insufficient_data",
    }
}

fn facts(diagnosis: &Diagnosis, evidence: &Evidence) -> Markup {
    let held = &diagnosis.held_out;
    html! {
        dl.facts {
            @if !held.channels.is_empty() {
                div { dt { "over the floor, before" } dd { (short(held.whitened_before)) } }
                div { dt { "after" } dd { (short(held.whitened_after)) } }
                div { dt { "unexplained" } dd { (percent(diagnosis.unexplained.share)) } }
            }
            div { dt { "samples" } dd { (evidence.samples) } }
            @if evidence.set_aside > 0 { div { dt { "set aside" } dd { (evidence.set_aside) } } }
        }
        @for note in &diagnosis.notes { p.note { (note) } }
    }
}

fn first_figures(diagnosis: &Diagnosis, evidence: &Evidence) -> Vec<Figure> {
    let mut list = Vec::new();
    if !diagnosis.held_out.channels.is_empty() {
        list.push(figures::gap(diagnosis));
    }
    list.extend(figures::waterfall(evidence));
    list
}

fn further_figures(diagnosis: &Diagnosis, evidence: &Evidence) -> Vec<Figure> {
    let places: Vec<&str> = diagnosis
        .place
        .iter()
        .take(1)
        .map(|p| p.coordinate.as_str())
        .collect();
    let Some((trace, coordinate)) = telling::telling(evidence, &places) else {
        return Vec::new();
    };
    let segmented =
        !coordinate.family.starts_with("place") && !coordinate.family.starts_with("deflection");
    let segment = trace
        .segment
        .or(coordinate.of.filter(|_| segmented))
        .unwrap_or(0);
    let mut list = Vec::new();
    list.extend(figures::telling(evidence, trace, &coordinate));
    list.extend(figures::orders(evidence, trace, segment, false));
    if trace.segment.is_none() {
        list.extend(figures::orders(evidence, trace, segment, true));
    }
    list.extend(figures::frequencies(evidence, trace));
    list.extend(figures::map(evidence, trace));
    list
}

/// A figure with its caption and table.
pub fn drawn(figure: &Figure) -> Markup {
    html! {
        section aria-labelledby=(figure.id) {
            h2 id=(figure.id) { (figure.title) }
            figure {
                @for plot in &figure.plots {
                    div class=(if plot.narrow { "plot narrow" } else { "plot wide" }) { (PreEscaped(&plot.svg)) }
                }
                @if matches!(figure.id, "gap" | "orders" | "lateral-orders" | "frequencies") {
                    p.legend aria-hidden="true" { span.before { "before" } span.after { "after" } @if figure.id == "gap" { span.floor { "simulation" } } }
                }
                figcaption { (figure.caption) }
            }
            details { summary { "The same as a table" } (table(&figure.table.0, &figure.table.1)) }
        }
    }
}

/// A table that scrolls within itself where it is too wide.
pub fn table(header: &[String], rows: &[Vec<String>]) -> Markup {
    html! {
        div.scroll tabindex="0" role="region" aria-label="table" {
            table {
                thead { tr { @for title in header { th scope="col" { (title) } } } }
                tbody { @for row in rows { tr { @for (k, field) in row.iter().enumerate() {
                    @if k == 0 { th scope="row" { (field) } } @else { td { (field) } }
                } } } }
            }
        }
    }
}

fn effects_section(diagnosis: &Diagnosis) -> Markup {
    html! {
        section aria-labelledby="effects" {
            h2 id="effects" { "Which effect" }
            @if diagnosis.effects.is_empty() { p { "None is named." } }
            @for effect in &diagnosis.effects { (effect_card(effect)) }
        }
    }
}

fn effect_card(effect: &Named) -> Markup {
    let rows: Vec<Vec<String>> = effect
        .magnitude
        .iter()
        .map(|m| {
            vec![
                m.name.clone(),
                format!("{:.3e}", m.value).replace('-', "−"),
                m.unit.clone(),
            ]
        })
        .collect();
    let header: Vec<String> = ["amount", "value", "unit"].map(Into::into).to_vec();
    html! {
        article.effect {
            h3 { code { (effect.name) } " " span.probability { (percent(effect.probability)) } }
            p { (sentence(&effect.name)) "." }
            meter min="0" max="1" value=(effect.share) aria-label=(format!("share of the gap: {}", percent(effect.share))) {}
            p.small {
                "Takes " (percent(effect.share)) " of the gap."
                @if effect.gap_after_alone_m > 0.0 { " With it alone the largest channel is left with " (short(1.0e6 * effect.gap_after_alone_m)) " µm." }
            }
            @if !effect.aliases.is_empty() { p { "Not told apart from " @for alias in &effect.aliases { code { (alias) } " " } "on this motion." } }
            @if !rows.is_empty() { details { summary { "Size" } (table(&header, &rows)) } }
        }
    }
}

fn where_section(diagnosis: &Diagnosis) -> Markup {
    let rows = |list: &[Share]| -> Vec<Vec<String>> {
        list.iter()
            .map(|s| vec![s.coordinate.clone(), s.channel.clone(), percent(s.share)])
            .collect()
    };
    let header: Vec<String> = ["coordinate", "channel", "share of the excess"]
        .map(Into::into)
        .to_vec();
    html! {
        section aria-labelledby="where" {
            h2 id="where" { "Where it lies" }
            @if diagnosis.place.is_empty() { p { "No place stands out beyond chance." } } @else { (table(&header, &rows(&diagnosis.place))) }
            @if !diagnosis.unexplained.place.is_empty() && diagnosis.verdict != Verdict::Unknown {
                h3 { "What is left: " (percent(diagnosis.unexplained.share)) }
                (table(&header, &rows(&diagnosis.unexplained.place)))
            }
        }
    }
}

fn next_section(diagnosis: &Diagnosis) -> Markup {
    html! {
        section aria-labelledby="next" {
            h2 id="next" { "What to measure next" }
            ol { @for line in next_measurements(diagnosis) { li { (line) } } }
        }
    }
}
