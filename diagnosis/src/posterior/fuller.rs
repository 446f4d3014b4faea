//! What may be told more of the effects that were found: fuller forms, and what of another effect is one's own.

use crate::figures::intermodulation::are_the_gaps_own;
use crate::linearization::relinearized::RelinearizedFit;
use effects::Card;
use effects::effect::{Form, KnownBy, Subsumption};
use effects::identity::Identity;
use effects::sensor::BasisInputs;

/// A way to tell more of an effect.
pub enum Fuller {
    /// Harmonics of an effect run over the phase of the unmodified output, as equation (3)'s do, and not over where the courier is: by high orders
    /// the two are a good part of a turn apart.
    Phase(&'static Card),
    /// An effect holds what another would describe, whether that was found beside it or not.
    Subsumes(&'static Card, &'static Subsumption, fn(&mut BasisInputs)),
    /// A fuller form of an effect.
    Form(&'static Card, &'static Form),
    /// What is looked for once the effect was found.
    Searched(&'static Card, fn(&mut BasisInputs)),
}

/// All ways, in the order in which they are tried: first the phase that harmonics run over, since what they lack over the wrong one others
/// describe, then what makes one effect of two, then the fuller forms.
pub fn ways() -> Vec<Fuller> {
    let phases = effects::cards().filter(|card| card.either_phase);
    let phases = phases.map(Fuller::Phase);
    let subsumptions = effects::cards().flat_map(|card| {
        let each = card.subsumes.iter();
        each.flat_map(move |s| {
            s.tell
                .iter()
                .map(move |tell| Fuller::Subsumes(card, s, *tell))
        })
    });
    let mut forms: Vec<(&Card, &Form)> = effects::cards()
        .flat_map(|card| card.forms.iter().map(move |form| (card, form)))
        .collect();
    forms.sort_by_key(|(card, _)| card.follows);
    let forms = forms
        .into_iter()
        .map(|(card, form)| Fuller::Form(card, form));
    let searched = effects::cards().filter_map(|card| Some(Fuller::Searched(card, card.searched?)));
    let each = phases.chain(subsumptions).chain(forms).chain(searched);
    each.collect()
}

impl Fuller {
    /// What is then told, where the effects that were found make it worth trying and it is not told yet.
    pub fn of(&self, found: &[String], inputs: &BasisInputs) -> Option<BasisInputs> {
        let has = |name: &str| found.iter().any(|f| f == name);
        let mut told = inputs.clone();
        match self {
            Self::Phase(card) => {
                if !has(card.name) {
                    return None;
                }
                told.unmodified = true;
            }
            Self::Subsumes(card, _, tell) => {
                if !has(card.name) {
                    return None;
                }
                tell(&mut told);
            }
            Self::Form(card, form) => {
                if !has(form.found_as.unwrap_or(card.name)) {
                    return None;
                }
                (form.tell)(&mut told.forms);
            }
            Self::Searched(card, tell) => {
                if !has(card.name) {
                    return None;
                }
                tell(&mut told);
            }
        }
        (told != *inputs).then_some(told)
    }

    /// What is told, for a trace.
    pub fn tells(&self) -> String {
        match self {
            Self::Phase(card) => format!("{}: the other phase", card.name),
            Self::Subsumes(card, subsumption, _) => {
                format!("{}: what {} would describe", card.name, subsumption.other)
            }
            Self::Form(card, form) => format!("{}: {}", card.name, form.tells),
            Self::Searched(card, _) => format!("{}: what is searched for by itself", card.name),
        }
    }

    /// True if what was found without it and with it, each fitted about itself, is of amounts that there may be.
    pub fn may_be<'a>(
        &self,
        without: impl FnOnce() -> RelinearizedFit<'a>,
        with: impl FnOnce() -> RelinearizedFit<'a>,
    ) -> bool {
        match self {
            Self::Subsumes(card, subsumption, _) => match subsumption.known_by {
                KnownBy::Growth { within_k } => is_growth(&with(), within_k),
                KnownBy::MixedHarmonics => {
                    let without = without();
                    let is_other = |name: &String| name == subsumption.other;
                    let beside = without.hypothesis.effects.iter().any(is_other);
                    !beside || are_the_gaps_own(&without, card.name, subsumption.other)
                }
                KnownBy::Fit => true,
            },
            Self::Phase(_) | Self::Form(..) | Self::Searched(..) => true,
        }
    }
}

/// True if each ruling's pitch at the mean temperature is what its growth makes of a temperature at which it is right.
pub(crate) fn is_growth(fit: &RelinearizedFit, within_k: f64) -> bool {
    let amount = |identity: Identity| {
        let mut all = fit.columns.regressors.iter();
        let column = all.position(|r| r.identity == Some(identity));
        column.map_or(0.0, |c| fit.coefficient(c))
    };
    (0..2).all(|axis| {
        let slope = amount(Identity::Growth { axis });
        let there = amount(Identity::GrowthAtMean { axis });
        there == 0.0 || (there / slope).abs() <= within_k
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    /// Nothing is tried of what was not found, and nothing twice.
    #[test]
    fn only_what_was_found_is_told_more_of() {
        let inputs = BasisInputs::default();
        for way in ways() {
            assert!(way.of(&[], &inputs).is_none());
            let names: Vec<String> = match way {
                Fuller::Phase(card) => vec![card.name.into()],
                Fuller::Subsumes(card, s, _) => vec![card.name.into(), s.other.into()],
                Fuller::Form(card, form) => vec![form.found_as.unwrap_or(card.name).into()],
                Fuller::Searched(card, _) => vec![card.name.into()],
            };
            let told = way.of(&names, &inputs);
            let told = told.unwrap_or_else(|| panic!("{names:?} tell nothing"));
            assert!(way.of(&names, &told).is_none(), "{names:?} twice");
        }
    }
}
