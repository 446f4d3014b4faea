//! The named effects: how sure, how large, how much of the gap.

use super::svg::short;
use super::table::{self, table};
use crate::advice::{percent, sentence};
use crate::report::{Diagnosis, Magnitude, Named};
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
            h3 { code { (effect.name) } }
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
    let row = |m: &Magnitude| {
        let (value, unit) = readable(m.value, &m.unit);
        vec![m.name.clone(), short(value), unit]
    };
    let rows: Vec<Vec<String>> = list.iter().map(row).collect();
    html! { details { summary { "How large: " (list.len()) " amounts" } (table(&table::header(["amount", "value", "unit"]), &rows)) } }
}

/// A value in the unit that a reader would use: micrometres for lengths, microseconds for delays, milliradians for angles.
fn readable(value: f64, unit: &str) -> (f64, String) {
    let (factor, readable) = match unit {
        "m" => (1.0e6, "µm"),
        "s" => (1.0e6, "µs"),
        "rad" => (1.0e3, "mrad"),
        "m/rad" => (1.0e3, "µm/mrad"),
        "m/rad²" => (1.0, "µm/mrad²"),
        "m/K" => (1.0e6, "µm/K"),
        "1/K" => (1.0e6, "ppm/K"),
        "1" | "" => (1.0e2, "%"),
        other => (1.0, other),
    };
    (value * factor, readable.into())
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
    fn amounts_are_told_in_units_that_are_read() {
        assert_eq!(readable(2.0e-6, "m"), (2.0, "µm".into()));
        assert_eq!(readable(0.5, "furlongs"), (0.5, "furlongs".into()));
        assert_eq!(capital("a segment's output"), "A segment's output");
    }
}
