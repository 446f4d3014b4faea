//! What to do next.

use super::origin::Origin;
use crate::advice::{Advice, next_measurements};
use diagnosis::verdict::answer::Diagnosis;
use diagnosis::verdict::evidence::Evidence;
use maud::{Markup, html};

/// Motions with their durations, and the commands to copy.
pub fn section(diagnosis: &Diagnosis, evidence: &Evidence, origin: &Origin) -> Markup {
    let list = next_measurements(diagnosis, &evidence.setting, origin.model.as_deref());
    let commands = || list.iter().flat_map(|a| &a.commands);
    let records = commands().any(|c| c.starts_with("courier record"));
    let unplaced = commands().any(|c| c.contains("THETA"));
    html! {
        section aria-labelledby="next" {
            h2 id="next" { "What to do next" }
            ol { @for advice in &list { (one(advice)) } }
            @if records {
                p.small { "For a real board add its option, for example " code { "--probe any" } "; without one these commands move a simulated courier." }
            }
            @if unplaced {
                p.small { "X, Y and THETA are the place to stand at: mm, mm and degrees in the motion controller's frame." }
            }
        }
    }
}

fn one(advice: &Advice) -> Markup {
    html! {
        li {
            p { (advice.what) @if !advice.takes.is_empty() { " " span.takes { (advice.takes) } } }
            @if !advice.commands.is_empty() { pre tabindex="0" { code { (advice.commands.join("\n")) } } }
        }
    }
}
