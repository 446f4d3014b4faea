//! A field over the platen tooth by tooth. It is searched on a coarser mesh, as hundreds of unknowns stand for other causes; once it
//! is named it is told by the teeth that the segments read in common, where that leaves less.

use super::fitted_effects::FittedEffects;
use crate::figures::limits::CLOSE_RATIO;
use crate::inference::residuals::Residuals;
use crate::linearization::relinearized::RelinearizedFit;
use crate::trace::log;
use effects::Detection;
use effects::sensor::BasisInputs;
use tooth_field::Teeth;

impl<'a> FittedEffects<'a> {
    /// Tells the field by its teeth where that leaves less.
    pub(super) fn resolve_teeth(&mut self) {
        let names = self.names();
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
        let relinearized = self.told_by(&teeth, &names);
        let [by_teeth, by_mesh] = [&relinearized, &self.relinearized].map(left);
        log(&format!(
            "tooth by tooth {by_teeth:.3}, before {by_mesh:.3}"
        ));
        if by_teeth < by_mesh {
            self.relinearized = relinearized;
            self.update_residuals();
        }
    }

    fn told_by(&self, teeth: &Teeth, names: &[String]) -> RelinearizedFit<'a> {
        let tell = |inputs: &mut BasisInputs| {
            inputs.field_by_segment = true;
            inputs.field_by_value = false;
            inputs.teeth = Some(teeth.clone());
        };
        let point = self.relinearized.point.clone();
        self.relinearized
            .with_forms(&self.design.linearized, point, names, &tell)
    }
}

/// Whitened rms of short pieces, each foretold from all else.
fn left(relinearized: &RelinearizedFit) -> f64 {
    relinearized
        .left_out()
        .map_or(f64::INFINITY, Residuals::white_rms)
}
