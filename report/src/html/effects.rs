//! The named effects: how sure, how large, how much of the gap.

use super::svg::short;
use super::table::{self, table};
use crate::advice::{percent, sentence};
use crate::units;
use diagnosis::verdict::answer::{Diagnosis, Magnitude, Named};
use maud::{Markup, html};

/// A card for each effect.
pub fn section(diagnosis: &Diagnosis) -> Markup {
    html! {
        section aria-labelledby="effects" {
            h2 id="effects" { "Which effect" }
            @if diagnosis.effects.is_empty() { p { "None is named." } }
            @for effect in &diagnosis.effects { (card(effect)) }
        }
    }
}

fn card(effect: &Named) -> Markup {
    html! {
        article.effect {
            h3 { code { (effect.name) } @if let Some(total) = units::total(effect) { ": " (total) } }
            p { (capital(sentence(&effect.name))) "." }
            dl.measures {
                (measure("Probability that it is a cause", &percent(effect.probability), effect.probability, "probability"))
                (measure("Share of the squared gap that it takes", &percent(effect.share), effect.share, "share"))
            }
            @if effect.gap_after_alone_m > 0.0 {
                p.small { "With this effect alone the largest channel is left with " (short(1.0e6 * effect.gap_after_alone_m)) " µm rms." }
            }
            @if !effect.aliases.is_empty() {
                p { "Not told apart from " @for (k, alias) in effect.aliases.iter().enumerate() { @if k > 0 { ", " } code { (alias) } } " on this motion." }
            }
            (amounts(&effect.magnitude))
        }
    }
}

/// A number with its name over a bar as long as it.
fn measure(name: &str, told: &str, share: f64, class: &str) -> Markup {
    let long = format!("width:{:.1}%", 100.0 * share.clamp(0.0, 1.0));
    html! {
        div class=(class) {
            dt { (name) }
            dd { (told) }
            span.track aria-hidden="true" { span style=(long) {} }
        }
    }
}

fn amounts(list: &[Magnitude]) -> Markup {
    if list.is_empty() {
        return html! {};
    }
    let row = |m: &Magnitude| vec![units::name(m), units::amount(m)];
    let rows: Vec<Vec<String>> = list.iter().map(row).collect();
    let many = if rows.len() == 1 { "amount" } else { "amounts" };
    html! {
        details {
            summary { "In parts: " (list.len()) " " (many) ", each with ± one standard deviation where it is known" }
            (table(&table::header(["amount", "value"]), &rows))
        }
    }
}

fn capital(text: &str) -> String {
    let mut letters = text.chars();
    letters.next().map_or(String::new(), |first| {
        first.to_uppercase().chain(letters).collect()
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn probability_and_share_are_told_apart() {
        let effect = Named {
            name: "velocity_lag".into(),
            probability: 0.98,
            share: 0.25,
            ..Named::default()
        };
        let told = card(&effect).into_string();
        let at = |text: &str| told.find(text).unwrap_or_else(|| panic!("{text}: {told}"));
        assert!(at("Probability that it is a cause") < at("98 %"));
        assert!(at("98 %") < at("Share of the squared gap"));
        assert!(at("Share of the squared gap") < at("25 %"));
    }

    #[test]
    fn an_effect_has_its_size_and_each_amount_its_deviation() {
        let effect = Named {
            name: "velocity_lag".into(),
            magnitude: vec![Magnitude {
                name: "delay".into(),
                value: 5.0e-5,
                deviation: Some(2.0e-6),
                unit: "s".into(),
            }],
            total_rms_m: Some(3.0e-6),
            total_deviation_m: Some(0.1e-6),
            ..Named::default()
        };
        let told = card(&effect).into_string();
        assert!(told.contains("3.00 ± 0.10 µm rms"), "{told}");
        assert!(told.contains("50.0 ± 2.0 µs"), "{told}");
        assert_eq!(capital("a segment's output"), "A segment's output");
    }
}
