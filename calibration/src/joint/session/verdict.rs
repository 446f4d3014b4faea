//! What a session is judged by: before any fit, after the steps that set height and lever arm, and at its end.

use super::JointSession;
use crate::diode::DiodeErrors;
use crate::geometry::Geometry;
use crate::joint::config::{lever_length_m, model_of};
use crate::joint::layout::Groups;
use crate::joint::outcome::{JointOutcome, JointResult};
use crate::outcome::{Evidence, Length, Refusal};
use crate::port::Stage;

impl JointSession {
    /// Before any fit: did the courier turn at all?
    pub(super) fn check_motion(&mut self) {
        let Some(config) = &self.config else {
            return;
        };
        let (turn_rad, wanted_rad) = (self.turn.deviation(), config.limits.least_turn_rad);
        if turn_rad < wanted_rad {
            self.refuse(Refusal::NoRotation {
                turn_rad,
                wanted_rad,
            });
        }
    }

    /// After the steps that set height and lever arm: are they what was entered, about, and told by the data?
    pub(super) fn check_after(&mut self) {
        let (Some(config), Some(constraints)) = (&self.config, &self.constraints) else {
            return;
        };
        let last = self.reports.last();
        if !last.is_some_and(|r| r.accepted && r.groups.contains(Groups::MOUNTING)) {
            return;
        }
        let (layout, limits) = (&constraints.layout, &config.limits);
        let (height_m, lever_m) = (config.geometry.height_m, config.geometry.lever_m);
        let length_m = lever_length_m(&config.geometry);
        let lengths = [
            (Length::Height, layout.height(), height_m, height_m),
            (Length::LeverX, layout.lever(), lever_m[0], length_m),
            (Length::LeverY, layout.lever() + 1, lever_m[1], length_m),
        ];
        let mut lengths = lengths.into_iter();
        let refusal = lengths.find_map(|(name, index, entered_m, length_m)| {
            let found_m = self.progress.values[index];
            let limit_m = limits.geometry_share * length_m;
            if (found_m - entered_m).abs() > limit_m {
                return Some(Refusal::Geometry {
                    name,
                    entered_m,
                    found_m,
                    limit_m,
                });
            }
            let limit_m = limits.undetermined_share * length_m;
            let (deviation_m, _) = self.solver.deviation(index)?;
            (deviation_m > limit_m).then_some(Refusal::Undetermined {
                name,
                deviation_m,
                limit_m,
            })
        });
        if let Some(refusal) = refusal {
            self.refuse(refusal);
        }
    }

    /// Ends with what the accepted steps found.
    #[inline(never)] // an outcome on the stack only while it runs
    pub(super) fn decide(&mut self) {
        if self.config.is_some() {
            let evidence = self.evidence();
            let result = self.result();
            self.outcome = Some(JointOutcome { result, evidence });
            self.finish();
        }
    }

    #[inline(never)] // its parts are on the stack only while it runs
    fn result(&self) -> Result<JointResult, Refusal> {
        let (Some(config), Some(constraints)) = (&self.config, &self.constraints) else {
            return Err(self.no_gain());
        };
        if !self.progress.accepted.contains(Groups::MOUNTING) {
            return Err(self.no_gain());
        }
        let (layout, values) = (&constraints.layout, &self.progress.values);
        let (lever, place) = (layout.lever(), layout.place());
        let lever_m = [values[lever], values[lever + 1]];
        let geometry = Geometry {
            height_m: values[layout.height()],
            lever_m,
            ..config.geometry
        };
        let mut sensor: DiodeErrors = [0.0; _];
        sensor.copy_from_slice(&values[layout.gain_difference()..layout.len()]);
        Ok(JointResult {
            model: model_of(layout, values, &config.model),
            geometry,
            origin_m: core::array::from_fn(|i| values[place + i] - lever_m[i]),
            origin_teeth: self.origin_teeth(),
            sensor,
            noise: constraints.noise,
            groups: self.progress.accepted,
        })
    }

    fn no_gain(&self) -> Refusal {
        let best = self
            .reports
            .iter()
            .map(|r| r.after.whitened_rms)
            .fold(f32::INFINITY, f32::min);
        Refusal::NoGain {
            before: self.reports.first().map_or(0.0, |r| r.before.whitened_rms),
            after: best,
        }
    }

    #[inline(never)] // its predictions are on the stack only while it runs
    fn evidence(&self) -> Evidence {
        let solution = self.solver.estimator().solution();
        let poses = self.turn.count().max(1.0);
        let last = self.reports.iter().rev().find(|r| r.accepted);
        Evidence {
            poses: self.buffer.fitted().len() as u32,
            lost: self.lost + last.map_or(0, |r| r.fit.left_out),
            unknowns: last.map_or(0, |r| r.fit.unknowns),
            rank: last.map_or(0, |r| r.fit.rank),
            condition: last.map_or(solution.condition_equilibrated, |r| r.fit.condition),
            residual_m: last.map_or(0.0, |r| r.after.rms_m[0]),
            raw_m: self.raw.deviation(),
            worst_deviation_m: self
                .constraints
                .as_ref()
                .map_or(0.0, |c| self.solver.worst_deviation_m(c)),
            held_out_poses: self.buffer.held_out().len() as u32,
            held_out_raw_m: self.raw.deviation(),
            held_out_in_force_m: self.in_force.deviation(),
            held_out_m: last.map_or(0.0, |r| r.after.rms_m[0]),
            amplitude_counts: self.sums.map(|s| s / poses),
            temperature_delta_k: self.temperature_sum_k / poses,
        }
    }

    #[inline(never)] // an outcome on the stack only while it runs
    pub(super) fn refuse(&mut self, refusal: Refusal) {
        let evidence = self.evidence();
        let result = Err(refusal);
        self.outcome = Some(JointOutcome { result, evidence });
        self.finish();
    }

    fn finish(&mut self) {
        self.stage = Stage::Finished;
        self.visit.stop();
    }
}
