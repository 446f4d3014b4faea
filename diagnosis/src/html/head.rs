//! The head of the report: the verdict in a sentence, and the few numbers behind it.

use super::svg::times;
use crate::advice::{headline, percent};
use crate::evidence::Evidence;
use crate::report::{Diagnosis, Verdict};
use maud::{Markup, html};

/// The verdict, the headline, what must be said besides, and the numbers.
pub fn section(diagnosis: &Diagnosis, evidence: &Evidence) -> Markup {
    html! {
        header {
            p.over { "Diagnosis of " code { (diagnosis.recording) } }
            h1 { span class={ "pill " (tone(diagnosis)) } { (verdict(diagnosis.verdict)) } " " (headline(diagnosis)) }
            (facts(diagnosis, evidence))
            @for note in &diagnosis.notes { p.note { (note) } }
        }
    }
}

/// The verdict as it stands in JSON, in words.
fn verdict(verdict: Verdict) -> &'static str {
    match verdict {
        Verdict::NoGap => "no gap",
        Verdict::Named => "named",
        Verdict::Alias => "alias",
        Verdict::Unknown => "unknown",
        Verdict::InsufficientData => "insufficient data",
    }
}

/// Colour of the verdict.
fn tone(diagnosis: &Diagnosis) -> &'static str {
    match diagnosis.verdict {
        Verdict::NoGap | Verdict::Named => "good",
        Verdict::Alias | Verdict::InsufficientData => "warn",
        Verdict::Unknown => "bad",
    }
}

fn facts(diagnosis: &Diagnosis, evidence: &Evidence) -> Markup {
    let held = &diagnosis.held_out;
    let named = !diagnosis.effects.is_empty();
    let floors = |value: f64| format!("{} × floor", times(value));
    html! {
        dl.facts {
            @if !held.channels.is_empty() {
                (fact(if named { "residual before" } else { "residual" }, &floors(held.whitened_before)))
                @if named {
                    (fact("residual after", &floors(held.whitened_after)))
                    (fact("of the squared gap left", &percent(diagnosis.unexplained.share)))
                }
            }
            @if evidence.samples > 0 { (fact("samples", &evidence.samples.to_string())) }
            @if evidence.set_aside > 0 { (fact("disturbed or resting, set aside", &evidence.set_aside.to_string())) }
        }
    }
}

fn fact(name: &str, value: &str) -> Markup {
    html! { div { dt { (name) } dd { (value) } } }
}
