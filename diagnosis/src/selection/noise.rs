//! Noise above the stated one: when it is allowed for. How much there is of it, and whose, is in `loudness.rs`.

use super::ModelSelection;
use super::selected::SelectedModel;
use crate::design::assembly::{Design, DesignOptions, assemble};
use crate::linearization::point::LinearizationPoint;
use crate::linearization::relinearized::RelinearizedFit;
use crate::selection::limits::{LEFT_OVER, LITTLE, NOISY, VISIBLE};
use effects::sensor::READINGS;

/// Noise beneath a gap that hides its cause is so many times the stated one.
const LOUD_BENEATH: f64 = 2.0;

impl<'a> ModelSelection<'a> {
    /// Where what is left is rough, it is noise: shapes are compared with it, and not with what is stated.
    pub(super) fn allow_for_noise(&mut self) {
        let Some(noise) = self.noise_left().or_else(|| self.noise_alone()) else {
            self.allow_for_noise_beneath();
            return;
        };
        let (again, told) = self.with_noise(noise, self.fine.about.clone());
        self.noise = Some(noise);
        self.take(again, told);
    }

    /// All compared anew with a noise, about what was found.
    fn with_noise(
        &self,
        noise: [f64; READINGS],
        about: LinearizationPoint,
    ) -> (Design<'a>, SelectedModel) {
        let about = LinearizationPoint {
            noise: Some(noise),
            ..about
        };
        let look = DesignOptions {
            as_in: Some(&self.study.scene.inputs),
            ..DesignOptions::default()
        };
        let again = assemble(self.prepared, self.options, &about, look);
        let told = SelectedModel::new(&again, true);
        (again, told)
    }

    /// By a noise that is stated far too low, amounts stray beyond any physical size, and a cause with them. Where hardly anything is
    /// found, what is rough of the gap is taken for the noise: if a cause shows beside it and leaves noise indeed, that is what it is.
    fn allow_for_noise_beneath(&mut self) {
        if self.noise.is_some() || self.ratio() < NOISY || self.told.found.rest < LITTLE {
            return;
        }
        let noise = self.noise_of_readings();
        if noise.iter().all(|n| *n < LOUD_BENEATH) {
            return;
        }
        let (again, told) = self.with_noise(noise, self.prepared.about());
        // A gap that does not show beside that noise is what chance makes of it.
        let shows = again.arena().score(&[]).squares > VISIBLE * VISIBLE * told.base;
        if told.found.blocks.is_empty() || told.found.rest > LEFT_OVER || !shows {
            return;
        }
        let fine = RelinearizedFit::of(&again, &told);
        let before = std::mem::replace(&mut self.study, again);
        let known = std::mem::replace(&mut self.told, told);
        let other = std::mem::replace(&mut self.fine, fine);
        self.noise = Some(noise);
        self.restate();
        let noise_is_left = self.rough(&self.after) && self.is_noise(&self.after);
        if !noise_is_left {
            (self.study, self.told, self.fine) = (before, known, other);
            self.noise = None;
            self.restate();
        }
    }

    /// Noise of each reading over the stated one, where it was not known and is what is left.
    pub(super) fn noise_left(&self) -> Option<[f64; READINGS]> {
        let is_noise = self.noise.is_none()
            && self.ratio() >= NOISY
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
        let found = &self.told.found;
        if found.blocks.is_empty() || found.rest < LITTLE {
            return None;
        }
        let bare = RelinearizedFit::new(&self.study.scene, self.prepared.about(), &[]);
        let fine = std::mem::replace(&mut self.fine, bare);
        self.restate();
        let noise = self.noise_left();
        if noise.is_none() {
            self.fine = fine;
            self.restate();
        }
        noise
    }
}
