//! What an effect holds besides what it is searched by. As long as it may not be there at all, that would stand for other causes; once
//! it is found it is told with it.

use super::mixed_harmonics::are_the_gaps_own;
use super::{CLOSE, Judge};
use crate::linearization::relinearized::Refined;
use effects::sensor::{Channel, Survey};
use effects::thermal_drift::sensor_side::RIGHT_WITHIN_K;

/// What a skew beside growth must take of what is left without it.
const NEEDED: f64 = 0.4;

impl<'a> Judge<'a> {
    /// Where both are found, a ruling that grows with temperature is right at one that need not be the mean: at the mean it has another
    /// pitch, and is not skewed for that.
    pub(super) fn tell_growth(&mut self) {
        let names = self.told.names(&self.study);
        let at = |name: &str| names.iter().position(|n| n == name);
        let (Some(_), Some(skew)) = (at("thermal_drift"), at("axis_skew")) else {
            return;
        };
        let mut fewer = names.clone();
        fewer.remove(skew);
        let fine = self.fitted_telling(&fewer, &|survey| survey.growth_told = true);
        let (_, noise) = self.levels();
        let excess = |fine: &Refined| fine.residuals().white_rms().powi(2) - noise;
        let left = excess(&fine);
        let shows = left > (CLOSE * CLOSE - 1.0) * noise;
        let needed = shows && excess(&self.fine) < (1.0 - NEEDED) * left;
        if !needed && is_growth(&fine) {
            self.told.found.blocks.remove(skew);
            self.fine = fine;
            self.restate();
        }
    }

    /// A gap's error at the normal amplitude, as far as equation (3) lacks it. Free harmonics tell of that themselves; where they are
    /// no more than that, they go.
    pub(super) fn tell_gap(&mut self) {
        let mut names = self.told.names(&self.study);
        let at = |name: &str| names.iter().position(|n| n == name);
        let shape = at("extra_harmonics");
        let told = self.fine.scene.survey.gap_told;
        if told || at("gap_variation").is_none() || shape.is_some() && !are_the_gaps_own(&self.fine)
        {
            return;
        }
        shape.map(|at| names.remove(at));
        let fine = self.fitted_telling(&names, &|survey| survey.gap_told = true);
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
        for makeshift in ["span_error", "gap_variation"] {
            let mut names = self.told.names(&self.study);
            let at = |name: &str| names.iter().position(|n| n == name);
            let (Some(_), Some(stands_in)) = (at("angle_dependence"), at(makeshift)) else {
                continue;
            };
            names.remove(stands_in);
            let turned = [Channel::Sine, Channel::Cosine].map(|channel| {
                self.fitted_telling(&names, &|survey| {
                    survey.fuller.turns_with_theta = Some(channel);
                })
            });
            let left = |fine: &Refined| fine.residuals().white_rms();
            let [one, other] = turned;
            let fine = if left(&one) < left(&other) {
                one
            } else {
                other
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
        more: &dyn Fn(&mut Survey),
    ) -> Refined<'a> {
        let about = self.prepared.about();
        self.fine.telling(&self.study.scene, about, names, more)
    }
}

/// True if each ruling's pitch at the mean temperature is what its growth makes of a temperature at which it is right.
fn is_growth(fine: &Refined) -> bool {
    let amount = |name: &str| {
        let mut all = fine.columns.regressors.iter();
        all.position(|r| r.name == name).map(|c| fine.amount(c))
    };
    ["x", "y"].iter().all(|axis| {
        let slope = amount(&format!("scale of {axis}")).unwrap_or(0.0);
        let there = amount(&format!("scale of {axis} at the mean temperature")).unwrap_or(0.0);
        there == 0.0 || (there / slope).abs() <= RIGHT_WITHIN_K
    })
}
