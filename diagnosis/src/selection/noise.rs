//! Noise above the stated one: when it is allowed for. How much there is of it, and whose, is in `loudness.rs`.

use super::ModelSelection;
use super::selected::SelectedModel;
use crate::design::assembly::{Design, DesignOptions, assemble};
use crate::linearization::point::LinearizationPoint;
use crate::linearization::relinearized::RelinearizedFit;
use crate::selection::limits::{
    EXPLAINS_LITTLE_ABOVE, NOISY_RATIO, UNEXPLAINED_SHARE, VISIBLE_GAP_RATIO,
};
use effects::sensor::READINGS;

/// Noise beneath a gap that hides its cause is so many times the stated one.
const LOUD_BENEATH_RATIO: f64 = 2.0;

impl<'a> ModelSelection<'a> {
    /// Where what is left is rough, it is noise: shapes are compared with it, and not with what is stated.
    pub(super) fn allow_for_noise(&mut self) {
        let Some(noise) = self.noise_left().or_else(|| self.noise_alone()) else {
            self.allow_for_noise_beneath();
            return;
        };
        let (again, selected) = self.with_noise(noise, self.relinearized.point.clone());
        self.noise = Some(noise);
        self.accept(again, selected);
    }

    /// All compared anew with a noise, about what was found.
    fn with_noise(
        &self,
        noise: [f64; READINGS],
        point: LinearizationPoint,
    ) -> (Design<'a>, SelectedModel) {
        let point = LinearizationPoint {
            noise: Some(noise),
            ..point
        };
        let design_options = DesignOptions {
            previous_inputs: Some(&self.design.linearized.inputs),
            ..DesignOptions::default()
        };
        let again = assemble(self.prepared, self.options, &point, design_options);
        let selected = SelectedModel::new(&again, true);
        (again, selected)
    }

    /// By a noise that is stated far too low, amounts stray beyond any physical size, and a cause with them. Where hardly anything is
    /// found, what is rough of the gap is taken for the noise: if a cause shows beside it and leaves noise indeed, that is what it is.
    fn allow_for_noise_beneath(&mut self) {
        if self.noise.is_some()
            || self.ratio() < NOISY_RATIO
            || self.selected.found.unexplained_fraction < EXPLAINS_LITTLE_ABOVE
        {
            return;
        }
        let noise = self.noise_of_readings();
        if noise.iter().all(|n| *n < LOUD_BENEATH_RATIO) {
            return;
        }
        let (again, selected) = self.with_noise(noise, self.prepared.point());
        // A gap that does not show beside that noise is what chance makes of it.
        let shows = again.cross_validation().score(&[]).squares
            > VISIBLE_GAP_RATIO * VISIBLE_GAP_RATIO * selected.base;
        if selected.found.blocks.is_empty()
            || selected.found.unexplained_fraction > UNEXPLAINED_SHARE
            || !shows
        {
            return;
        }
        let relinearized = RelinearizedFit::of(&again, &selected);
        let before = std::mem::replace(&mut self.design, again);
        let known = std::mem::replace(&mut self.selected, selected);
        let other = std::mem::replace(&mut self.relinearized, relinearized);
        self.noise = Some(noise);
        self.update_residuals();
        let noise_is_left = self.rough(&self.after) && self.is_noise(&self.after);
        if !noise_is_left {
            (self.design, self.selected, self.relinearized) = (before, known, other);
            self.noise = None;
            self.update_residuals();
        }
    }

    /// Noise of each reading over the stated one, where it was not known and is what is left.
    pub(super) fn noise_left(&self) -> Option<[f64; READINGS]> {
        let is_noise = self.noise.is_none()
            && self.ratio() >= NOISY_RATIO
            && self.rough(&self.after)
            && self.is_noise(&self.after)
            && !self.shaped()
            && !self.hums();
        is_noise.then(|| {
            let noise = self.noise_of_readings();
            crate::trace::log(&format!("noise over the stated one: {noise:.2?}"));
            noise
        })
    }

    /// The same beside nothing where what is found explains little: by the noise itself, which a shape over angles that are read with it
    /// holds as well, and which it makes a pattern of in other channels.
    fn noise_alone(&mut self) -> Option<[f64; READINGS]> {
        let found = &self.selected.found;
        if found.blocks.is_empty() || found.unexplained_fraction < EXPLAINS_LITTLE_ABOVE {
            return None;
        }
        let bare = RelinearizedFit::new(&self.design.linearized, self.prepared.point(), &[]);
        let relinearized = std::mem::replace(&mut self.relinearized, bare);
        self.update_residuals();
        let noise = self.noise_left();
        if noise.is_none() {
            self.relinearized = relinearized;
            self.update_residuals();
        }
        noise
    }
}
