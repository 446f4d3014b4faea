//! A small effect beside a great one. To first order it takes a part of what is left: the places that both are evaluated at are off by
//! the great one, and by its own. So the likeliest are fitted together with what is found, about themselves.

use super::selected::SelectedModel;
use super::{ModelSelection, is_delay};
use crate::design::assembly::{DesignOptions, assemble};
use crate::inference::cross_validation::CrossValidation;
use crate::linearization::point::LinearizationPoint;
use crate::linearization::relinearized::RelinearizedFit;
use crate::selection::core_terms::lacks_core_terms;
use crate::selection::limits::MINIMUM_SQUARES;
use crate::selection::limits::{
    COMPLETING_SHARE, COMPLETING_SQUARES, LARGELY_COMPLETES, LEADING_SHARE, VISIBLE_GAP_RATIO,
};
use crate::selection::search::SearchResult;
use crate::selection::worth::unexplained_fraction;
use crate::trace::log;
use effects::Card;

/// To first order it takes this share of what is left, and more than chance gives. Fitted together it may take many times as much: rulings
/// askew took 0.22 of what 44 um across the teeth left, and then 0.96.
const FIRST_ORDER_SHARE: f64 = 0.15;
/// So many are tried. A bound on the work: a fourth to first order is not fitted together with the first.
const TRIED_CANDIDATES: usize = 3;
/// True for shapes that stand in for what a great effect's own form lacks: theirs must be nearly all of that to first order, and
/// nothing that shows is left with them.
pub(super) fn absorbs_model_error(name: &str) -> bool {
    effects::has(name, |card| card.absorbs_model_error)
}

/// What is likely to be there besides.
struct Candidate {
    name: String,
    /// It takes more than any shape without a name.
    leading_effect: bool,
    absorbs_model_error: bool,
}

impl<'a> ModelSelection<'a> {
    /// Puts another effect beside what is found where it takes nearly all of what is left. True if one was.
    pub(super) fn try_second_effect(&mut self) -> bool {
        let found = self.selected.names(&self.design);
        let flexible = found.iter().any(|n| effects::has(n, Card::is_flexible));
        if found.is_empty() || flexible || self.noise.is_some() {
            return false;
        }
        let tried = self.candidates_beside(&found);
        let (_, noise) = self.levels();
        let excess =
            |relinearized: &RelinearizedFit| relinearized.residuals().white_rms().powi(2) - noise;
        let without = excess(&self.relinearized);
        let mut best: Option<(f64, Vec<String>, RelinearizedFit<'a>, bool)> = None;
        for Candidate {
            name,
            leading_effect,
            absorbs_model_error,
        } in tried
        {
            let names = [&found[..], &[name]].concat();
            let relinearized = self.refitted(&names);
            let with = excess(&relinearized);
            log(&format!(
                "beside: {names:?}, {with:.4} of {without:.4}, leads {leading_effect}"
            ));
            let gain = without - with;
            let least = if leading_effect {
                LEADING_SHARE
            } else {
                COMPLETING_SHARE
            };
            let squares = gain * relinearized.gram.total_rows() as f64;
            let enough = gain > least * without && squares > COMPLETING_SQUARES;
            let closed = relinearized.residuals().white_rms() < VISIBLE_GAP_RATIO * noise.sqrt();
            let enough = enough && (closed || !absorbs_model_error);
            if enough && best.as_ref().is_none_or(|b| with < b.0) {
                best = Some((with, names, relinearized, leading_effect));
            }
        }
        let Some((_, names, relinearized, leading_effect)) = best else {
            return false;
        };
        self.leading_effect = names.last().filter(|_| leading_effect).cloned();
        self.accept_second_effect(&names, relinearized);
        true
    }

    /// Those that to first order take most of what is left.
    fn candidates_beside(&self, found: &[String]) -> Vec<Candidate> {
        let mut validation = self.design.cross_validation();
        let validation = &mut validation;
        let whole_gap = (validation.score(&[]).squares - self.selected.base).max(MINIMUM_SQUARES);
        let blocks = &self.selected.found.blocks;
        let before = unexplained_fraction(validation, blocks, self.selected.base);
        let beside = |validation: &mut CrossValidation, b: usize| {
            unexplained_fraction(
                validation,
                &[&blocks[..], &[b]].concat(),
                self.selected.base,
            )
        };
        let coordinate_blocks = self.design.coordinate_blocks().into_iter();
        let shape = coordinate_blocks
            .map(|b| beside(validation, b))
            .fold(f64::INFINITY, f64::min);
        let mut list: Vec<(f64, usize)> = Vec::new();
        for b in self.design.effects() {
            let name = &self.design.columns.blocks[b].name;
            if found.contains(name)
                || effects::has(name, Card::is_flexible)
                || self.completes_a_delay(name, found)
            {
                continue;
            }
            let takes = if absorbs_model_error(name) {
                LARGELY_COMPLETES
            } else {
                FIRST_ORDER_SHARE
            };
            let gain = before - beside(validation, b);
            let likely = gain > takes * before && gain * whole_gap > COMPLETING_SQUARES;
            if likely
                && !self.replaces(validation, b, before)
                && !lacks_core_terms(validation, blocks, b)
            {
                list.push((before - gain, b));
            }
        }
        list.sort_by(|a, b| a.0.total_cmp(&b.0));
        let name = |b: usize| self.design.columns.blocks[b].name.clone();
        let ranked = list.into_iter().take(TRIED_CANDIDATES).enumerate();
        ranked
            .map(|(k, (left, b))| Candidate {
                leading_effect: k == 0 && left < shape,
                absorbs_model_error: absorbs_model_error(&name(b)),
                name: name(b),
            })
            .collect()
    }

    /// True if a delay stands beside another that leaves nothing which shows: the one's own form lacks that.
    fn completes_a_delay(&self, name: &str, found: &[String]) -> bool {
        is_delay(name)
            && found.iter().any(|n| is_delay(n))
            && self.ratio() < VISIBLE_GAP_RATIO * self.noise_rms()
    }

    /// True if a block does in the place of one that is found what that does: then it is its rival, and not beside it.
    fn replaces(&self, validation: &mut CrossValidation, block: usize, left: f64) -> bool {
        let found = &self.selected.found.blocks;
        found.iter().any(|out| {
            let others = found.iter().copied().filter(|b| b != out);
            let set: Vec<usize> = others.chain([block]).collect();
            unexplained_fraction(validation, &set, self.selected.base) < left
        })
    }

    /// Takes over what was fitted together; all is compared about it.
    fn accept_second_effect(&mut self, names: &[String], relinearized: RelinearizedFit<'a>) {
        let design_options = DesignOptions {
            previous_inputs: Some(&self.design.linearized.inputs),
            ..DesignOptions::default()
        };
        let point = LinearizationPoint {
            noise: self.noise,
            ..relinearized.point.clone()
        };
        let again = assemble(self.prepared, self.options, &point, design_options);
        let mut selected = SelectedModel::new(&again, false);
        let of_it = |name: &String| again.columns.blocks.iter().position(|b| b.name == *name);
        let blocks: Vec<usize> = names.iter().filter_map(of_it).collect();
        if blocks.iter().all(|b| selected.found.blocks.contains(b)) {
            self.accept(again, selected);
        } else if blocks.len() == names.len() {
            let unexplained_fraction =
                unexplained_fraction(&mut again.cross_validation(), &blocks, selected.base);
            selected.found = SearchResult {
                blocks,
                unexplained_fraction,
            };
            self.accept_fit(again, selected, relinearized);
        }
    }
}
