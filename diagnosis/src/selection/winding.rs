//! Rulings that are askew and wind besides. The shapes of a winding are many, and two amounts tell a skew from a diode's misalignment
//! by their number: they are asked for where without them a gap is left or another effect stands beside the skew, and kept where they
//! take most of the one or do as well as the other.

use super::ModelSelection;
use super::selected::SelectedModel;
use super::verdict::of_no_size;
use crate::design::assembly::{Design, DesignOptions, assemble};
use crate::linearization::point::LinearizationPoint;
use crate::linearization::relinearized::RelinearizedFit;
use crate::selection::limits::MINIMUM_SQUARES;
use crate::selection::limits::VISIBLE_GAP_RATIO;
use crate::trace::log;
use effects::sensor::BasisInputs;

/// Winding lines are worth their unknowns if they leave less than this share of what was left.
const WINDING_LEAVES: f64 = 0.5;

impl<'a> ModelSelection<'a> {
    /// Looks for such fuller forms where a gap is left, or where others may stand in for them.
    pub(super) fn try_winding(&mut self) {
        for card in effects::cards() {
            if let Some(tell) = card.searched {
                self.try_searched(card.name, tell);
            }
        }
    }

    fn try_searched(&mut self, effect: &str, tell: fn(&mut BasisInputs)) {
        let names = self.selected.names(&self.design);
        let skewed = names.iter().any(|n| n == effect);
        let visible = self.ratio() >= VISIBLE_GAP_RATIO * self.noise_rms();
        let detection = self.design.columns.blocks.iter().any(|b| b.name == effect);
        let accompanied = skewed && names.len() > 1;
        if !detection || !(visible || accompanied) {
            return;
        }
        let (_, noise) = self.levels();
        let excess = self.relinearized.residuals().white_rms().powi(2) - noise;
        let left = excess * self.design.gram.total_rows() as f64;
        let beside = if skewed {
            names.clone()
        } else {
            [&names[..], &[effect.into()]].concat()
        };
        let few = self.winding_design(tell, Some(&beside));
        let enough = |s: f64, count: usize| {
            visible && s < WINDING_LEAVES * left
                || count < names.len() && s < left + MINIMUM_SQUARES
        };
        // All, and all but one: it may be what stands in for a winding.
        let all: Vec<usize> = few.effects();
        let but = |k: usize| {
            let others = all.iter().enumerate().filter(|(at, _)| *at != k);
            others.map(|(_, b)| *b).collect::<Vec<usize>>()
        };
        let mut sets = (0..=all.len()).map(but);
        let mut validation = few.cross_validation();
        let worth = sets.any(|set| {
            let squares = validation.score(&set).squares - self.selected.base;
            log(&format!(
                "winding lines leave {squares:.0} of {left:.0} with {set:?}"
            ));
            enough(squares, set.len())
        });
        drop(validation);
        if !worth {
            return;
        }
        let again = self.winding_design(tell, None);
        let selected = SelectedModel::new(&again, self.noise.is_some());
        let found = selected.names(&again);
        let squares = again
            .cross_validation()
            .score(&selected.found.blocks)
            .squares
            - selected.base;
        if found.iter().any(|n| n == effect) && enough(squares, found.len()) {
            let relinearized = RelinearizedFit::of(&again, &selected);
            if !of_no_size(&relinearized) {
                self.accept_fit(again, selected, relinearized);
            }
        }
    }

    /// A design in which the lines wind, of some blocks or all.
    fn winding_design(&self, tell: fn(&mut BasisInputs), only: Option<&[String]>) -> Design<'a> {
        let mut inputs = self.design.linearized.inputs.clone();
        tell(&mut inputs);
        let point = LinearizationPoint {
            noise: self.noise,
            ..self.trusted()
        };
        let design_options = DesignOptions {
            previous_inputs: Some(&inputs),
            only,
            ..DesignOptions::default()
        };
        assemble(self.prepared, self.options, &point, design_options)
    }
}
