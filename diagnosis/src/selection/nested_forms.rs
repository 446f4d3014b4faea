//! Effects that are told by few unknowns as long as these leave no gap. Where they do, more of what each may be is told, and kept if it
//! leaves much less.

use super::ModelSelection;
use super::selected::SelectedModel;
use crate::design::assembly::{DesignOptions, assemble};
use crate::linearization::relinearized::RelinearizedFit;
use crate::selection::limits::{CLOSE_RATIO, EXPLAINS_LITTLE_ABOVE, TRUSTED_BELOW};
use crate::trace::log;
use effects::Card;
use effects::effect::{Cost, Form};
use effects::sensor::BasisInputs;

/// More of an effect is worth its unknowns if less than this share of the gap is left.
const FORM_LEAVES: f64 = 0.7;
/// The same of a few more that follow nothing but the temperature.
const FEW_TERMS_LEAVE: f64 = 0.9;

/// The same of one effect in the place of two: no more than these leave, give or take what two of many fits differ by.
const ONE_FOR_TWO_RATIO: f64 = 1.1;

/// Standard deviations of a mean square that chance takes it by. Derived from the normal tail: once in 32,000 on one side.
const CHANCE_DEVIATIONS: f64 = 4.0;

/// Fuller forms in the order in which they are tried, each with the effect that it is of.
fn forms() -> Vec<(&'static Card, &'static Form)> {
    let all = effects::cards().flat_map(|card| card.forms.iter().map(move |form| (card, form)));
    let mut list: Vec<_> = all.collect();
    list.sort_by_key(|(card, _)| card.follows);
    list
}

/// Share of the gap that what is found may leave: where it leaves more, what is told more of may not be what there is.
fn beside(form: &Form) -> f64 {
    if form.far_from_it {
        EXPLAINS_LITTLE_ABOVE
    } else {
        TRUSTED_BELOW
    }
}

/// Share of what is left that a form must leave.
fn must_leave(form: &Form) -> f64 {
    match form.cost {
        Cost::Many => FORM_LEAVES,
        Cost::Few => FEW_TERMS_LEAVE,
        Cost::OneForTwo => ONE_FOR_TWO_RATIO,
    }
}

impl ModelSelection<'_> {
    /// Compares all anew with more told of what is found, and keeps that where it leaves less: where most of the gap is its own.
    pub(super) fn extend_forms(&mut self) {
        for (card, form) in forms() {
            let found = self.selected.names(&self.design);
            let shows = self.ratio() >= CLOSE_RATIO
                && self.selected.found.unexplained_fraction < beside(form);
            let has = |name: &str| found.iter().any(|n| n == name);
            let found_as = form.found_as.unwrap_or(card.name);
            let may = form.found_as.is_none() || self.allowed(card.name) && !has(card.name);
            let complete = form.completed_by.is_none_or(has);
            if shows && may && has(found_as) && complete {
                self.extend_form(card, form, &found);
            }
        }
    }

    fn extend_form(&mut self, card: &Card, form: &Form, found: &[String]) {
        let (_, noise) = self.levels();
        let excess =
            |relinearized: &RelinearizedFit| relinearized.residuals().white_rms().powi(2) - noise;
        let left = excess(&self.relinearized);
        let told_as = |name: &String| {
            if Some(name.as_str()) == form.found_as {
                card.name.into()
            } else {
                name.clone()
            }
        };
        let of_itself = |name: &&String| form.completed_by != Some(name.as_str());
        let names: Vec<String> = found.iter().filter(of_itself).map(told_as).collect();
        let forms = self.fitted_with_forms(&names, &|inputs: &mut BasisInputs| {
            (form.tell)(&mut inputs.forms)
        });
        let leaves = excess(&forms);
        log(&format!(
            "{} told more fully leaves {leaves:.4} of {left:.4}",
            card.name
        ));
        // Less than the noise: at angles or ways that are seldom gone through, amounts run up until the slope of a reading takes its noise in.
        let least = -CHANCE_DEVIATIONS * (2.0 / forms.gram.total_rows() as f64).sqrt();
        let cost = |excess: f64| (least..must_leave(form) * left).contains(&excess);
        if !cost(leaves) {
            return;
        }
        let mut inputs = self.design.linearized.inputs.clone();
        (form.tell)(&mut inputs.forms);
        let design_options = DesignOptions {
            previous_inputs: Some(&inputs),
            ..DesignOptions::default()
        };
        let again = assemble(self.prepared, self.options, &forms.point, design_options);
        let selected = SelectedModel::new(&again, self.noise.is_some());
        let relinearized = RelinearizedFit::of(&again, &selected);
        if cost(excess(&relinearized)) {
            self.accept_fit(again, selected, relinearized);
        }
    }
}
