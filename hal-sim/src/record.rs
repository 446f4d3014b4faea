//! Whole recordings: a courier sampled along a plan.

use crate::courier::{Courier, Sample, Truth};
use crate::spec::CourierSpec;
use crate::trajectory::Plan;
use effects::motion::Pose;
use recording::{
    Coordination, Electronics, Geometry, Logged, Meta, Names, Recording, Row, Samples,
};

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
    /// What the machine logs beside the readings.
    pub logged: Option<(&'static str, f64)>,
    /// Truth: for tests and scores.
    pub truth: Truth,
}

/// Samples a courier at every time of a plan's runs, in order.
pub fn observe(courier: &mut Courier, plan: &Plan) -> Vec<Observation> {
    let mut observations = Vec::with_capacity(plan.samples());
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
                logged: courier.logged(&plan.schedule),
                truth: *courier.truth(),
            });
        }
    }
    observations
}

/// `recording.toml` of a courier: what its drawing says and what its electronics state.
#[must_use]
pub fn meta(spec: &CourierSpec) -> Meta {
    let (nominal, electronics) = (&spec.nominal, &spec.electronics);
    Meta {
        device: spec.device.clone(),
        source: "hal-sim".into(),
        names: Names::default(),
        geometry: Geometry {
            pitch_m: nominal.pitch_m,
            span_m: Some(nominal.span_m),
            lateral_m: Some(nominal.lateral_m),
        },
        coordination: Some(Coordination {
            height_m: nominal.height_m,
            lever_x_m: nominal.lever_m[0],
            lever_y_m: nominal.lever_m[1],
            tan_full_scale: nominal.tan_full_scale,
        }),
        electronics: Electronics {
            adc_bits: Some(16),
            amplitude_counts: Some(electronics.amplitude_counts),
            quadrature_noise_counts: Some(electronics.quadrature_noise_counts),
            psd_sum_counts: Some(electronics.psd_sum_counts),
            psd_noise_counts: Some(electronics.psd_noise_counts),
            position_noise_m: None,
        },
    }
}

/// A whole recording: counts, tooth counts, temperature, commands, what the machine logs beside them and, if asked for, the reference.
pub fn record(courier: &mut Courier, plan: &Plan, with_reference: bool) -> Recording {
    let mut samples = Samples::default();
    let observations = observe(courier, plan);
    for observation in &observations {
        samples.push(&row(
            observation,
            &plan.runs[observation.run].name,
            with_reference,
        ));
    }
    if let Some((name, _)) = observations.first().and_then(|first| first.logged) {
        let value = |o: &Observation| o.logged.map_or(f64::NAN, |(_, value)| value);
        samples.log(Logged {
            name: name.into(),
            values: observations.iter().map(value).collect(),
        });
    }
    Recording {
        meta: meta(courier.spec()),
        samples,
        warnings: Vec::new(),
    }
}

fn row<'a>(observation: &Observation, run: &'a str, with_reference: bool) -> Row<'a> {
    let components = |pose: Pose| [pose.x_m, pose.y_m, pose.theta_rad].map(Some);
    let sample = &observation.sample;
    // A recorder writes zeros where the electrodes' sums say that no beacon is seen.
    let electrodes = if observation.truth.beacon_seen {
        sample.electrodes.map(f64::from)
    } else {
        [0.0; 4]
    };
    Row {
        t_s: observation.time_s,
        run,
        quadrature_counts: sample.quadrature.map(|pair| Some(pair.map(f64::from))),
        teeth: observation.teeth.map(Some),
        position_m: [None; 4],
        electrode_counts: Some(electrodes),
        temperature_c: Some(sample.temperature_c),
        commanded: components(observation.commanded),
        reference: if with_reference {
            components(observation.reference)
        } else {
            [None; 3]
        },
    }
}
