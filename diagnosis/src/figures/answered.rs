//! The answer to a recording that was decided on: verdict, names and aliases are the posterior's, probabilities are made of its odds, and all
//! figures are those of the fit of what it names.

use super::fitted_effects::FittedEffects;
use super::lost_signals;
use super::measured::fitted_effects;
use super::measurements::Measurements;
use super::named::slips_named;
use super::nameless_correction::NamelessCorrection;
use crate::data::prepare::Prepared;
use crate::design::assembly::{Design, Options};
use crate::inference::cross_validation::CrossValidation;
use crate::inference::posterior::birge_ratio;
use crate::inference::residuals::Residuals;
use crate::linearization::relinearized::RelinearizedFit;
use crate::link::state_probabilities;
use crate::noise::simulated::{self, Floor};
pub use crate::posterior::diagnosed::Answer as Decision;
use crate::posterior::diagnosed::Decided;
use crate::posterior::look::is_of;
use crate::progress::{Stage, Watch};
use crate::trace::log;
use crate::transfer::model::Model;
use crate::verdict::answer::{Diagnosis, Named, Share, Verdict};
use crate::verdict::evidence::Evidence;
use crate::verdict::odds::Odds;
use effects::Detection;
use effects::sensor::READINGS;

/// The diagnosis with what a report and a model need besides.
#[derive(Clone, Debug, Default)]
pub struct Answer {
    /// What is told.
    pub diagnosis: Diagnosis,
    /// The model, where there is one.
    pub model: Option<Model>,
    /// Held-out residuals with the baseline alone.
    pub before: Residuals,
    /// Held-out residuals with what is named.
    pub after: Residuals,
    /// What a reader may see for himself.
    pub evidence: Evidence,
    /// How it was decided; none where the recording cannot be diagnosed.
    pub decision: Option<Decision>,
}

/// The effects of a decision that are fitted: noise, slips and bursts are measured of what these leave.
fn names_of(decision: &Decision) -> Vec<String> {
    let of_columns = |name: &&str| effects::has(name, |card| card.detection.is_fitted());
    let names = decision.effects.iter().map(|e| e.name.as_str());
    names.filter(of_columns).map(String::from).collect()
}

/// The simulator's scatter by the stated noise, about what a design is linearised about: that is what a claim is compared with, whatever noise
/// the design is whitened by.
fn stated_floor(design: &Design) -> Floor {
    let linearized = &design.linearized;
    if linearized.is_by_stated_noise() {
        return design.floor;
    }
    let (baseline, displacement) = (&linearized.baseline, &linearized.displacement);
    let mut stated = linearized.moved(baseline.clone(), displacement.clone());
    stated.noise = [1.0; READINGS];
    simulated::floor(&stated)
}

/// The answer to a recording that was decided on.
pub(super) fn answered(
    prepared: &Prepared,
    name: &str,
    options: &Options,
    Decided {
        design,
        fitted: fit,
        answer: decision,
    }: Decided,
    watch: Watch,
) -> Answer {
    watch(Stage::Predict);
    decision
        .reasons
        .iter()
        .for_each(|reason| log(&reason.to_string()));
    log(&format!("{:?}", decision.effects));
    let linearized = &design.linearized;
    let names = names_of(&decision);
    let fit = match fit {
        Some(fit) if is_of(&fit, &names) => fit,
        _ => RelinearizedFit::new(linearized, design.point(), &names),
    };
    let floor = stated_floor(&design);
    let mut fitted = fitted_effects(prepared, options, (design, fit));
    fitted.floor = floor;
    fitted.resolve_teeth();
    fitted.claim();
    watch(Stage::Decide);
    let (diagnosis, correction) = fitted.figures_of(name, &decision);
    let answers = diagnosis.verdict != Verdict::InsufficientData;
    let evidence = fitted.evidence(&diagnosis, correction.as_ref());
    Answer {
        model: answers.then(|| fitted.model(&diagnosis, correction)),
        evidence,
        diagnosis,
        before: fitted.before,
        after: fitted.after,
        decision: Some(decision),
    }
}

impl FittedEffects<'_> {
    /// A decision with its figures, and a correction without a name, where nothing is named.
    fn figures_of(
        &self,
        name: &str,
        decision: &Decision,
    ) -> (Diagnosis, Option<NamelessCorrection>) {
        let mut validation = self.design.cross_validation();
        let mut seen = self.measure(&mut validation);
        seen.structured = !self.blocks.is_empty();
        if seen.structured {
            seen.left = self.left();
        }
        let mut out = Diagnosis {
            schema: 1,
            recording: name.into(),
            verdict: decision.verdict,
            notes: self.prepared.notes.clone(),
            ..Diagnosis::default()
        };
        let mut effects = self.named(&mut validation, &seen, decision);
        out.notes.extend(self.doubt_the_reference(&mut effects));
        match self.too_quiet(seen.white_before, seen.white_after) {
            Some(limit) => {
                out.notes.push(limit);
                out.verdict = Verdict::InsufficientData;
            }
            None => out.notes.extend(self.quiet_channel()),
        }
        let noise = effects::name_of(Detection::AsNoise);
        if effects.iter().any(|effect| effect.name == noise) {
            out.notes.extend(self.too_loud(seen.white_after));
        }
        if matches!(out.verdict, Verdict::Named | Verdict::Alias) {
            effects.sort_by(|a, b| b.share.total_cmp(&a.share));
            out.notes.extend(self.shared_with_the_reference(&effects));
            out.effects = effects;
        }
        let correction = self.fill(&mut out, &mut validation, seen);
        if out.verdict == Verdict::Unknown && out.place.is_empty() {
            out.place = self.places_of(decision);
            out.unexplained.place.clone_from(&out.place);
        }
        out.without_signal.clone_from(&self.prepared.without_signal);
        let by_segment = self.design.linearized.scope.reference;
        let mut out = lost_signals::located(out, by_segment);
        state_probabilities(&mut out);
        (out, correction)
    }

    /// Where a decision finds what it leaves, in the channel that shows most of it.
    fn places_of(&self, decision: &Decision) -> Vec<Share> {
        let channel = self.main_channel();
        let each = decision.places.iter().map(|(coordinate, share)| Share {
            channel: channel.into(),
            coordinate: coordinate.clone(),
            share: *share,
        });
        each.collect()
    }

    /// What a decision names, with shares and amounts.
    fn named(
        &self,
        validation: &mut CrossValidation,
        seen: &Measurements,
        decision: &Decision,
    ) -> Vec<Named> {
        let total = seen.total.max(f64::MIN_POSITIVE);
        let bursts = seen.bursts.energy / total;
        let louder = seen.white_after.powi(2) - 1.0;
        let louder = louder * validation.rows() * self.floor.white_square / total;
        let (slips, read) = (&self.prepared.slips, &self.prepared.observations);
        let mut known = vec![
            seen.bursts.named(bursts, birge_ratio(self.held_out())),
            slips_named(slips, read.len(), read.pitch_m),
            self.noise(louder.clamp(0.0, 1.0)),
        ];
        if seen.structured {
            known.extend(self.structured(validation, seen.shaped / total));
        }
        let each = decision.effects.iter().filter_map(|effect| {
            let one = known.iter().find(|known| known.name == effect.name)?;
            let p = effect.probability;
            Some(Named {
                odds: Odds {
                    ln_posterior: (p / (1.0 - p)).ln(),
                    unlisted: one.odds.unlisted,
                },
                aliases: effect.aliases.clone(),
                break_alias: effect.break_alias.clone(),
                ..one.clone()
            })
        });
        each.collect()
    }
}
