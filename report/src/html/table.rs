//! Tables.

use maud::{Markup, html};

/// Titles as a header.
pub fn header<const N: usize>(titles: [&str; N]) -> Vec<String> {
    titles.map(Into::into).to_vec()
}

/// A table that scrolls within itself where it is too wide. On a phone each row of a table with more than three columns becomes a block
/// of its own, with the title of the column before each field, so that none is cut off.
pub fn table(header: &[String], rows: &[Vec<String>]) -> Markup {
    let class = if header.len() > 3 { "many" } else { "few" };
    html! {
        div.scroll tabindex="0" role="region" aria-label="table" {
            table class=(class) {
                thead { tr { @for title in header { th scope="col" { (title) } } } }
                tbody { @for row in rows { tr { @for (k, field) in row.iter().enumerate() {
                    @if k == 0 { th scope="row" { (field) } } @else {
                        td data-title=(header.get(k).map_or("", String::as_str)) { (field) }
                    }
                } } } }
            }
        }
    }
}
