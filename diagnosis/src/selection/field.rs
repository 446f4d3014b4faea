//! A field over the platen: when it is looked for, and when a shape without a name is the likelier.

use super::ModelSelection;
use super::selected::{SelectedModel, leading};
use crate::design::assembly::{DesignOptions, assemble};
use crate::design::single_teeth::single_teeth;
use crate::inference::cross_validation::CrossValidation;
use crate::linearization::point::LinearizationPoint;
use crate::selection::limits::{FIELD_COORDINATES, UNEXPLAINED_SHARE, VISIBLE_GAP_RATIO};
use crate::trace::log;
use effects::Detection;
use effects::sensor::SingleTeeth;

/// A field over the platen is worth its hundreds of unknowns if it leaves less than this share of what was left.
const FIELD_LEAVES: f64 = 0.7;

impl ModelSelection<'_> {
    /// A field over the platen, where much is left and it is no noise.
    pub(super) fn try_field(&mut self) {
        let left = self.selected.found.unexplained_fraction.max(self.left());
        let (found, shaped) = (&self.selected.found, &self.selected.shaped);
        // Waves over the platen, along a segment or either way, are what a field looks like.
        let coordinate_blocks =
            |b: &usize| FIELD_COORDINATES.contains(&self.design.columns.blocks[*b].name.as_str());
        let waves = shaped.blocks.iter().any(coordinate_blocks);
        let better = shaped.unexplained_fraction < 0.5 * found.unexplained_fraction;
        let selected = shaped.unexplained_fraction < UNEXPLAINED_SHARE && better && !waves;
        // The noise that was found is what neighbours show: what the best shapes leave beyond it is no noise.
        let left = if self.noise.is_some() {
            1.0 - self.relinearized.residuals().white_rms().powi(-2)
        } else {
            left
        };
        let little = left < UNEXPLAINED_SHARE && !(better && waves);
        if little || self.ratio() < VISIBLE_GAP_RATIO || selected {
            return;
        }
        let mask = leading(&self.design, &self.selected);
        let several = self.take_field(&mask, FIELD_LEAVES * left, None);
        let left = if several {
            self.selected.found.unexplained_fraction
        } else {
            left
        };
        if !self.take_single_teeth(&mask, left) && !several {
            return;
        }
        // Beside a field that was most of the gap noise shows only now.
        if let Some(noise) = self.noise_left() {
            self.noise = Some(noise);
            self.take_field(&mask, f64::INFINITY, None);
        }
    }

    /// A field of teeth, or of a ring's pole pairs, that the sensor reads one at a time.
    fn take_single_teeth(&mut self, beside: &[String], left: f64) -> bool {
        if self.ratio() < VISIBLE_GAP_RATIO {
            return false;
        }
        let ways = single_teeth(&self.design).into_iter();
        ways.fold(false, |taken, way| {
            let most = if taken {
                self.selected.found.unexplained_fraction
            } else {
                FIELD_LEAVES * left
            };
            self.take_field(beside, most, Some(way)) || taken
        })
    }

    /// Takes over the best set with a field over the platen if it leaves less than this share.
    fn take_field(
        &mut self,
        beside: &[String],
        most: f64,
        single_teeth: Option<SingleTeeth>,
    ) -> bool {
        let design_options = DesignOptions {
            line_residuals: Some(self.relinearized.residuals()),
            previous_inputs: Some(&self.design.linearized.inputs),
            field: true,
            single_teeth,
            only: Some(beside),
            ..DesignOptions::default()
        };
        let point = LinearizationPoint {
            noise: self.noise,
            ..self.trusted()
        };
        let fielded = assemble(self.prepared, self.options, &point, design_options);
        if !fielded
            .columns
            .blocks
            .iter()
            .any(|b| effects::is(&b.name, Detection::AsField))
        {
            return false;
        }
        let selected = SelectedModel::new(&fielded, self.noise.is_some());
        let better = selected.found.unexplained_fraction < most;
        if better {
            self.accept(fielded, selected);
        }
        better
    }

    /// True if a field over the platen was found, and a shape without a name is the likelier in its place: a few long waves are no
    /// matter of single teeth.
    pub(super) fn is_no_field(&self, validation: &mut CrossValidation) -> bool {
        let found = &self.selected.found.blocks;
        let field = self
            .names_of(found)
            .iter()
            .position(|name| effects::is(name, Detection::AsField));
        let Some(field) = field else {
            return false;
        };
        let evidence = validation.score(found).log_evidence;
        let others = found.iter().copied().filter(|b| *b != found[field]);
        let others: Vec<usize> = others.collect();
        let shaped = &self.selected.shaped.blocks;
        let rivals = self.design.coordinate_blocks().into_iter().map(|b| {
            let with = others.iter().copied().chain([b]);
            with.collect::<Vec<usize>>()
        });
        let mut rivals = rivals.chain(
            [shaped.clone()]
                .into_iter()
                .filter(|s| !s.contains(&found[field])),
        );
        rivals.any(|set| {
            let other = validation.score(&set).log_evidence;
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
