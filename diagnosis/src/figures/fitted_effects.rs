//! Some effects, fitted about themselves, and what they leave: all figures are made of it.

use crate::data::prepare::Prepared;
use crate::design::assembly::{Design, Options};
use crate::inference::residuals::Residuals;
use crate::linearization::relinearized::RelinearizedFit;
use crate::noise::simulated::Floor;
use effects::sensor::READINGS;

/// Some effects, fitted about themselves, and what they leave: all figures are made of it.
pub(crate) struct FittedEffects<'a> {
    pub(super) prepared: &'a Prepared,
    pub(super) options: &'a Options,
    /// All columns, linearised about what was found before.
    pub(super) design: Design<'a>,
    /// Blocks of what is named.
    pub(super) blocks: Vec<usize>,
    /// Whitened squares of the noise.
    pub(super) base: f64,
    /// What is named, fitted about itself.
    pub(super) relinearized: RelinearizedFit<'a>,
    /// The simulator's scatter by the stated noise.
    pub(super) floor: Floor,
    /// Noise of each reading over the stated one, where it was found to be above.
    pub(super) noise: Option<[f64; READINGS]>,
    /// Held-out residuals of the baseline alone, and with what is found; both by the stated noise.
    pub(super) before: Residuals,
    pub(super) after: Residuals,
    /// Residuals of the baseline alone on folds that it has not seen.
    pub(super) before_by_folds: Residuals,
    /// What the model is expected to leave on another recording, and on folds of one that it has not seen, where a part of it does
    /// not carry over: a drift's course.
    pub(super) transfer_residuals: Option<[Residuals; 2]>,
    /// What the model is expected to leave where a vibration beats otherwise than it does here.
    pub(super) without_beats: Option<Residuals>,
}

impl<'a> FittedEffects<'a> {
    /// Names of the blocks.
    pub(super) fn names(&self) -> Vec<String> {
        let name = |b: &usize| self.design.columns.blocks[*b].name.clone();
        self.blocks.iter().map(name).collect()
    }

    /// What is left, by the stated noise.
    pub(super) fn update_residuals(&mut self) {
        self.after = self.by_stated_noise(self.held_out());
    }

    /// Residuals by folds that the fit has not seen. Where a field is told by its teeth, by short pieces: a fold is whole places, and
    /// of teeth that no other fold went over nothing is foretold.
    pub(super) fn held_out(&self) -> &Residuals {
        let by_teeth = self.relinearized.linearized.inputs.teeth.is_some();
        let pieces = by_teeth.then(|| self.relinearized.left_out()).flatten();
        pieces.unwrap_or_else(|| self.relinearized.residuals())
    }

    pub(super) fn by_stated_noise(&self, residuals: &Residuals) -> Residuals {
        if self.noise.is_none() {
            return residuals.clone();
        }
        let point = &self.relinearized.point;
        let mut stated = self
            .relinearized
            .linearized
            .moved(point.baseline.clone(), point.displacement.clone());
        stated.noise = [1.0; READINGS];
        residuals.rewhitened(&stated)
    }

    /// Whitened rms of what is left over the floor's.
    pub(super) fn ratio(&self) -> f64 {
        self.after.white_rms() / self.floor.white_square.sqrt()
    }

    /// Whitened rms of the noise as it was found, over the stated one.
    pub(super) fn noise_rms(&self) -> f64 {
        if self.noise.is_some() {
            self.ratio()
        } else {
            1.0
        }
    }

    /// Mean square of the whole gap beyond the noise, and of the noise, in the units of the search.
    pub(super) fn levels(&self) -> (f64, f64) {
        let mut validation = self.design.cross_validation();
        let rows = validation.rows();
        let noise = self.base / rows;
        (
            (validation.score(&[]).squares / rows - noise).max(1e-9),
            noise.max(1e-9),
        )
    }

    /// Share of the gap that is left, held out, after what is found.
    pub(super) fn left(&self) -> f64 {
        let (whole_gap, noise) = self.levels();
        let before = if self.noise.is_some() {
            whole_gap
        } else {
            (self.before.white_rms().powi(2) - noise).max(1e-9)
        };
        let after = self.held_out().white_rms();
        ((after.powi(2) - noise) / before).clamp(0.0, 1.0)
    }
}
