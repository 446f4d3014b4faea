//! A field over the platen: when it is looked for, and when a shape without a name is the likelier.

use super::ModelSelection;
use super::selected::{SelectedModel, leading};
use crate::design::assembly::{DesignOptions, assemble};
use crate::inference::cross_validation::CrossValidation;
use crate::linearization::point::LinearizationPoint;
use crate::selection::limits::{LEFT_OVER, VISIBLE, WAVES};
use crate::trace::log;
use effects::Detection;

/// A field over the platen is worth its hundreds of unknowns if it leaves less than this share of what was left.
const FIELD_LEAVES: f64 = 0.7;

impl ModelSelection<'_> {
    /// A field over the platen, where much is left and it is no noise.
    pub(super) fn try_field(&mut self) {
        let left = self.told.found.rest.max(self.left());
        let (found, shaped) = (&self.told.found, &self.told.shaped);
        // Waves over the platen, along a segment or either way, are what a field looks like.
        let places = |b: &usize| WAVES.contains(&self.study.columns.blocks[*b].name.as_str());
        let waves = shaped.blocks.iter().any(places);
        let better = shaped.rest < 0.5 * found.rest;
        let told = shaped.rest < LEFT_OVER && better && !waves;
        // The noise that was found is what neighbours show: what the best shapes leave beyond it is no noise.
        let left = if self.noise.is_some() {
            1.0 - self.fine.residuals().white_rms().powi(-2)
        } else {
            left
        };
        let little = left < LEFT_OVER && !(better && waves);
        if little || self.ratio() < VISIBLE || told {
            return;
        }
        let keep = leading(&self.study, &self.told);
        if !self.take_field(&keep, FIELD_LEAVES * left) {
            return;
        }
        // Beside a field that was most of the gap noise shows only now.
        if let Some(noise) = self.noise_left() {
            self.noise = Some(noise);
            self.take_field(&keep, f64::INFINITY);
        }
    }

    /// Takes over the best set with a field over the platen if it leaves less than this share.
    fn take_field(&mut self, beside: &[String], most: f64) -> bool {
        let look = DesignOptions {
            lines_of: Some(self.fine.residuals()),
            as_in: Some(&self.study.scene.inputs),
            field: true,
            only: Some(beside),
            ..DesignOptions::default()
        };
        let about = LinearizationPoint {
            noise: self.noise,
            ..self.trusted()
        };
        let fielded = assemble(self.prepared, self.options, &about, look);
        if !fielded
            .columns
            .blocks
            .iter()
            .any(|b| effects::is(&b.name, Detection::AsField))
        {
            return false;
        }
        let told = SelectedModel::new(&fielded, self.noise.is_some());
        let better = told.found.rest < most;
        if better {
            self.take(fielded, told);
        }
        better
    }

    /// True if a field over the platen was found, and a shape without a name is the likelier in its place: a few long waves are no
    /// matter of single teeth.
    pub(super) fn is_no_field(&self, arena: &mut CrossValidation) -> bool {
        let found = &self.told.found.blocks;
        let field = self
            .names_of(found)
            .iter()
            .position(|name| effects::is(name, Detection::AsField));
        let Some(field) = field else {
            return false;
        };
        let evidence = arena.score(found).log_evidence;
        let others = found.iter().copied().filter(|b| *b != found[field]);
        let others: Vec<usize> = others.collect();
        let shaped = &self.told.shaped.blocks;
        let rivals = self.study.places().into_iter().map(|b| {
            let with = others.iter().copied().chain([b]);
            with.collect::<Vec<usize>>()
        });
        let mut rivals = rivals.chain(
            [shaped.clone()]
                .into_iter()
                .filter(|s| !s.contains(&found[field])),
        );
        rivals.any(|set| {
            let other = arena.score(&set).log_evidence;
            if other > evidence {
                let names = self.names_of(&set);
                log(&format!(
                    "likelier than a field: {names:?}, {other:.0} over {evidence:.0}"
                ));
            }
            other > evidence
        })
    }
}
