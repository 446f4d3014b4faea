//! A small effect beside a great one. To first order it takes a part of what is left: the places that both are evaluated at are off by
//! the great one, and by its own. So the likeliest are fitted together with what is found, about themselves.

use super::selected::SelectedModel;
use super::{ModelSelection, is_delay};
use crate::design::assembly::{DesignOptions, assemble};
use crate::inference::cross_validation::CrossValidation;
use crate::linearization::point::LinearizationPoint;
use crate::linearization::relinearized::RelinearizedFit;
use crate::selection::core_terms::hollow;
use crate::selection::limits::MINIMUM_SQUARES;
use crate::selection::limits::{COMPLETES, COMPLETES_SQUARES, LEADS, NEARLY_ALL, VISIBLE};
use crate::selection::search::{SearchResult, rest};
use crate::trace::log;
use effects::Card;

/// To first order it takes this share of what is left, and more than chance gives. Fitted together it may take many times as much: rulings
/// askew took 0.22 of what 44 um across the teeth left, and then 0.96.
const TAKES: f64 = 0.15;
/// So many are tried.
const TRIED: usize = 3;
/// True for shapes that stand in for what a great effect's own form lacks: theirs must be nearly all of that to first order, and
/// nothing that shows is left with them.
pub(super) fn absorbs_model_error(name: &str) -> bool {
    effects::has(name, |card| card.absorbs_model_error)
}

/// What is likely to be there besides.
struct Candidate {
    name: String,
    /// It takes more than any shape without a name.
    leads: bool,
    absorbs_model_error: bool,
}

impl<'a> ModelSelection<'a> {
    /// Puts another effect beside what is found where it takes nearly all of what is left. True if one was.
    pub(super) fn try_beside(&mut self) -> bool {
        let found = self.told.names(&self.study);
        let flexible = found.iter().any(|n| effects::has(n, Card::is_flexible));
        if found.is_empty() || flexible || self.noise.is_some() {
            return false;
        }
        let tried = self.likely_beside(&found);
        let (_, noise) = self.levels();
        let excess = |fine: &RelinearizedFit| fine.residuals().white_rms().powi(2) - noise;
        let without = excess(&self.fine);
        let mut best: Option<(f64, Vec<String>, RelinearizedFit<'a>, bool)> = None;
        for Candidate {
            name,
            leads,
            absorbs_model_error,
        } in tried
        {
            let names = [&found[..], &[name]].concat();
            let fine = self.fitted_anew(&names);
            let with = excess(&fine);
            log(&format!(
                "beside: {names:?}, {with:.4} of {without:.4}, leads {leads}"
            ));
            let gain = without - with;
            let least = if leads { LEADS } else { COMPLETES };
            let squares = gain * fine.gram.total_rows() as f64;
            let enough = gain > least * without && squares > COMPLETES_SQUARES;
            let closed = fine.residuals().white_rms() < VISIBLE * noise.sqrt();
            let enough = enough && (closed || !absorbs_model_error);
            if enough && best.as_ref().is_none_or(|b| with < b.0) {
                best = Some((with, names, fine, leads));
            }
        }
        let Some((_, names, fine, leads)) = best else {
            return false;
        };
        self.leads = names.last().filter(|_| leads).cloned();
        self.take_beside(&names, fine);
        true
    }

    /// Those that to first order take most of what is left.
    fn likely_beside(&self, found: &[String]) -> Vec<Candidate> {
        let mut arena = self.study.arena();
        let arena = &mut arena;
        let whole = (arena.score(&[]).squares - self.told.base).max(MINIMUM_SQUARES);
        let blocks = &self.told.found.blocks;
        let before = rest(arena, blocks, self.told.base);
        let beside = |arena: &mut CrossValidation, b: usize| {
            rest(arena, &[&blocks[..], &[b]].concat(), self.told.base)
        };
        let places = self.study.places().into_iter();
        let shape = places
            .map(|b| beside(arena, b))
            .fold(f64::INFINITY, f64::min);
        let mut list: Vec<(f64, usize)> = Vec::new();
        for b in self.study.effects() {
            let name = &self.study.columns.blocks[b].name;
            if found.contains(name)
                || effects::has(name, Card::is_flexible)
                || self.completes_a_delay(name, found)
            {
                continue;
            }
            let takes = if absorbs_model_error(name) {
                NEARLY_ALL
            } else {
                TAKES
            };
            let gain = before - beside(arena, b);
            let likely = gain > takes * before && gain * whole > COMPLETES_SQUARES;
            if likely && !self.replaces(arena, b, before) && !hollow(arena, blocks, b) {
                list.push((before - gain, b));
            }
        }
        list.sort_by(|a, b| a.0.total_cmp(&b.0));
        let name = |b: usize| self.study.columns.blocks[b].name.clone();
        let ranked = list.into_iter().take(TRIED).enumerate();
        ranked
            .map(|(k, (left, b))| Candidate {
                leads: k == 0 && left < shape,
                absorbs_model_error: absorbs_model_error(&name(b)),
                name: name(b),
            })
            .collect()
    }

    /// True if a delay stands beside another that leaves nothing which shows: the one's own form lacks that.
    fn completes_a_delay(&self, name: &str, found: &[String]) -> bool {
        is_delay(name)
            && found.iter().any(|n| is_delay(n))
            && self.ratio() < VISIBLE * self.noise_rms()
    }

    /// True if a block does in the place of one that is found what that does: then it is its rival, and not beside it.
    fn replaces(&self, arena: &mut CrossValidation, block: usize, left: f64) -> bool {
        let found = &self.told.found.blocks;
        found.iter().any(|out| {
            let others = found.iter().copied().filter(|b| b != out);
            let set: Vec<usize> = others.chain([block]).collect();
            rest(arena, &set, self.told.base) < left
        })
    }

    /// Takes over what was fitted together; all is compared about it.
    fn take_beside(&mut self, names: &[String], fine: RelinearizedFit<'a>) {
        let look = DesignOptions {
            as_in: Some(&self.study.scene.inputs),
            ..DesignOptions::default()
        };
        let about = LinearizationPoint {
            noise: self.noise,
            ..fine.about.clone()
        };
        let again = assemble(self.prepared, self.options, &about, look);
        let mut told = SelectedModel::new(&again, false);
        let of_it = |name: &String| again.columns.blocks.iter().position(|b| b.name == *name);
        let blocks: Vec<usize> = names.iter().filter_map(of_it).collect();
        if blocks.iter().all(|b| told.found.blocks.contains(b)) {
            self.take(again, told);
        } else if blocks.len() == names.len() {
            let rest = rest(&mut again.arena(), &blocks, told.base);
            told.found = SearchResult { blocks, rest };
            self.take_fitted(again, told, fine);
        }
    }
}
