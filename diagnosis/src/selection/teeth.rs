//! A field over the platen tooth by tooth. It is searched on a coarser mesh, as hundreds of unknowns stand for other causes; once it
//! is found it is told by the teeth that the segments read in common, and what follows the motion and not the place is looked for in
//! what these leave: a mesh lacks more than that, and a fly-by over teeth oscillates itself, at a beacon's frequencies as well.

use super::selected::SelectedModel;
use super::{ModelSelection, is_delay};
use crate::design::assembly::{Design, DesignOptions, assemble};
use crate::inference::residuals::Residuals;
use crate::linearization::point::LinearizationPoint;
use crate::linearization::relinearized::RelinearizedFit;
use crate::selection::limits::CLOSE_RATIO;
use crate::selection::limits::MINIMUM_SQUARES;
use crate::selection::search::SearchResult;
use crate::selection::worth::unexplained_fraction;
use crate::spectra::lines::{add_lines, lines_of};
use crate::trace::log;
use effects::sensor::BasisInputs;
use effects::sensor::SLOWEST_LINE_HZ;
use effects::{Card, Detection};
use tooth_field::Teeth;

/// What is found beside a field must leave less than this share of what its teeth leave without it.
const BESIDE_TEETH_LEAVES: f64 = 0.7;
/// A delay is tried if beside the mesh it takes this share of what it has to take beside the teeth.
const DELAY_BESIDE_MESH_SHARE: f64 = 0.5;
/// And if it takes this share of that from the samples that it is fitted to: it takes no more of others.
const DELAY_FITTED_SHARE: f64 = 0.5;
/// So many effects are tried in the place of what all readings have in common. A bound on the work: a third is not tried, and the
/// field stays.
const TRIED_FOR_COMMON_FIELD: usize = 2;

impl<'a> ModelSelection<'a> {
    /// Tells the field by its teeth where that leaves less.
    pub(super) fn resolve_teeth(&mut self) {
        let names = self.selected.names(&self.design);
        // Single ones are told by themselves already.
        if self.design.linearized.inputs.forms.single_teeth.is_some() {
            return;
        }
        if !names.iter().any(|n| effects::is(n, Detection::AsField))
            || self.ratio() < CLOSE_RATIO * self.noise_rms()
        {
            return;
        }
        let Some(teeth) = crate::inference::aperture::find(&self.relinearized) else {
            return;
        };
        let relinearized = self.told_by(&teeth, &names, &[]);
        let [by_teeth, by_mesh] = [&relinearized, &self.relinearized].map(left);
        log(&format!(
            "tooth by tooth {by_teeth:.3}, before {by_mesh:.3}"
        ));
        if by_teeth < by_mesh {
            self.relinearized = relinearized;
            self.update_residuals();
            self.try_vibration(&teeth, names);
            self.try_delays(&teeth);
            self.try_common(&teeth);
        }
    }

    /// What all readings have in common is not the teeth's. A field of hundreds of unknowns takes it in for want of another effect, and hardly
    /// leaves a gap: the two that take most beside the mesh are told beside the teeth, and the one that leaves less is kept.
    fn try_common(&mut self, teeth: &Teeth) {
        if !self
            .common_field()
            .is_some_and(|common_field| common_field.is_flat())
        {
            return;
        }
        let names = self.selected.names(&self.design);
        let selected =
            |name: &&str| names.iter().any(|n| n == name) || effects::has(name, Card::is_flexible);
        let effects = self.names_of(&self.design.effects());
        let mut likely: Vec<(f64, &str)> = effects
            .into_iter()
            .filter(|name| !selected(name))
            .map(|name| (self.takes(name), name))
            .filter(|(takes, _)| *takes > MINIMUM_SQUARES)
            .collect();
        likely.sort_by(|a, b| b.0.total_cmp(&a.0));
        let without = left(&self.relinearized);
        let mut best: Option<(f64, Vec<String>, RelinearizedFit<'a>)> = None;
        for (takes, name) in likely.into_iter().take(TRIED_FOR_COMMON_FIELD) {
            let names = [&names[..], &[name.to_string()]].concat();
            let relinearized = self.told_by(
                teeth,
                &names,
                &self.design.linearized.inputs.beacon_lines_hz,
            );
            let with = left(&relinearized);
            let rows = relinearized.gram.total_rows() as f64;
            let gain = (without.powi(2) - with.powi(2)) * rows;
            log(&format!(
                "{name} takes {takes:.0} beside the mesh, {gain:.0} beside the teeth"
            ));
            if gain > 2.0 * MINIMUM_SQUARES && best.as_ref().is_none_or(|best| with < best.0) {
                best = Some((with, names, relinearized));
            }
        }
        let selected = best.and_then(|(_, names, relinearized)| {
            Some((self.told_in(&self.design, &names)?, relinearized))
        });
        if let Some((selected, relinearized)) = selected {
            (self.selected, self.relinearized) = (selected, relinearized);
            self.update_residuals();
        }
    }

    /// A delay beside the field: whatever the teeth, it follows the speed. The one that takes most beside the mesh, if it takes enough there.
    fn try_delays(&mut self, teeth: &Teeth) {
        let names = self.selected.names(&self.design);
        let known = names.iter().any(|n| is_delay(n));
        if known || self.ratio() < CLOSE_RATIO * self.noise_rms() {
            return;
        }
        let delays = effects::cards().filter(|card| card.delays);
        let allowed = delays
            .map(|card| card.name)
            .filter(|name| self.allowed(name));
        let likely = allowed.map(|name| (self.takes(name), name));
        let Some((takes, name)) = likely.max_by(|a, b| a.0.total_cmp(&b.0)) else {
            return;
        };
        let (_, noise) = self.levels();
        let excess =
            (left(&self.relinearized).powi(2) - noise) * self.relinearized.gram.total_rows() as f64;
        if takes < DELAY_BESIDE_MESH_SHARE * (1.0 - BESIDE_TEETH_LEAVES) * excess {
            return;
        }
        let names = [&names[..], &[name.to_string()]].concat();
        let relinearized = self.told_by(
            teeth,
            &names,
            &self.design.linearized.inputs.beacon_lines_hz,
        );
        // What a fit does not take of samples that it has seen, it does not take of others.
        let seen = self.relinearized.squares() - relinearized.squares();
        if seen < DELAY_FITTED_SHARE * (1.0 - BESIDE_TEETH_LEAVES) * excess
            || !self.leaves_less(&relinearized)
        {
            return;
        }
        if let Some(selected) = self.told_in(&self.design, &names) {
            (self.selected, self.relinearized) = (selected, relinearized);
            self.update_residuals();
        }
    }

    /// Whitened squares that an effect takes beside the mesh.
    fn takes(&self, name: &str) -> f64 {
        let blocks = &self.design.columns.blocks;
        let Some(block) = blocks.iter().position(|b| b.name == name) else {
            return f64::NEG_INFINITY;
        };
        let mut validation = self.design.cross_validation();
        let found = &self.selected.found.blocks;
        let without = validation.score(found).squares;
        without - validation.score(&[&found[..], &[block]].concat()).squares
    }

    /// True if another fit leaves so much less of what the teeth leave that what it has besides is there.
    fn leaves_less(&self, other: &RelinearizedFit) -> bool {
        let (_, noise) = self.levels();
        let [with, without] =
            [other, &self.relinearized].map(|relinearized| left(relinearized).powi(2) - noise);
        log(&format!(
            "beside the teeth {with:.4} is left of {without:.4}"
        ));
        with < BESIDE_TEETH_LEAVES * without
    }

    fn told_by(&self, teeth: &Teeth, names: &[String], lines_hz: &[f64]) -> RelinearizedFit<'a> {
        let tell = |inputs: &mut BasisInputs| {
            inputs.field_by_segment = true;
            inputs.field_by_value = false;
            inputs.teeth = Some(teeth.clone());
            add_lines(&mut inputs.beacon_lines_hz, lines_hz.to_vec());
        };
        let point = self.relinearized.point.clone();
        self.relinearized
            .with_forms(&self.design.linearized, point, names, &tell)
    }

