//! Where the gap lies.

use super::table::{self, table};
use crate::advice::percent;
use crate::remainder::remainder;
use diagnosis::verdict::answer::{Diagnosis, Share, Verdict};
use maud::{Markup, html};

/// Shares of the gap by coordinate, and of what is left.
pub fn section(diagnosis: &Diagnosis) -> Markup {
    let left = &diagnosis.unexplained;
    html! {
        section aria-labelledby="where" {
            h2 id="where" { "Where it lies" }
            @if diagnosis.place.is_empty() { p { "No coordinate stands out beyond chance." } } @else {
                p.small { "How much of the squared gap goes with each coordinate. Coordinates that change together share it, so that shares need not add up to 100 %." }
                (shares(&diagnosis.place))
            }
            @for sentence in remainder(diagnosis) { p { (sentence) } }
            @if left.correction.is_some() { p.small { "In the figures below, after is with this correction." } }
            @if !left.place.is_empty() && diagnosis.verdict != Verdict::Unknown {
                details {
                    summary { "Where the rest lies: " (percent(left.share)) " of the squared gap is left" }
                    (shares(&left.place))
                }
            }
        }
    }
}

fn shares(list: &[Share]) -> Markup {
    let row = |s: &Share| vec![s.coordinate.clone(), s.channel.clone(), percent(s.share)];
    let rows: Vec<Vec<String>> = list.iter().map(row).collect();
    table(&table::header(["coordinate", "channel", "share"]), &rows)
}
