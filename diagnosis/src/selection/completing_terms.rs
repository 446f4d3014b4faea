//! What an effect holds besides what it is searched by. As long as it may not be there at all, that would stand for other causes; once
//! it is found it is told with it.

use super::ModelSelection;
use super::intermodulation::are_the_gaps_own;
use crate::linearization::relinearized::RelinearizedFit;
use crate::selection::limits::CLOSE;
use effects::effect::{KnownBy, Subsumption};
use effects::identity::Identity;
use effects::sensor::BasisInputs;

/// What a skew beside growth must take of what is left without it.
const NEEDED: f64 = 0.4;

impl<'a> ModelSelection<'a> {
    /// Where both are found, a ruling that grows with temperature is right at one that need not be the mean: at the mean it has another
    /// pitch, and is not skewed for that.
    pub(super) fn tell_growth(&mut self) {
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
        let names = self.told.names(&self.study);
        let at = |name: &str| names.iter().position(|n| n == name);
        let (Some(_), Some(skew)) = (at(growing.name), at(other)) else {
            return;
        };
        let mut fewer = names.clone();
        fewer.remove(skew);
        let fine = self.fitted_telling(&fewer, tell);
        let (_, noise) = self.levels();
        let excess = |fine: &RelinearizedFit| fine.residuals().white_rms().powi(2) - noise;
        let left = excess(&fine);
        let shows = left > (CLOSE * CLOSE - 1.0) * noise;
        let needed = shows && excess(&self.fine) < (1.0 - NEEDED) * left;
        if !needed && is_growth(&fine, within_k) {
            self.told.found.blocks.remove(skew);
            self.fine = fine;
            self.restate();
        }
    }

    /// A gap's error at the normal amplitude, as far as equation (3) lacks it. Free harmonics tell of that themselves; where they are
    /// no more than that, they go.
    pub(super) fn tell_gap(&mut self) {
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
        let mut names = self.told.names(&self.study);
        let at = |name: &str| names.iter().position(|n| n == name);
        let shape = at(other);
        let told = self.fine.scene.inputs.gap_told;
        if told
            || at(gap.name).is_none()
            || shape.is_some() && !are_the_gaps_own(&self.fine, gap.name, other)
        {
            return;
        }
        shape.map(|at| names.remove(at));
        let fine = self.fitted_telling(&names, tell);
        let as_good = if shape.is_some() { CLOSE } else { 1.0 };
        if fine.residuals().white_rms() < as_good * self.fine.residuals().white_rms() {
            shape.map(|at| self.told.found.blocks.remove(at));
            self.fine = fine;
            self.restate();
        }
    }

    /// A channel that turns against the other with the angle shifts its pair as a span that is wrong does, by as much as the harmonic that
    /// it makes, and changes the amplitude as a gap that tilts does. Where such a turn does as well as the harmonics with one of these beside
    /// them, there is none.
    pub(super) fn tell_turn(&mut self) {
        for (turning, subsumes) in effects::holding(|by| by == KnownBy::Fit) {
            let mut names = self.told.names(&self.study);
            let at = |name: &str| names.iter().position(|n| n == name);
            let (Some(_), Some(stands_in)) = (at(turning.name), at(subsumes.other)) else {
                continue;
            };
            names.remove(stands_in);
            let left = |fine: &RelinearizedFit| fine.residuals().white_rms();
            let told = subsumes.tell.iter();
            let told = told.map(|tell| self.fitted_telling(&names, tell));
            let Some(fine) = told.reduce(|a, b| if left(&a) < left(&b) { a } else { b }) else {
                continue;
            };
            if left(&fine) < CLOSE * left(&self.fine) {
                self.told.found.blocks.remove(stands_in);
                self.fine = fine;
                self.restate();
            }
        }
    }

    pub(super) fn fitted_telling(
        &self,
        names: &[String],
        more: &dyn Fn(&mut BasisInputs),
    ) -> RelinearizedFit<'a> {
        let about = self.prepared.about();
        self.fine.telling(&self.study.scene, about, names, more)
    }
}

/// True if each ruling's pitch at the mean temperature is what its growth makes of a temperature at which it is right.
fn is_growth(fine: &RelinearizedFit, within_k: f64) -> bool {
    let amount = |identity: Identity| {
        let mut all = fine.columns.regressors.iter();
        let column = all.position(|r| r.identity == Some(identity));
        column.map_or(0.0, |c| fine.amount(c))
    };
    (0..2).all(|axis| {
        let slope = amount(Identity::Growth { axis });
        let there = amount(Identity::GrowthAtMean { axis });
        there == 0.0 || (there / slope).abs() <= within_k
    })
}
