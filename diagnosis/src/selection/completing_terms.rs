//! What an effect holds besides what it is searched by. As long as it may not be there at all, that would stand for other causes; once
//! it is found it is told with it.

use super::ModelSelection;
use super::intermodulation::are_the_gaps_own;
use crate::linearization::relinearized::RelinearizedFit;
use crate::posterior::fuller::is_growth;
use crate::selection::limits::CLOSE_RATIO;
use effects::effect::{KnownBy, Subsumption};
use effects::sensor::BasisInputs;

/// What a skew beside growth must take of what is left without it.
const SKEW_BESIDE_GROWTH_SHARE: f64 = 0.4;

impl<'a> ModelSelection<'a> {
    /// Where both are found, a ruling that grows with temperature is right at one that need not be the mean: at the mean it has another
    /// pitch, and is not skewed for that.
    pub(super) fn complete_growth(&mut self) {
        let mut holding = effects::holding(|by| matches!(by, KnownBy::Growth { .. }));
        let Some((
            growing,
            &Subsumption {
                other,
                tell: [tell, ..],
                known_by: KnownBy::Growth { within_k },
            },
        )) = holding.next()
        else {
            return;
        };
        let names = self.selected.names(&self.design);
        let at = |name: &str| names.iter().position(|n| n == name);
        let (Some(_), Some(skew)) = (at(growing.name), at(other)) else {
            return;
        };
        let mut fewer = names.clone();
        fewer.remove(skew);
        let relinearized = self.fitted_with_forms(&fewer, tell);
        let (_, noise) = self.levels();
        let excess =
            |relinearized: &RelinearizedFit| relinearized.residuals().white_rms().powi(2) - noise;
        let left = excess(&relinearized);
        let shows = left > (CLOSE_RATIO * CLOSE_RATIO - 1.0) * noise;
        let needed = shows && excess(&self.relinearized) < (1.0 - SKEW_BESIDE_GROWTH_SHARE) * left;
        if !needed && is_growth(&relinearized, within_k) {
            self.selected.found.blocks.remove(skew);
            self.relinearized = relinearized;
            self.update_residuals();
        }
    }

    /// A gap's error at the normal amplitude, as far as equation (3) lacks it. Free harmonics tell of that themselves; where they are
    /// no more than that, they go.
    pub(super) fn complete_gap(&mut self) {
        let mut holding = effects::holding(|by| by == KnownBy::MixedHarmonics);
        let Some((
            gap,
            &Subsumption {
                other,
                tell: [tell, ..],
                ..
            },
        )) = holding.next()
        else {
            return;
        };
        let mut names = self.selected.names(&self.design);
        let at = |name: &str| names.iter().position(|n| n == name);
        let shape = at(other);
        let selected = self.relinearized.linearized.inputs.gap_told;
        if selected
            || at(gap.name).is_none()
            || shape.is_some() && !are_the_gaps_own(&self.relinearized, gap.name, other)
        {
            return;
        }
        shape.map(|at| names.remove(at));
        let relinearized = self.fitted_with_forms(&names, tell);
        let as_good = if shape.is_some() { CLOSE_RATIO } else { 1.0 };
        if relinearized.residuals().white_rms()
            < as_good * self.relinearized.residuals().white_rms()
        {
            shape.map(|at| self.selected.found.blocks.remove(at));
            self.relinearized = relinearized;
            self.update_residuals();
        }
    }

    /// A channel that turns against the other with the angle shifts its pair as a span that is wrong does, by as much as the harmonic that
    /// it makes, and changes the amplitude as a gap that tilts does. Where such a turn does as well as the harmonics with one of these beside
    /// them, there is none.
    pub(super) fn complete_turn(&mut self) {
        for (turning, subsumes) in effects::holding(|by| by == KnownBy::Fit) {
            let mut names = self.selected.names(&self.design);
            let at = |name: &str| names.iter().position(|n| n == name);
            let (Some(_), Some(substitutes_for_shape)) = (at(turning.name), at(subsumes.other))
            else {
                continue;
            };
            names.remove(substitutes_for_shape);
            let left = |relinearized: &RelinearizedFit| relinearized.residuals().white_rms();
            let selected = subsumes.tell.iter();
            let selected = selected.map(|tell| self.fitted_with_forms(&names, tell));
            let Some(relinearized) =
                selected.reduce(|a, b| if left(&a) < left(&b) { a } else { b })
            else {
                continue;
            };
            if left(&relinearized) < CLOSE_RATIO * left(&self.relinearized) {
                self.selected.found.blocks.remove(substitutes_for_shape);
                self.relinearized = relinearized;
                self.update_residuals();
            }
        }
    }

    pub(super) fn fitted_with_forms(
        &self,
        names: &[String],
        more: &dyn Fn(&mut BasisInputs),
    ) -> RelinearizedFit<'a> {
        let point = self.prepared.point();
        self.relinearized
            .with_forms(&self.design.linearized, point, names, more)
    }
}
