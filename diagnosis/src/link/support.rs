//! What speaks for a named effect.

use crate::verdict::answer::{Diagnosis, Named};
use effects::Card;

/// What speaks for a named effect, in numbers that a link takes.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Support {
    /// 1 for a flexible shape, as free harmonics are, which stands in for many things; 0 for others.
    pub shape: f64,
    /// 1 for what is measured and not fitted: slips, bursts and noise. Their odds say nothing.
    pub measured: f64,
    /// Logarithm of the posterior's odds that it acts, or one of those that it stands for, between 0 and `MOST_LN_ODDS`; 0 for what is
    /// measured.
    pub ln_odds: f64,
    /// Logarithm of what it does beyond the others, rms over the floor, between the logarithms of `FLOORS`.
    pub ln_floors: f64,
    /// Logarithm of 1 and what nothing named explains, rms over the floor, at most that of 1 and the larger of `FLOORS`.
    pub ln_left: f64,
    /// Other effects that are named with it, at most `MOST_BESIDE`.
    pub beside: f64,
}

/// Odds beyond so many are as good as none. A prior: exp(-7) is a thousandth, beyond what some hundred couriers can tell.
pub const MOST_LN_ODDS: f64 = 7.0;
/// Rms over the floor between which a size matters. A prior: a tenth of the floor is the least effect that is named, and an
/// effect of ten floors is half the tooth variation of the paper's platen again.
pub const FLOORS: [f64; 2] = [0.1, 10.0];
/// A prior: the checks have at most three effects, and so two beside one.
pub const MOST_BESIDE: f64 = 2.0;
/// Standard deviation of what a term may do to the log odds over its whole range. A prior: a factor of 7 in the odds, weak beside
/// some ten causes.
const OVER_ITS_RANGE: f64 = 2.0;
/// Standard deviation of the log odds of an effect that nothing else is known of. A prior: as good as flat, since odds of e^10
/// are none that a hundred couriers tell.
const BEFORE: f64 = 10.0;

/// Which sign a coefficient may have.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Sign {
    Any,
    Positive,
    Negative,
}

/// One term of a link.
#[derive(Clone, Copy, Debug)]
pub(super) struct Term {
    /// As it is called in the files.
    pub(super) name: &'static str,
    pub(super) sign: Sign,
    /// Standard deviation of its coefficient before any data.
    pub(super) prior: f64,
}

/// In the order of [`Support::terms`].
pub(super) const TERMS: [Term; 7] = [
    term("always", Sign::Any, BEFORE),
    term("shape", Sign::Any, OVER_ITS_RANGE),
    term("measured", Sign::Any, OVER_ITS_RANGE),
    term("ln_odds", Sign::Positive, OVER_ITS_RANGE / MOST_LN_ODDS),
    // ln 100 and ln 11.
    term("ln_floors", Sign::Positive, OVER_ITS_RANGE / 4.605),
    term("ln_left", Sign::Negative, OVER_ITS_RANGE / 2.398),
    term("beside", Sign::Negative, OVER_ITS_RANGE / MOST_BESIDE),
];

const fn term(name: &'static str, sign: Sign, prior: f64) -> Term {
    Term { name, sign, prior }
}

impl Support {
    /// Of one of the effects that an answer names.
    #[must_use]
    pub fn of(effect: &Named, answer: &Diagnosis) -> Self {
        let whole = (answer.held_out.whitened_before.powi(2) - 1.0).max(0.0);
        let taken_out = effects::has(&effect.name, |card| card.detection.is_taken_out());
        let floors = if taken_out {
            effect.total_rms_m.unwrap_or(0.0) / floor_m(answer)
        } else {
            (effect.share * whole).sqrt()
        };
        let measured = !effects::has(&effect.name, |card| card.detection.is_fitted());
        let [least, most] = FLOORS;
        let left = (answer.unexplained.share * whole).sqrt();
        Self {
            shape: f64::from(u8::from(effects::has(&effect.name, Card::is_shape))),
            measured: f64::from(u8::from(measured)),
            ln_odds: if measured {
                0.0
            } else {
                effect.odds.ln_posterior.clamp(0.0, MOST_LN_ODDS)
            },
            ln_floors: floors.clamp(least, most).ln(),
            ln_left: left.min(most).ln_1p(),
            beside: (answer.effects.len().saturating_sub(1) as f64).min(MOST_BESIDE),
        }
    }

    /// What a link's coefficients are multiplied with.
    #[must_use]
    pub fn terms(&self) -> [f64; TERMS.len()] {
        [
            1.0,
            self.shape,
            self.measured,
            self.ln_odds,
            self.ln_floors,
            self.ln_left,
            self.beside,
        ]
    }

    /// Header of a table of causes: after what is told of each come its terms, and 1 if it acts.
    #[must_use]
    pub fn header() -> String {
        let terms = TERMS.iter().skip(1).map(|term| term.name);
        terms.chain(["true"]).collect::<Vec<_>>().join(",")
    }

