//! What was stated of the geometry, beside what the data say.

use super::table::{header, table};
use diagnosis::verdict::answer::Diagnosis;
use maud::{Markup, html};

/// A table of stated and found lengths; nothing where this motion tells none.
pub fn section(diagnosis: &Diagnosis) -> Markup {
    let millimetres = |m: f64| format!("{:.4} mm", 1.0e3 * m);
    let rows: Vec<Vec<String>> = diagnosis
        .geometry
        .iter()
        .map(|f| {
            let [stated, found, error] = [f.stated_m, f.found_m, f.error_m].map(millimetres);
            vec![f.name.clone(), stated, found, error]
        })
        .collect();
    html! {
        @if !rows.is_empty() {
            section aria-labelledby="geometry" {
                h2 id="geometry" { "Stated geometry and what the data say" }
                p.small { "Lengths of recording.toml that this motion tells. A first look before anything is fitted: how far each may be off counts all that this look leaves as one error." }
                (table(&header(["length", "stated", "by the data", "known to"]), &rows))
            }
        }
    }
}
