//! The catalogue as a page: what each effect is, what a recording must offer, how large it is taken to be and why, what it is
//! confused with and what parts the two.

use crate::effect::{Card, Detection, Nature};
use std::fmt::Write as _;

/// What stands above the list.
const HEAD: &str = "# The catalogue of effects

What `courier diagnose` can name and `--sim-effect` can give a simulated courier. This page is made of the effects' own
cards, in `effects/src`: `cargo run -p effects --example page > docs/effects.md`. *Sizes* are prior sizes, what an effect
is taken to be before a recording is seen. A source stands in brackets; *ESS* is a public set of measurements of a rotary
drive's resolver. Where it says *without data*, nobody has measured it.
";

/// The page, in Markdown.
#[must_use]
pub fn page() -> String {
    let mut text = HEAD.to_owned();
    for card in crate::cards() {
        // Writing to a text cannot fail.
        let _ = section(&mut text, card);
    }
    text
}

fn section(text: &mut String, card: &Card) -> std::fmt::Result {
    writeln!(text, "\n## `{}`\n\n{}.\n", card.name, capital(card.summary))?;
    let mut line = |what: &str, told: &str| {
        if told.is_empty() {
            Ok(())
        } else {
            writeln!(text, "- *{what}*: {told}")
        }
    };
    line("how it is found", found(card))?;
    let needs: Vec<&str> = card.needs.iter().map(|need| need.words()).collect();
    line("needs", &needs.join(", "))?;
    line("sizes", card.sizes)?;
    line("the motion that tells it", card.telling_motion)?;
    let forms: Vec<&str> = card.forms.iter().map(|form| form.tells).collect();
    line("fuller forms", &forms.join("; "))?;
    line("carries over to another recording", card.carries_over)?;
    line("what a board takes over", card.on_board)?;
    for other in card.confusable {
        line(&format!("confused with `{}`", other.with), other.parted_by)?;
    }
    Ok(())
}

fn found(card: &Card) -> &'static str {
    match (card.detection, card.nature) {
        (Detection::AsSlips, _) => "as steps of whole teeth, which are repaired",
        (Detection::AsBursts, _) => "as samples that stand out far, which are left out",
        (Detection::AsNoise, _) => "as noise above the stated level",
        (Detection::AsField, _) => {
            "as a field over the platen, where the teeth are passed often enough"
        }
        (Detection::ByLines, _) => "at the lines that stand in the spectrum",
        (Detection::ByRails, _) => "by the figure that a pair's counts draw, then by a fit",
        (Detection::ByFit, Nature::Cause) => "by a fit",
        (Detection::ByFit, Nature::Flexible) => {
            "by a fit of many unknowns, where no simpler shape does nearly as well"
        }
        (Detection::ByFit, Nature::Shape) => {
            "by a fit of free shapes: named only where no cause does as well"
        }
    }
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    let first = letters.next().map(|first| first.to_uppercase().to_string());
    first.unwrap_or_default() + letters.as_str()
}

#[cfg(test)]
mod tests {
    #[test]
    fn the_page_of_the_catalogue_is_that_of_the_cards() {
        let path = concat!(env!("CARGO_MANIFEST_DIR"), "/../docs/effects.md");
        let kept = std::fs::read_to_string(path).unwrap_or_default();
        let made = super::page();
        let first = kept.lines().zip(made.lines()).position(|(a, b)| a != b);
        assert!(
            kept == made,
            "docs/effects.md differs, first in line {}: cargo run -p effects --example page > docs/effects.md",
            first.map_or(kept.lines().count(), |at| at) + 1
        );
    }
}