    /// A beacon that vibrates beside the field, where lines stand out of what the teeth leave.
    fn try_vibration(&mut self, teeth: &Teeth, mut names: Vec<String>) {
        let known = names.iter().any(|n| effects::is(n, Detection::ByLines));
        let shows = self.ratio() >= CLOSE_RATIO * self.noise_rms();
        let Some(residuals) = self.relinearized.left_out().filter(|_| shows && !known) else {
            return;
        };
        let (lines_hz, _) = lines_of(&self.relinearized.linearized, residuals);
        if lines_hz.iter().all(|hz| *hz < SLOWEST_LINE_HZ)
            || !self.allowed(effects::name_of(Detection::ByLines))
        {
            return;
        }
        names.push(effects::name_of(Detection::ByLines).into());
        let relinearized = self.told_by(teeth, &names, &lines_hz);
        if self.leaves_less(&relinearized) {
            let again = self.with_lines(residuals);
            if let Some(selected) = self.told_in(&again, &names) {
                self.accept_fit(again, selected, relinearized);
            }
        }
    }

    /// The blocks compared so far, with the lines that stand in some residuals.
    fn with_lines(&self, residuals: &Residuals) -> Design<'a> {
        let blocks = self.design.columns.blocks.iter().skip(1);
        let mut only: Vec<String> = blocks.map(|block| block.name.clone()).collect();
        only.push(effects::name_of(Detection::ByLines).into());
        let design_options = DesignOptions {
            line_residuals: Some(residuals),
            previous_inputs: Some(&self.design.linearized.inputs),
            field: true,
            only: Some(&only),
            ..DesignOptions::default()
        };
        let point = LinearizationPoint {
            noise: self.noise,
            ..self.trusted()
        };
        assemble(self.prepared, self.options, &point, design_options)
    }

    /// What some effects leave in another design, beside the best shapes of this one; none where it lacks one of them.
    fn told_in(&self, design: &Design, names: &[String]) -> Option<SelectedModel> {
        let blocks_of = |names: &[&str]| -> Option<Vec<usize>> {
            let blocks = &design.columns.blocks;
            let at = |name: &&str| blocks.iter().position(|block| block.name == *name);
            names.iter().map(at).collect()
        };
        let mut validation = design.cross_validation();
        let base = self.selected.base;
        let mut found_as = |names: &[&str]| {
            let blocks = blocks_of(names)?;
            let unexplained_fraction = unexplained_fraction(&mut validation, &blocks, base);
            Some(SearchResult {
                blocks,
                unexplained_fraction,
            })
        };
        let names: Vec<&str> = names.iter().map(String::as_str).collect();
        Some(SelectedModel {
            found: found_as(&names)?,
            shaped: found_as(&self.names_of(&self.selected.shaped.blocks))?,
            base,
        })
    }
}

/// Whitened rms of short pieces, each foretold from all else.
fn left(relinearized: &RelinearizedFit) -> f64 {
    relinearized
        .left_out()
        .map_or(f64::INFINITY, Residuals::white_rms)
}
