//! What may be told more of the effects that were found: fuller forms, and what of another effect is one's own.

use effects::Card;
use effects::effect::{Form, Subsumption};
use effects::sensor::BasisInputs;

/// A way to tell more of an effect.
pub enum Fuller {
    /// An effect that was found is, with another that was found, one and the same.
    Subsumes(&'static Card, &'static Subsumption, fn(&mut BasisInputs)),
    /// A fuller form of an effect.
    Form(&'static Card, &'static Form),
    /// One that the rules look for by itself as well.
    Searched(&'static Card, fn(&mut BasisInputs)),
}

/// All ways, in the order in which they are tried: first what makes one effect of two, then the fuller forms.
pub fn ways() -> Vec<Fuller> {
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
    subsumptions.chain(forms).chain(searched).collect()
}

impl Fuller {
    /// What is then told, where the effects that were found make it worth trying and it is not told yet.
    pub fn of(&self, found: &[String], inputs: &BasisInputs) -> Option<BasisInputs> {
        let has = |name: &str| found.iter().any(|f| f == name);
        let mut told = inputs.clone();
        match self {
            Self::Subsumes(card, subsumption, tell) => {
                if !has(card.name) || !has(subsumption.other) {
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
