//! The head of the report: how large the gap is, how much of it is explained, whether it matters, and the few numbers behind it.

use super::svg::times;
use crate::advice::percent;
use crate::headline::{Headline, Tone};
use crate::units::micrometres;
use diagnosis::verdict::answer::{Diagnosis, Verdict};
use diagnosis::verdict::evidence::Evidence;
use maud::{Markup, html};

/// The verdict, the headline, the numbers, and what must be said besides.
pub fn section(diagnosis: &Diagnosis, evidence: &Evidence, headline: &Headline) -> Markup {
    // Where the data are insufficient, the headline is the first note.
    let told = usize::from(diagnosis.verdict == Verdict::InsufficientData);
    html! {
        header {
            p.over { "Diagnosis of " code { (diagnosis.recording) } }
            h1 { span class={ "pill " (tone(diagnosis.verdict, headline)) } { (verdict(diagnosis.verdict)) } " " (headline.text) }
            (facts(diagnosis, evidence, headline))
            @for note in diagnosis.notes.iter().skip(told) { p.note { (note) } }
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

/// Colour of the verdict. A gap without a name that is too small to matter is no success and no alarm.
fn tone(verdict: Verdict, headline: &Headline) -> &'static str {
    match (headline.tone, verdict) {
        (Tone::Good, Verdict::Unknown) => "calm",
        (Tone::Good, _) => "good",
        (Tone::Doubtful, _) => "warn",
        (Tone::Bad, _) => "bad",
    }
}

fn facts(diagnosis: &Diagnosis, evidence: &Evidence, headline: &Headline) -> Markup {
    let held = &diagnosis.held_out;
    let gap = !matches!(
        diagnosis.verdict,
        Verdict::NoGap | Verdict::InsufficientData
    );
    let floors = |value: f64| format!("{} × floor", times(value));
    html! {
        dl.facts {
            @if !held.channels.is_empty() {
                @if gap {
                    (fact(&format!("gap in {}, rms", headline.channel), &micrometres(headline.gap_m)))
                    (fact("resolution", &micrometres(headline.resolution_m)))
                }
                @if !diagnosis.effects.is_empty() {
                    (fact("of the squared gap explained", &explained(headline.explained)))
                    (fact("residual before", &floors(held.whitened_before)))
                    (fact("residual after", &floors(held.whitened_after)))
                } @else {
                    (fact("residual", &floors(held.whitened_before)))
                }
            }
            @if evidence.samples > 0 { (fact("samples", &evidence.samples.to_string())) }
            @if evidence.set_aside > 0 { (fact("disturbed or resting, set aside", &evidence.set_aside.to_string())) }
        }
    }
}

/// A share that is not rounded up to all of it.
fn explained(share: f64) -> String {
    if share > 0.999 {
        percent(1.0)
    } else {
        percent((100.0 * share).floor() / 100.0)
    }
}

fn fact(name: &str, value: &str) -> Markup {
    html! { div { dt { (name) } dd { (value) } } }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::headline::headline;
    use diagnosis::verdict::answer::{HeldOut, HeldOutChannel};

    /// An answer with a gap and a rest over a floor of 0.1 µm, and its colour.
    fn coloured(verdict: Verdict, gap_m: f64, left_m: f64) -> &'static str {
        let floor_rms_m = 0.1e-6;
        let [before_rms_m, after_rms_m] = [gap_m, left_m].map(|m: f64| m.hypot(floor_rms_m));
        let channel = HeldOutChannel {
            channel: "g_p".into(),
            before_rms_m,
            after_rms_m,
            floor_rms_m,
            ..HeldOutChannel::default()
        };
        let diagnosis = Diagnosis {
            verdict,
            held_out: HeldOut {
                whitened_before: before_rms_m / floor_rms_m,
                whitened_after: after_rms_m / floor_rms_m,
                channels: vec![channel],
            },
            ..Diagnosis::default()
        };
        tone(verdict, &headline(&diagnosis, 0.2e-6))
    }

    #[test]
    fn half_a_nanometre_is_no_alarm_and_sixty_nine_floors_are_no_success() {
        assert_eq!(coloured(Verdict::Unknown, 0.5e-9, 0.5e-9), "calm");
        assert_eq!(coloured(Verdict::Unknown, 5.0e-6, 5.0e-6), "bad");
        assert_eq!(coloured(Verdict::Named, 90.0e-6, 6.9e-6), "bad");
        assert_eq!(coloured(Verdict::Named, 3.0e-6, 0.0), "good");
        assert_eq!(coloured(Verdict::Alias, 3.0e-6, 0.0), "warn");
    }

    #[test]
    fn nearly_all_is_not_all() {
        assert_eq!(explained(0.997), "99 %");
        assert_eq!(explained(0.9995), "100 %");
    }
}
