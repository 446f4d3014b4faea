//! Which phase free harmonics run over: the calibrated one, or that of the unmodified output.

use super::ModelSelection;
use super::selected::SelectedModel;
use crate::design::assembly::{Design, DesignOptions, assemble};
use crate::inference::residuals::Residuals;
use crate::linearization::relinearized::RelinearizedFit;
use crate::selection::limits::{
    CLOSE_RATIO, OTHER_PHASE_LEAVES, OTHER_PHASE_TAKES, UNEXPLAINED_SHARE, VISIBLE_GAP_RATIO,
};

/// Names of the effects whose harmonics run over either phase of the own tooth.
fn of_either_phase() -> Vec<String> {
    let cards = effects::cards().filter(|card| card.either_phase);
    cards.map(|card| card.name.into()).collect()
}

impl ModelSelection<'_> {
    /// Free harmonics may run over the calibrated phase, where the courier is, or over the unmodified output's, as equation (3)
    /// does: by high orders the two are a good part of a turn apart. That which leaves less is kept, for all of them.
    pub(super) fn choose_phase(&mut self) {
        let found = self.selected.names(&self.design);
        let harmonic = found
            .iter()
            .any(|name| effects::has(name, |card| card.either_phase));
        // What is found beside harmonics may stand in for what they lack over the wrong phase.
        let alone = found.len() == 1;
        let closed = self.ratio()
            < if harmonic {
                CLOSE_RATIO
            } else {
                VISIBLE_GAP_RATIO
            }
            && (alone || !harmonic);
        if closed || !harmonic && self.selected.found.unexplained_fraction < UNEXPLAINED_SHARE {
            return;
        }
        let mut inputs = self.design.linearized.inputs.clone();
        inputs.unmodified = true;
        let mut list = found;
        list.extend(of_either_phase());
        let mut design_options = DesignOptions {
            previous_inputs: Some(&inputs),
            only: Some(&list),
            ..DesignOptions::default()
        };
        let point = self.prepared.point();
        let harmonics = assemble(self.prepared, self.options, &point, design_options);
        if !self.less_is_left_in(&harmonics) {
            return;
        }
        design_options.only = None;
        let again = assemble(self.prepared, self.options, &point, design_options);
        let selected = SelectedModel::new(&again, false);
        let relinearized = RelinearizedFit::of(&again, &selected);
        let excess = |r: &Residuals| r.white_rms().powi(2) - self.floor.white_square;
        if excess(relinearized.residuals())
            < OTHER_PHASE_LEAVES * excess(self.relinearized.residuals())
        {
            self.accept_fit(again, selected, relinearized);
        }
    }

    /// True if harmonics leave less in another design than in this one, by themselves or beside what is found.
    fn less_is_left_in(&self, other: &Design) -> bool {
        let known = self.selected.names(&self.design);
        let left = |design: &Design, names: &[String]| {
            let of_these = |b: &usize| names.contains(&design.columns.blocks[*b].name);
            let blocks: Vec<usize> = design.effects().into_iter().filter(of_these).collect();
            let mut validation = design.cross_validation();
            validation.score(&blocks).squares - validation.rows() * design.floor.white_square
        };
        of_either_phase().iter().any(|name| {
            let alone = vec![name.clone()];
            let beside = [&known[..], &alone].concat();
            [alone, beside].iter().any(|names| {
                let [here, there] = [&self.design, other].map(|s| left(s, names));
                crate::trace::log(&format!(
                    "{names:?} leave {here:.0}, over the other phase {there:.0}"
                ));
                // What is of no physical size leaves no end.
                there < here - OTHER_PHASE_TAKES * here.abs()
                    || here.is_infinite() && there.is_finite()
            })
        })
    }
}
