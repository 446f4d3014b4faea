//! What a session does with a pose's mean, and its two verdicts: after the fit, and after the held-out poses.

use super::Session;
use super::least_poses::least_poses;
use crate::average::PoseMean;
use crate::gate::Verdict;
use crate::outcome::{Evidence, Refusal};
use crate::port::Stage;

/// Held-out parities further off than this many predicted deviations are not the sensor's. Derived from the normal tail: none in
/// 10^14.
const HELD_OUT_OUTLIER: f32 = 8.0;

impl Session {
    pub(super) fn use_pose(&mut self, mean: &PoseMean) {
        match self.stage {
            Stage::Origin => {
                self.origin = mean.sample;
                self.stage = Stage::Fit;
                self.done = 0;
                self.go_on();
            }
            Stage::Fit => self.fit_pose(mean),
            Stage::HeldOut => self.test_pose(mean),
            Stage::Solving | Stage::Finished => {}
        }
    }

    fn fit_pose(&mut self, mean: &PoseMean) {
        let Some((config, regression)) = &self.config else {
            return;
        };
        if self.fit.add(regression, &mean.sample) == Verdict::Entered {
            self.raw.add(mean.sample.parity_m(config.geometry.pitch_m));
        }
        for (sum, amplitude) in self.sums.iter_mut().zip(mean.amplitude_counts) {
            *sum += amplitude;
        }
        self.temperature_sum_k += mean.sample.temperature_delta_k;
        self.next_pose();
    }

    fn test_pose(&mut self, mean: &PoseMean) {
        let Some((config, regression)) = &self.config else {
            return;
        };
        match self.fit.innovation(regression, &mean.sample) {
            Some((innovation, deviation)) if innovation.abs() <= HELD_OUT_OUTLIER * deviation => {
                self.held_out_raw
                    .add(mean.sample.parity_m(config.geometry.pitch_m));
                self.held_out_in_force.add(mean.parity_in_force_m);
                self.held_out.add(innovation);
            }
            _ => self.held_out_refused += 1,
        }
        self.next_pose();
    }

    pub(super) fn end_fit(&mut self) {
        let Some((config, regression)) = &self.config else {
            return;
        };
        let limits = config.limits;
        self.fit.review_startup(regression);
        self.worst_deviation_m = self.fit.worst_deviation_m(regression);
        let wanted = least_poses(regression.unknowns() as u32);
        if let Err(error) = self.fit.estimator_mut().solve() {
            return self.refuse(error.into());
        }
        let evidence = self.evidence();
        if self.fit.refused() > self.loss_limit() {
            let (refused, poses) = (self.fit.refused(), self.done);
            self.refuse(Refusal::Outliers {
                refused,
                poses,
                limit: self.loss_limit(),
            });
        } else if evidence.poses < wanted {
            self.refuse(Refusal::TooFewPoses {
                poses: evidence.poses,
                wanted,
            });
        } else if evidence.rank < evidence.unknowns {
            self.refuse(Refusal::Rank {
                rank: evidence.rank,
                unknowns: evidence.unknowns,
            });
        } else if evidence.condition.is_nan() || evidence.condition > limits.condition {
            self.refuse(Refusal::Condition {
                condition: evidence.condition,
                limit: limits.condition,
            });
        } else {
            self.stage = Stage::HeldOut;
            (self.visited, self.done) = (self.done, 0);
        }
    }

    pub(super) fn decide(&mut self) {
        let Some((config, regression)) = &self.config else {
            return;
        };
        let evidence = self.evidence();
        let (before_m, after_m) = (evidence.held_out_in_force_m, evidence.held_out_m);
        let limit_m = before_m * config.limits.held_out_ratio;
        let limit = self.loss_limit();
        if self.held_out_refused > limit {
            let (refused, poses) = (self.held_out_refused, self.done);
            self.refuse(Refusal::Outliers {
                refused,
                poses,
                limit,
            });
        } else if after_m.is_nan() || after_m >= limit_m {
            self.refuse(Refusal::HeldOut {
                before_m,
                after_m,
                limit_m,
            });
        } else {
            let model = regression.model(&self.fit.estimator().solution().values);
            self.finish(Ok(model), evidence);
        }
    }

    pub(super) fn lost(&self) -> u32 {
        self.fit.refused() + self.lost_still + self.held_out_refused
    }

    /// Poses of the present stage that may be lost.
    pub(super) fn loss_limit(&self) -> u32 {
        let share = self
            .config
            .as_ref()
            .map_or(0.0, |(config, _)| config.limits.lost_share);
        (share * self.planned() as f32) as u32 + 1
    }

    /// What is known so far.
    #[must_use]
    pub fn evidence(&self) -> Evidence {
        let solution = self.fit.estimator().solution();
        let averaged = self.raw.count().max(1.0);
        Evidence {
            poses: self.fit.estimator().rows.rows(),
            lost: self.lost(),
            unknowns: self
                .config
                .as_ref()
                .map_or(0, |(_, regression)| regression.unknowns() as u32),
            rank: solution.rank as u32,
            condition: solution.condition,
            residual_m: self.fit.noise_m(),
            raw_m: self.raw.deviation(),
            worst_deviation_m: self.worst_deviation_m,
            held_out_poses: self.held_out.count() as u32,
            held_out_raw_m: self.held_out_raw.deviation(),
            held_out_in_force_m: self.held_out_in_force.deviation(),
            held_out_m: self.held_out.deviation(),
            amplitude_counts: self.sums.map(|s| s / averaged),
            temperature_delta_k: self.temperature_sum_k / averaged,
        }
    }
}
