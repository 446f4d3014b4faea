//! The figures of an answer: each channel's gap and what is left of it, where both lie, and the residuals that a report draws.

use super::fitted_effects::FittedEffects;
use super::follows::follows;
use super::location::{Located, attribute, clock_first, merge, outside_first};
use super::measurements::Measurements;
use super::nameless_correction::NamelessCorrection;
use crate::data::channel_names::CHANNEL_NAMES;
use crate::inference::cross_validation::CrossValidation;
use crate::inference::residuals::Residuals;
use crate::verdict::answer::{Diagnosis, Gap, HeldOutChannel, Unexplained, Verdict};
use crate::verdict::evidence::{Evidence, Step, WITHOUT_A_NAME};
use effects::Detection;

impl FittedEffects<'_> {
    /// Fills in the figures; gives a correction without a name, where nothing is named.
    pub(super) fn fill(
        &self,
        out: &mut Diagnosis,
        validation: &mut CrossValidation,
        mut seen: Measurements,
    ) -> Option<NamelessCorrection> {
        let (mut correction, mut rest) = (None, Unexplained::default());
        let named = matches!(out.verdict, Verdict::Named | Verdict::Alias);
        let model = if named {
            self.prediction()
        } else {
            &self.before
        };
        if named && self.transfer_residuals.is_some() {
            out.notes.push(self.time_bound_remark());
        }
        if named {
            out.notes.extend(
                self.followed()
                    .map(|card| format!("{}: {}", card.name, card.remark)),
            );
            out.notes.extend(self.beat_remark());
        }
        let bursts = out
            .effects
            .iter()
            .any(|e| effects::is(&e.name, Detection::AsBursts));
        let aside = bursts.then(|| self.without_bursts(model));
        let (all, model) = (model, aside.as_ref().unwrap_or(model));
        for c in self.before.channels() {
            let after = |left: &Residuals| left.channel_rms_m(c).0.max(1e-12);
            let set_aside = after(model) / after(all);
            let (real, samples) = self.before.channel_rms_m(c);
            let simulated = self.floor.channel_rms_m[c];
            let signed = |v: f64| {
                (v * v - simulated * simulated).signum()
                    * (v * v - simulated * simulated).abs().sqrt()
            };
            out.gap.push(Gap {
                channel: CHANNEL_NAMES[c].into(),
                samples,
                real_rms_m: real,
                simulated_rms_m: simulated,
                excess_rms_m: signed(real),
                excess_ci95_m: self.before.interval_m(c).map(signed),
            });
            out.held_out.channels.push(HeldOutChannel {
                channel: CHANNEL_NAMES[c].into(),
                before_rms_m: real,
                after_rms_m: model.channel_rms_m(c).0,
                after_ci95_m: self.prediction_interval_m(named, c).map(|m| m * set_aside),
                floor_rms_m: simulated,
            });
        }
        let floor = self.floor.white_square.sqrt();
        out.held_out.whitened_before = seen.white_before;
        out.held_out.whitened_after = model.white_rms() / floor;
        if out.verdict != Verdict::NoGap {
            let mut located = self.locate_whole(validation);
            if out.verdict == Verdict::Unknown {
                (correction, rest) = self.unnamed(validation, &mut located);
            }
            out.place = self.shares(located);
            out.unexplained = if named {
                attribute(&self.design, validation, &self.blocks, &mut seen.located);
                let follows = if self.is_located(&seen) {
                    follows(&self.design, &self.blocks, &seen.located)
                } else {
                    Vec::new()
                };
                Unexplained {
                    share: (seen.left * seen.shaped / seen.total.max(1e-9)).clamp(0.0, 1.0),
                    place: self.shares(seen.located),
                    follows,
                    correction: None,
                }
            } else {
                Unexplained {
                    share: 1.0,
                    place: out.place.clone(),
                    ..rest
                }
            };
        }
        correction
    }

    /// What is told of a gap that nothing explains: takes finer shapes over into `located`; what follows a logged column, and how far a
    /// correction without a name gets, with what that leaves.
    fn unnamed(
        &self,
        validation: &mut CrossValidation,
        located: &mut Vec<Located>,
    ) -> (Option<NamelessCorrection>, Unexplained) {
        let fine = self.fine_design();
        let mut by_fine = fine.cross_validation();
        let finely = self.locate_finely(&fine, &mut by_fine);
        let corrections = [
            self.nameless_correction(&self.design, validation, located),
            self.nameless_correction(&fine, &mut by_fine, &finely),
        ];
        let best = corrections
            .into_iter()
            .flatten()
            .min_by(|a, b| a.residuals.white_rms().total_cmp(&b.residuals.white_rms()));
        let rest = Unexplained {
            correction: best.as_ref().map(|best| self.correction_told(best)),
            follows: follows(&self.design, &[], located),
            ..Unexplained::default()
        };
        merge(located, finely);
        clock_first(located);
        outside_first(located);
        (best, rest)
    }

    /// Residuals beside their coordinates, and the gap after each effect in the order of the answer, or after a correction without a name.
    pub(super) fn evidence(
        &self,
        diagnosis: &Diagnosis,
        correction: Option<&NamelessCorrection>,
    ) -> Evidence {
        let columns = &self.design.columns;
        let floor = self.floor.white_square.sqrt();
        let found = &self.blocks;
        let step = |effect: &str, of: &Residuals| Step {
            effect: effect.into(),
            whitened: of.white_rms() / floor,
        };
        let mut steps = vec![step("", &self.before)];
        let mut blocks = Vec::new();
        for effect in &diagnosis.effects {
            let same = |b: &&usize| columns.blocks[**b].name == effect.name;
            if let Some(&block) = found.iter().find(same) {
                blocks.push(block);
                steps.push(if blocks.len() == found.len() {
                    step(&effect.name, &self.after)
                } else {
                    let part = self.design.residuals(&blocks);
                    step(&effect.name, &part)
                });
            }
        }
        let after = match correction {
            Some(correction) => {
                steps.push(step(WITHOUT_A_NAME, &correction.residuals));
                &correction.residuals
            }
            None if blocks.is_empty() => &self.before,
            None => &self.after,
        };
        let mut evidence = Evidence::new(&self.design.linearized, &self.before, after, steps);
        evidence.set_aside += self.prepared.samples - evidence.samples;
        evidence.samples = self.prepared.samples;
        evidence
    }
}
