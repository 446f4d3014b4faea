//! A field over the platen tooth by tooth. It is searched on a coarser mesh, as hundreds of unknowns stand for other causes; once it
//! is found it is told by the teeth that the segments read in common.

use super::{CLOSE, Judge};
use crate::heldout::Residuals;
use crate::refine::Refined;
use crate::study::FIELD;
use crate::trace::log;
use effects::sensor::Survey;

impl Judge<'_> {
    /// Tells the field by its teeth where that leaves less.
    pub(super) fn tell_teeth(&mut self) {
        let names = self.told.names(&self.study);
        if !names.iter().any(|n| n == FIELD) || self.ratio() < CLOSE * self.noise_rms() {
            return;
        }
        let Some(teeth) = crate::footprint::find(&self.fine) else {
            return;
        };
        let tell = |survey: &mut Survey| {
            survey.field_by_segment = true;
            survey.field_by_value = false;
            survey.teeth = Some(teeth.clone());
        };
        let about = self.fine.about.clone();
        let fine = self.fine.telling(&self.study.scene, about, &names, &tell);
        let left = |fine: &Refined| fine.left_out().map_or(f64::INFINITY, Residuals::white_rms);
        let [teeth, mesh] = [&fine, &self.fine].map(left);
        log(&format!("tooth by tooth {teeth:.3}, before {mesh:.3}"));
        if teeth < mesh {
            self.fine = fine;
            self.restate();
        }
    }
}
