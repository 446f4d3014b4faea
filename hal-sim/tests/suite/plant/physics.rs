//! Physics checks: counts to pose by equations (3), (4), (10) and (11), compared with the truth that the counts came from.

use super::batch::{self, Platen, Reading, SIGNS, deviation, reading};
use effects::motion::{Motion, Pose};
use effects::plant::Geometry;
use hal_sim::coordination::origin_under;
use hal_sim::courier::Courier;
use hal_sim::electronics::Electronics;
use hal_sim::presets::ideal;
use hal_sim::record::{Observation, observe, record};
use hal_sim::spec::CourierSpec;
use hal_sim::trajectory::{OpenLoop, Plan};
use hal_sim::waveform::Waveform;
use std::cell::Cell;

const GEOMETRY: Geometry = Geometry::PAPER;

fn plan(poses: usize, seed: u64) -> Plan {
    Plan::usual(
        poses,
        GEOMETRY,
        &Default::default(),
        OpenLoop::COURIER,
        seed,
    )
}

fn observed(spec: CourierSpec, poses: usize, seed: u64) -> (Vec<Observation>, Vec<Reading>) {
    let mut courier = Courier::new(spec, seed).unwrap();
    let observations = observe(&mut courier, &plan(poses, seed));
    let readings = observations.iter().map(|o| reading(o, &GEOMETRY)).collect();
    (observations, readings)
}

/// The true coefficients as a calibration would hold them.
fn truth(spec: &CourierSpec) -> Platen {
    let mut platen = Platen::NONE;
    let mut offsets = [0.0; 4];
    for (s, waveform) in spec.waveforms.iter().enumerate() {
        let Waveform::Equation3(k) = waveform else {
            unreachable!("ideal is equation (3)")
        };
        platen.k[s][..8].copy_from_slice(&k[1..]);
        offsets[s] = k[0];
    }
    platen.parity_offset = (0..4).map(|s| SIGNS[s] * offsets[s]).sum();
    platen.angle_offset =
        (offsets[0] - offsets[2] + offsets[1] - offsets[3]) / (2.0 * GEOMETRY.span_m);
    platen
}

#[test]
fn equation_3_added_to_the_counts_is_the_truth_to_the_noise() {
    let spec = ideal(11);
    let platen = truth(&spec);
    let (observations, readings) = observed(spec, 400, 3);
    let noise_m = 20.0 / 20_000.0 / GEOMETRY.wavenumber();
    let error = |column: usize, of: fn(Pose) -> f64| {
        let pairs = observations.iter().zip(&readings);
        let error = pairs.map(|(o, r)| {
            batch::pose(&batch::calibrated(r, &platen, &GEOMETRY), &GEOMETRY)[column]
                - of(o.truth.pose)
        });
        deviation(error)
    };
    // The mean of two segments, and their difference over the span; the slope 1 + de/dp scales the noise by up to tens of percent.
    let (mean_m, angle_rad) = (
        noise_m / 2.0_f64.sqrt(),
        noise_m * 2.0_f64.sqrt() / GEOMETRY.span_m,
    );
    for (column, of, floor) in [
        (0, (|p| p.x_m) as fn(Pose) -> f64, mean_m),
        (1, |p| p.y_m, mean_m),
        (2, |p| p.theta_rad, angle_rad),
        (3, |p| p.theta_rad, angle_rad),
    ] {
        let ratio = error(column, of) / floor;
        assert!((0.9..1.4).contains(&ratio), "column {column}: {ratio}");
    }
}

#[test]
fn without_noise_the_parity_and_equation_11_close() {
    let spec = CourierSpec {
        electronics: Electronics::BOARD.quiet(),
        ..ideal(12)
    };
    let platen = truth(&spec);
    let (observations, readings) = observed(spec, 300, 4);
    let origin = origin_under(&GEOMETRY, Pose::default());
    let mount = [
        GEOMETRY.height_m,
        GEOMETRY.lever_m[0],
        GEOMETRY.lever_m[1],
        origin[0],
        origin[1],
    ];
    // A count's rounding, 0.29 of 20 000, is 2.3 nm of a segment; four of them, and the calibration's slope.
    let parity_m = deviation(
        readings
            .iter()
            .map(|r| batch::pose(&batch::calibrated(r, &platen, &GEOMETRY), &GEOMETRY)[4]),
    );
    assert!(parity_m < 10e-9, "{parity_m}");
    let seen: Vec<_> = observations
        .iter()
        .zip(&readings)
        .filter(|(o, _)| o.truth.beacon_seen)
        .map(|(_, r)| r)
        .collect();
    assert!(seen.len() > 300);
    for axis in 0..2 {
        let g = deviation(
            seen.iter()
                .map(|r| batch::constraint(r, &platen, &mount, &GEOMETRY)[axis]),
        );
        // An electrode's rounding, 0.29 counts of 30 000, is 68 nm of c at the centre and 87 nm at 0.8 of full scale; the
        // angle's, through l_x = 90 mm, 21 nm; a
        // courier that stands still repeats one rounding, up to sqrt(3) times its rms.
        assert!(g < 3.0_f64.sqrt() * 90e-9, "axis {axis}: {g}");
    }
}

#[test]
fn the_same_seed_gives_the_same_recording_and_another_does_not() {
    let make = |seed: u64| {
        record(
            &mut Courier::new(ideal(1), seed).unwrap(),
            &plan(30, 7),
            true,
        )
    };
    assert_eq!(make(5), make(5));
    assert_ne!(make(5), make(6));
}