    /// Its cells of such a table.
    #[must_use]
    pub fn cells(&self, is_true: bool) -> String {
        let terms = self.terms();
        let cells = terms.iter().skip(1).map(|x| format!("{x:.3}"));
        let last = u8::from(is_true).to_string();
        cells.chain([last]).collect::<Vec<_>>().join(",")
    }

    /// The causes of such a table, and whether each acts. Lines that begin with `#` are comments.
    ///
    /// # Errors
    /// The line that is none.
    pub fn cases(text: &str) -> Result<Vec<(Self, bool)>, String> {
        let lines = text.lines().filter(|line| !line.starts_with('#'));
        let rows = lines.filter(|line| !line.ends_with(&Self::header()));
        rows.map(|line| Self::case(line).ok_or_else(|| format!("found {line:?}, wanted a cause")))
            .collect()
    }

    fn case(line: &str) -> Option<(Self, bool)> {
        let cells: Vec<&str> = line.split(',').collect();
        let first = cells.len().checked_sub(TERMS.len())?;
        let numbers: Option<Vec<f64>> = cells[first..].iter().map(|c| c.parse().ok()).collect();
        let [
            shape,
            measured,
            ln_odds,
            ln_floors,
            ln_left,
            beside,
            is_true,
        ] = numbers?[..]
        else {
            return None;
        };
        let support = Self {
            shape,
            measured,
            ln_odds,
            ln_floors,
            ln_left,
            beside,
        };
        Some((support, is_true == 1.0))
    }
}

/// Floor of the channels, rms, m.
fn floor_m(answer: &Diagnosis) -> f64 {
    let floors = answer.held_out.channels.iter().map(|c| c.floor_rms_m);
    crate::algebra::statistics::rms(floors).max(f64::MIN_POSITIVE)
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::verdict::answer::{HeldOut, HeldOutChannel, Unexplained};
    use crate::verdict::odds::Odds;

    /// An answer of two floors above the noise that names these, with a tenth of it left.
    fn answer(effects: Vec<Named>) -> Diagnosis {
        Diagnosis {
            effects,
            held_out: HeldOut {
                whitened_before: 5.0_f64.sqrt(),
                channels: vec![HeldOutChannel {
                    floor_rms_m: 1.0e-6,
                    ..HeldOutChannel::default()
                }],
                ..HeldOut::default()
            },
            unexplained: Unexplained {
                share: 0.1,
                ..Unexplained::default()
            },
            ..Diagnosis::default()
        }
    }

    fn named(name: &str, share: f64) -> Named {
        Named {
            name: name.into(),
            share,
            odds: Odds {
                ln_posterior: 3.0,
                unlisted: 0.0,
            },
            ..Named::default()
        }
    }

    #[test]
    fn what_speaks_for_an_effect_is_told_in_bounds() {
        let of = |share| {
            let answer = answer(vec![named("velocity_lag", share)]);
            Support::of(&answer.effects[0], &answer)
        };
        assert_eq!(of(0.25).ln_odds, 3.0);
        // A quarter of 4 squared floors; a tenth of it.
        assert!(of(0.25).ln_floors.abs() < 1e-12);
        assert!((of(0.25).ln_left - 0.4_f64.sqrt().ln_1p()).abs() < 1e-12);
        assert_eq!(of(0.0).ln_floors, FLOORS[0].ln());
    }

    #[test]
    fn a_table_of_causes_is_read_as_it_was_written() {
        let answer = answer(vec![named("velocity_lag", 0.3)]);
        let support = Support::of(&answer.effects[0], &answer);
        let row = |told: &str, is_true| format!("{told},{}", support.cells(is_true));
        let text = format!(
            "# a comment\nname,{}\n{}\n{}",
            Support::header(),
            row("a", true),
            row("b", false)
        );
        let cases = Support::cases(&text).unwrap();
        assert_eq!([cases[0].1, cases[1].1], [true, false]);
        for (kept, now) in cases[0].0.terms().iter().zip(support.terms()) {
            assert!((kept - now).abs() <= 0.0005, "{kept} {now}");
        }
        assert!(Support::cases("a,1,x").unwrap_err().contains("a,1,x"));
    }

    #[test]
    fn what_is_measured_has_no_odds() {
        let slip = Named {
            total_rms_m: Some(3.0e-6),
            ..named("cycle_slip", 1.0)
        };
        let answer = answer(vec![slip, named("extra_harmonics", 0.0)]);
        let [slip, shape] = [0, 1].map(|k| Support::of(&answer.effects[k], &answer));
        assert_eq!((slip.measured, slip.ln_odds, slip.beside), (1.0, 0.0, 1.0));
        assert!((slip.ln_floors - 3.0_f64.ln()).abs() < 1e-12);
        assert_eq!((shape.shape, shape.ln_floors), (1.0, FLOORS[0].ln()));
    }
}
