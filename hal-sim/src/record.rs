//! Whole recordings: a courier sampled along a plan.

use crate::courier::{Courier, Sample, Truth};
use crate::trajectory::Plan;
use effects::motion::Pose;

/// One row of a recording, with the truth that no recording holds.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Observation {
    /// Since switching on.
    pub time_s: f64,
    /// Index into the plan's runs.
    pub run: usize,
    /// Counts and temperature.
    pub sample: Sample,
    /// Tooth counts.
    pub teeth: [i32; 4],
    /// Commanded pose.
    pub commanded: Pose,
    /// Interferometer.
    pub reference: Pose,
    /// Truth: for tests and scores.
    pub truth: Truth,
}

/// Samples a courier at every time of a plan's runs, in order.
pub fn observe(courier: &mut Courier, plan: &Plan) -> Vec<Observation> {
    let mut observations = Vec::with_capacity(plan.runs.iter().map(|run| run.times_s.len()).sum());
    for (run, named) in plan.runs.iter().enumerate() {
        for &time_s in &named.times_s {
            let sample = courier.counts_at(&plan.schedule, time_s);
            observations.push(Observation {
                time_s,
                run,
                sample,
                teeth: courier.teeth(),
                commanded: plan.schedule.commanded(time_s),
                reference: courier.reference(&plan.schedule),
                truth: *courier.truth(),
            });
        }
    }
    observations
}