#[test]
fn a_recording_is_valid_to_the_letter() {
    let folder = tempfile::tempdir().unwrap();
    let recording = record(&mut Courier::new(ideal(1), 1).unwrap(), &plan(40, 7), true);
    recording
        .write(folder.path().join("r"), recording::Existing::Refuse)
        .unwrap();
    let back = recording::Recording::read(folder.path().join("r")).unwrap();
    assert_eq!(back.samples.len(), recording.samples.len());
    assert!(back.warnings.is_empty(), "{:?}", back.warnings);
    assert!(back.samples.stretches().len() >= 10);
}

/// Counts how often the motion is asked.
struct Counted<'a>(&'a dyn Motion, Cell<u64>);

impl Motion for Counted<'_> {
    fn pose(&self, time_s: f64) -> Pose {
        self.1.set(self.1.get() + 1);
        self.0.pose(time_s)
    }
}

#[test]
fn a_sample_asks_for_one_pose_however_long_the_courier_runs() {
    let plan = plan(50, 1);
    let motion = Counted(&plan.schedule, Cell::new(0));
    let mut courier = Courier::new(ideal(1), 1).unwrap();
    for i in 0..5000 {
        courier.counts_at(&motion, f64::from(i) * 1e-3);
        assert_eq!(motion.1.get(), i as u64 + 1);
    }
}

#[test]
fn noise_is_white_and_as_stated() {
    let mut courier = Courier::new(CourierSpec::flawless(), 2).unwrap();
    let still = Pose::new(1.1e-3, 2.3e-3, 0.0);
    let samples: Vec<_> = (0..20_000)
        .map(|i| courier.counts_at(&still, f64::from(i) * 5e-5))
        .collect();
    for s in 0..4 {
        for channel in 0..2 {
            let values: Vec<_> = samples
                .iter()
                .map(|x| f64::from(x.quadrature[s][channel]))
                .collect();
            let rms = deviation(values.iter().copied());
            let steps = deviation(values.windows(2).map(|pair| pair[1] - pair[0]));
            assert!((rms / 20.0 - 1.0).abs() < 0.03, "{rms}");
            assert!((steps / rms / 2.0_f64.sqrt() - 1.0).abs() < 0.03);
        }
        let electrode = deviation(samples.iter().map(|x| f64::from(x.electrodes[s])));
        // Rounding adds 1/12.
        assert!(
            (electrode / (4.0 + 1.0 / 12.0_f64).sqrt() - 1.0).abs() < 0.03,
            "{electrode}"
        );
    }
}

#[test]
fn electrodes_sum_to_the_stated_counts_and_vanish_without_a_beacon() {
    let spec = CourierSpec {
        electronics: Electronics::BOARD.quiet(),
        ..CourierSpec::flawless()
    };
    let mut courier = Courier::new(spec, 1).unwrap();
    let sums = |courier: &mut Courier, pose: Pose, time_s: f64| {
        let [a, b, c, d] = courier.counts_at(&pose, time_s).electrodes.map(i32::from);
        [a + b, c + d]
    };
    let inside = sums(&mut courier, Pose::new(2e-3, -3e-3, 5e-3), 0.0);
    assert!(
        inside.iter().all(|sum| (sum - 30_000).abs() <= 1),
        "{inside:?}"
    );
    assert_eq!(sums(&mut courier, Pose::new(20e-3, 0.0, 0.0), 0.1), [0, 0]);
    courier.set_beacon(None);
    assert_eq!(sums(&mut courier, Pose::default(), 0.2), [0, 0]);
}

#[test]
fn the_converter_saturates_instead_of_wrapping() {
    let mut spec = CourierSpec::flawless();
    spec.electronics.amplitude_counts = 50_000.0;
    let mut courier = Courier::new(spec, 1).unwrap();
    let quarter = Pose::new(0.25 * GEOMETRY.pitch_m, 0.0, 0.0);
    let sample = courier.counts_at(&quarter, 0.0);
    assert_eq!(sample.quadrature[0][0], i16::MAX);
    assert_eq!(sample.quadrature[1][1], i16::MAX);
}

#[test]
fn open_loop_misses_by_tens_of_micrometres_and_then_stands_still() {
    let plan = plan(300, 9);
    let misses: Vec<Pose> = plan.runs[0]
        .times_s
        .iter()
        .map(|&t| plan.pose(t).plus(plan.schedule.commanded(t), -1.0))
        .collect();
    for axis in [|p: &Pose| p.x_m, |p: &Pose| p.y_m] {
        let rms = (misses.iter().map(|p| axis(p).powi(2)).sum::<f64>() / 300.0).sqrt();
        assert!((3e-6..80e-6).contains(&rms), "{rms}");
    }
    let t = plan.runs[0].times_s[5];
    let moved = plan.pose(t - 0.005).plus(plan.pose(t), -1.0);
    assert!(moved.x_m.hypot(moved.y_m) < 50e-9, "{moved:?}");
}

#[test]
fn a_spin_keeps_the_coordination_sensor_in_its_place() {
    let plan = Plan::usual(5, GEOMETRY, &Default::default(), OpenLoop::EXACT, 1);
    let origin = origin_under(&GEOMETRY, Pose::default());
    let spin = plan.runs.iter().find(|run| run.name == "spin").unwrap();
    let angles: Vec<f64> = spin
        .times_s
        .iter()
        .map(|&t| plan.pose(t).theta_rad)
        .collect();
    assert!((angles.last().unwrap() - angles[0] - 2.4_f64.to_radians()).abs() < 1e-4);
    for &t in &spin.times_s {
        let deflection = hal_sim::coordination::deflection(&GEOMETRY, origin, plan.pose(t));
        assert!(deflection.iter().all(|u| u.abs() < 1e-9), "{deflection:?}");
    }
}
