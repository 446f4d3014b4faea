//! The terms that a page uses, each in a sentence or two.

use maud::{Markup, html};

/// A term, the words that show that a page uses it, and what it means.
type Term = (&'static str, &'static [&'static str], &'static str);

/// All terms, in the order in which one needs the other.
const TERMS: &[Term] = &[
    (
        "residual",
        &["residual"],
        "The disagreement between readings that should agree, for one sample: readings of several segments with each other, with the coordination sensor, or with a reference.",
    ),
    (
        "channel",
        &["channel", "g_p", "segment_"],
        "One kind of residual. Each is named below or in the tables.",
    ),
    (
        "g_p (parity)",
        &["g_p"],
        "Both pairs of segments measure the courier's angle. g_p is the difference of the two, as a length (equation 5 of the paper).",
    ),
    (
        "g_x, g_y",
        &["g_x", "g_y"],
        "The difference between where the platen sensor and where the coordination sensor say the courier is, along x and y (equation 11).",
    ),
    (
        "segment_1 to segment_4",
        &["segment_1", "segment_2", "segment_3", "segment_4"],
        "One segment's calibrated reading less the independent reference.",
    ),
    (
        "segment",
        &["segment"],
        "One sine and cosine pair that reads the teeth of the platen. Segments 1 and 3 measure x, 2 and 4 measure y.",
    ),
    (
        "beacon, coordination sensor",
        &["beacon", "coordination sensor", "g_x"],
        "The coordination sensor is a light-sensitive diode on the courier. It sees the direction to a light above the table, the beacon.",
    ),
    (
        "baseline",
        &["baseline"],
        "The calibration without any further effect: equations 3, 5 and 11 of the paper (Quaid and Rizzi, Exploiting Redundancy for Autonomous Calibration of a Planar Robot), fitted to this recording.",
    ),
    (
        "floor",
        &["floor"],
        "The scatter that remains if only the stated noise acts. A simulation repeats the recorded motion with that noise and the calibrated baseline. One times the floor is the best that any model can reach.",
    ),
    (
        "gap, excess",
        &["gap", "excess"],
        "What the recording's residuals have beyond the floor. The excess is the root of the difference of the two squares; it is negative where the recording is the quieter one.",
    ),
    (
        "held out",
        &["held-out", "held out"],
        "Parts of the recording that were left out of a fit and are then predicted by it. All figures here are of such parts, so that a model cannot look good by fitting noise.",
    ),
    (
        "before, after",
        &["before", "after"],
        "Residuals with the baseline alone, and with the named effects added and everything fitted anew.",
    ),
    ("rms", &["rms"], "Root of the mean square."),
    (
        "95 % interval",
        &["95 %"],
        "The range in which the true value lies with that probability, found by drawing blocks of the recording again and again (bootstrap).",
    ),
    (
        "probability",
        &["probability", "probable"],
        "How sure the diagnosis is that this effect is a cause, among all effects of its catalogue and shapes without a name. It says nothing about how large the effect is.",
    ),
    (
        "share",
        &["share"],
        "The part of the squared gap that belongs to an effect or lies over a coordinate. It says nothing about how sure that is. Shares over different coordinates may overlap and need not add up to 100 %.",
    ),
    (
        "own and lateral tooth phase",
        &["tooth phase"],
        "Where a segment stands between two teeth, as a part of a turn: along the direction that it measures (own), and across it (lateral).",
    ),
    (
        "order",
        &["order"],
        "Number of waves that an error makes over one tooth pitch.",
    ),
    (
        "theta",
        &["theta"],
        "The angle of the courier on the platen.",
    ),
    (
        "alias",
        &["alias", "not told apart", "Not told apart"],
        "Effects that do the same on the recorded motion. Another motion can tell them apart.",
    ),
    (
        "resolution",
        &["resolution"],
        "The smallest difference of position that the sensor is meant to show. A gap far below it does not matter in use, however certain it is.",
    ),
    (
        "standard deviation (±)",
        &["±"],
        "How far an amount may be off by chance: about two times in three the true one lies within it. Where more than noise is left, it is enlarged by the Birge ratio: how many times the noise the held-out residuals are.",
    ),
    (
        "seal",
        &["Seal", "seal"],
        "A hash of the answers, printed before the diagnosis begins. It shows that the answers were not changed afterwards.",
    ),
];

/// The terms that occur in a page's text.
fn used(text: &str) -> Vec<&'static Term> {
    let occurs = |term: &&Term| term.1.iter().any(|word| text.contains(word));
    TERMS.iter().filter(occurs).collect()
}

/// The part of a page that explains the terms of the rest of it.
pub fn section(rest: &Markup) -> Markup {
    html! {
        section aria-labelledby="glossary" {
            h2 id="glossary" { "Terms" }
            dl.terms { @for (term, _, meaning) in used(&rest.0) { div { dt { (term) } dd { (meaning) } } } }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn a_page_explains_the_terms_that_it_uses_and_no_others() {
        let told = section(&html! { p { "g_p is at the floor." } }).into_string();
        assert!(
            told.contains("parity") && told.contains("stated noise acts"),
            "{told}"
        );
        assert!(
            !told.contains("alias") && !told.contains("segment_1"),
            "{told}"
        );
    }

    #[test]
    fn every_term_is_told_in_whole_sentences() {
        for (term, words, meaning) in TERMS {
            assert!(
                !term.is_empty() && !words.is_empty() && meaning.ends_with('.'),
                "{term}"
            );
        }
    }
}
