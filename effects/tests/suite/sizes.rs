//! Each effect's realised rms against its stated size, over the motion that its file states, computed from what the hooks
//! do and not from the effect's own formula.

use effects::motion::{Motion, Pose};
use effects::plant::{
    Channels, Codes, Geometry, Instant, PlantEffect, SEGMENTS, Scene, SegmentPoint, Signal,
};
use effects::random::{ChaCha8Rng, SeedableRng, uniform};
use effects::{CATALOGUE, entry, unlisted};
use std::f64::consts::TAU;

const SIZE_M: f64 = 2.0e-6;
const SCENE: Scene = Scene {
    geometry: Geometry::PAPER,
    duration_s: 100.0,
    amplitude_counts: 20_000.0,
};

/// Straight motion at a constant velocity.
struct Cruise(Pose);

impl Motion for Cruise {
    fn pose(&self, time_s: f64) -> Pose {
        Pose::default().plus(self.0, time_s)
    }
}

fn drawn(name: &str, seed: u64) -> Box<dyn PlantEffect> {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let entry = entry(name).or_else(|| unlisted::UNLISTED.iter().find(|entry| entry.name == name));
    (entry.expect(name).draw)(&SCENE, &mut rng, SIZE_M)
}

fn instant<'a>(motion: &'a dyn Motion, time_s: f64, temperature_delta_k: f64) -> Instant<'a> {
    Instant {
        time_s,
        pose: motion.pose(time_s),
        temperature_delta_k,
        motion,
        geometry: &SCENE.geometry,
    }
}

/// A segment's whole displacement at an instant: through place, displacement, signals and converter.
fn displacement_m(effect: &mut dyn PlantEffect, at: &Instant) -> [f64; SEGMENTS] {
    let nominal = SCENE.geometry.points(at.pose);
    let mut points: [SegmentPoint; SEGMENTS] = nominal;
    effect.platen(at, &mut points);
    let added = effect.displacement_m(at, &points);
    let wavenumber = SCENE.geometry.wavenumber();
    let outputs: [f64; SEGMENTS] = std::array::from_fn(|s| points[s].own_m + added[s]);
    let mut signals = outputs.map(|p| {
        let (sine, cosine) = (wavenumber * p).sin_cos();
        Signal {
            phase_rad: wavenumber * p,
            sine,
            cosine,
        }
    });
    effect.signal(at, &mut signals);
    let quadrature = signals.map(|s| [s.sine, s.cosine].map(|v| v * SCENE.amplitude_counts));
    let mut channels = Channels {
        quadrature,
        electrodes: [15_000.0; 4],
        amplitude_counts: SCENE.amplitude_counts,
        psd_sum_counts: 30_000.0,
    };
    effect.analog(at, &mut channels);
    let whole = channels
        .quadrature
        .map(|pair| pair.map(|counts| counts.round() as i16));
    let mut codes = Codes {
        quadrature: whole,
        electrodes: [0; 4],
    };
    effect.codes(at, &mut codes);
    std::array::from_fn(|s| {
        let [sine, cosine] = codes.quadrature[s].map(f64::from);
        let phase = sine.atan2(cosine) - wavenumber * nominal[s].own_m;
        (phase - TAU * (phase / TAU).round()) / wavenumber
    })
}

fn rms(values: impl IntoIterator<Item = f64>) -> f64 {
    let (sum, count) = values
        .into_iter()
        .fold((0.0, 0.0), |(sum, count), v| (sum + v * v, count + 1.0));
    (sum / count).sqrt()
}

/// Rms over still poses uniform within `range` (x and y, metres; theta, radians), times and temperatures, pooled.
fn still_rms_m(effect: &mut dyn PlantEffect, range: Pose, warm_k: f64, centred: bool) -> f64 {
    let mut rng = ChaCha8Rng::seed_from_u64(99);
    let count = 20_000;
    let mut values: [Vec<f64>; SEGMENTS] = Default::default();
    for i in 0..count {
        let mut within = |half: f64| uniform(&mut rng, -half, half);
        let pose = Pose::new(
            within(range.x_m),
            within(range.y_m),
            within(range.theta_rad),
        );
        let temperature = uniform(&mut rng, 0.0, warm_k.max(1e-9));
        let at = instant(
            &pose,
            SCENE.duration_s * f64::from(i) / f64::from(count),
            temperature,
        );
        let displacement = displacement_m(effect, &at);
        values
            .iter_mut()
            .zip(displacement)
            .for_each(|(values, d)| values.push(d));
    }
    if centred {
        for values in &mut values {
            let mean = values.iter().sum::<f64>() / values.len() as f64;
            values.iter_mut().for_each(|v| *v -= mean);
        }
    }
    rms(values.into_iter().flatten())
}

/// Asserts that the size over all seeds is what was asked for: `tolerance` of each, a third of it on average.
fn assert_sizes(name: &str, tolerance: f64, realised: impl Fn(Box<dyn PlantEffect>) -> f64) {
    let seeds = 6;
    let ratios: Vec<f64> = (0..seeds)
        .map(|seed| realised(drawn(name, seed)) / SIZE_M)
        .collect();
    let mean = rms(ratios.iter().copied());
    assert!((mean - 1.0).abs() < tolerance, "{name}: {ratios:?}");
    assert!(
        ratios.iter().all(|r| (r - 1.0).abs() < 2.0 * tolerance),
        "{name}: {ratios:?}"
    );
    // Twice the size is twice the displacement (saturating effects to first order).
    let mut doubled = drawn(name, 0);
    doubled.scale(2.0);
    assert!(
        (realised(doubled) / SIZE_M / ratios[0] - 2.0).abs() < 0.05 + 2.0 * tolerance,
        "{name}: scale"
    );
}

const HALF_DEGREE: f64 = 0.5 * std::f64::consts::PI / 180.0;
const PLATEN: Pose = Pose::new(60e-3, 60e-3, HALF_DEGREE);

#[test]
fn effects_of_place_and_phase_have_their_stated_rms() {
    for name in [
        "lateral_dependence",
        "extra_harmonics",
        "angle_dependence",
        "adc_clipping",
        "span_error",
        "crosstalk",
        "subharmonic",
    ] {
        assert_sizes(name, 0.03, |mut effect| {
            still_rms_m(&mut *effect, PLATEN, 0.0, false)
        });
    }
    // A field is one draw over the platen.
    assert_sizes("tooth_variation", 0.06, |mut effect| {
        still_rms_m(&mut *effect, PLATEN, 0.0, false)
    });
    // Twelve waves over a finite platen: the realised flatness scatters.
    assert_sizes("gap_variation", 0.25, |mut effect| {
        still_rms_m(&mut *effect, Pose::new(0.3, 0.3, 0.0), 0.0, false)
    });
    assert_sizes("stray_field", 0.06, |mut effect| {
        still_rms_m(&mut *effect, Pose::new(30e-3, 30e-3, 0.0), 0.0, false)
    });
    // Lines that are askew shift a pair's segments apart as well, which their zeros take up.
    assert_sizes("axis_skew", 0.03, |mut effect| {
        still_rms_m(&mut *effect, Pose::new(5e-3, 5e-3, 0.0), 0.0, true)
    });
}

/// The drive's own field by what the drive logs: its current at rest is below that of a motion, and the size is that of an ampere.
#[test]
fn the_drive_s_field_has_its_stated_rms_for_an_ampere_of_what_is_logged() {
    let field = effects::effect("stray_field").expect("an effect");
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let mut drawn = field
        .draw_logged(&SCENE, &mut rng, SIZE_M)
        .expect("it follows a current");
    let current_a = |motion: &dyn Motion| {
        let logged = drawn.logged(&instant(motion, 1.0, 0.0));
        assert_eq!(logged.map(|l| l.0), Some("aux_motor_a"));
        logged.map_or(0.0, |l| l.1)
    };
    let [rest_a, slow_a, fast_a] =
        [0.0, 0.01, 0.2].map(|speed| current_a(&Cruise(Pose::new(speed, 0.0, 0.0))));
    assert!(
        rest_a < slow_a && slow_a < fast_a,
        "{rest_a}, {slow_a}, {fast_a}"
    );
    // At rest 0.7 A are missing of the current about which the field is told.
    let rest_m = still_rms_m(&mut *drawn, PLATEN, 0.0, false);
    let stated_m = SIZE_M * 0.7;
    assert!((rest_m / stated_m - 1.0).abs() < 0.03, "{rest_m}");
    let others = CATALOGUE.iter().filter(|entry| entry.name != "stray_field");
    for entry in others {
        let effect = effects::effect(entry.name).expect("an effect");
        assert!(effect.draw_logged(&SCENE, &mut rng, SIZE_M).is_none());
    }
}

#[test]
fn effects_of_time_and_temperature_have_their_stated_rms() {
    assert_sizes("excess_noise", 0.03, |mut effect| {
        still_rms_m(&mut *effect, PLATEN, 0.0, false)
    });
    // A dozen steps over the amplitude: rounding is not quite uniform.
    assert_sizes("missing_codes", 0.1, |mut effect| {
        still_rms_m(&mut *effect, PLATEN, 0.0, false)
    });

    assert_sizes("quadrature_drift", 0.06, |mut effect| {
        still_rms_m(&mut *effect, PLATEN, 0.0, false)
    });
    assert_sizes("thermal_drift", 0.03, |mut effect| {
        still_rms_m(&mut *effect, Pose::default(), 4.0, true)
    });
    // Few and strong: the sum over 100 s scatters.
    assert_sizes("outlier_bursts", 0.6, |mut effect| {
        still_rms_m(&mut *effect, PLATEN, 0.0, false)
    });
}

#[test]
fn effects_of_speed_have_their_stated_rms() {
    let both = |speed: f64| Cruise(Pose::new(speed, speed, 0.0));
    let at_speed = |mut effect: Box<dyn PlantEffect>, speed: f64| {
        let motion = both(speed);
        let values: Vec<_> = (500..4000)
            .map(|i| displacement_m(&mut *effect, &instant(&motion, f64::from(i) * 1e-3, 0.0)))
            .collect();
        rms(values.into_iter().flatten())
    };
    assert_sizes("velocity_lag", 0.03, |effect| at_speed(effect, 50e-3));
    assert_sizes("hysteresis", 0.03, |effect| at_speed(effect, 10e-3));
    // Speed along x and y together is the root of two times either.
    assert_sizes("mains_pickup", 0.03, |effect| {
        at_speed(effect, 50e-3 / 2.0_f64.sqrt())
    });
}

#[test]
fn a_lag_reverses_with_the_direction_and_hysteresis_forgets_the_speed() {
    let mean = |name: &str, speed: f64| {
        let mut effect = drawn(name, 3);
        let motion = Cruise(Pose::new(speed, 0.0, 0.0));
        let values: Vec<_> = (500..1500)
            .map(|i| displacement_m(&mut *effect, &instant(&motion, f64::from(i) * 1e-3, 0.0))[0])
            .collect();
        values.iter().sum::<f64>() / 1000.0
    };
    assert!((mean("velocity_lag", 20e-3) + mean("velocity_lag", -20e-3)).abs() < 1e-9);
    assert!(mean("velocity_lag", 5e-3).abs() < 0.4 * mean("velocity_lag", 20e-3).abs());
    assert!((mean("hysteresis", 5e-3) / mean("hysteresis", 40e-3) - 1.0).abs() < 0.02);
    assert!((mean("hysteresis", 5e-3) + mean("hysteresis", -5e-3)).abs() < 1e-9);
}

/// Rms of an axis' displacement by the coordination sensor's hooks over +-0.8 of full scale.
fn deflection_rms_m(effect: &mut dyn PlantEffect) -> f64 {
    let full_m = SCENE.geometry.height_m * SCENE.geometry.tan_full_scale;
    let mut values = [Vec::new(), Vec::new()];
    let still = Pose::default();
    for i in 0..=80 {
        for j in 0..=80 {
            let at = instant(&still, f64::from(81 * i + j) * 0.013, 0.0);
            let place = |i: i32| 0.8 * (f64::from(i) / 40.0 - 1.0);
            let mut u = [place(i), place(j)];
            effect.deflection(&at, &mut u);
            let beacon = effect.beacon_m(&at);
            let error = [u[0] - place(i), u[1] - place(j)];
            (0..2).for_each(|axis| values[axis].push(error[axis] * full_m + beacon[axis]));
        }
    }
    rms(values.into_iter().flatten())
}

/// The same without the mean and without the turn that fits best, which equation (11) takes up.
fn unturned_rms_m(effect: &mut dyn PlantEffect) -> f64 {
    let full_m = SCENE.geometry.height_m * SCENE.geometry.tan_full_scale;
    let still = Pose::default();
    let mut pairs = Vec::new();
    for i in -40..=40 {
        for j in -40..=40 {
            let place = [i, j].map(|k| 0.8 * f64::from(k) / 40.0);
            let mut u = place;
            effect.deflection(&instant(&still, 0.0, 0.0), &mut u);
            pairs.push((place, [0, 1].map(|axis| u[axis] - place[axis])));
        }
    }
    let count = pairs.len() as f64;
    let mean = [0, 1].map(|axis| pairs.iter().map(|p| p.1[axis]).sum::<f64>() / count);
    let across = |place: &[f64; 2]| [-place[1], place[0]];
    let along = |p: &([f64; 2], [f64; 2])| {
        let across = across(&p.0);
        across[0] * p.1[0] + across[1] * p.1[1]
    };
    let squares: f64 = pairs.iter().flat_map(|p| p.0).map(|v| v * v).sum();
    let turn = pairs.iter().map(along).sum::<f64>() / squares;
    rms(pairs.iter().flat_map(|(place, error)| {
        let across = across(place);
        [0, 1].map(|axis| (error[axis] - mean[axis] - turn * across[axis]) * full_m)
    }))
}

#[test]
fn effects_of_the_coordination_sensor_have_their_stated_rms() {
    assert_sizes("psd_nonlinearity", 0.05, |mut effect| {
        deflection_rms_m(&mut *effect)
    });
    assert_sizes("psd_misalignment", 0.05, |mut effect| {
        unturned_rms_m(&mut *effect)
    });
    assert_sizes("beacon_vibration", 0.05, |mut effect| {
        deflection_rms_m(&mut *effect)
    });
    assert_sizes("psd_latency", 1e-9, |effect| {
        effect.coordination_delay_s().abs() * 20e-3
    });
}

#[test]
fn unlisted_effects_have_their_stated_rms() {
    assert_sizes("reference_mirror", 0.03, |mut effect| {
        let mut values = [Vec::new(), Vec::new()];
        for i in 0..4000 {
            let mut pose = Pose::default();
            let still = Pose::default();
            effect.reference(&instant(&still, 0.0, f64::from(i) * 1e-3), &mut pose);
            values[0].push(pose.x_m);
            values[1].push(pose.y_m);
        }
        let mean = |values: &[f64]| values.iter().sum::<f64>() / values.len() as f64;
        rms(values
            .iter()
            .flat_map(|axis| axis.iter().map(|v| v - mean(axis)).collect::<Vec<_>>()))
    });
    // To first order in the light's share.
    assert_sizes("ambient_light", 0.05, |mut effect| {
        let mut electrodes = [0.75, 0.25, 0.75, 0.25].map(|share| share * 30_000.0);
        let mut channels = Channels {
            electrodes,
            psd_sum_counts: 30_000.0,
            ..Channels::default()
        };
        let still = Pose::default();
        effect.analog(&instant(&still, SCENE.duration_s, 0.0), &mut channels);
        electrodes = channels.electrodes;
        let axis = |a: f64, b: f64| {
            ((a - b) / (a + b) - 0.5) * SCENE.geometry.height_m * SCENE.geometry.tan_full_scale
        };
        rms([
            axis(electrodes[0], electrodes[1]),
            axis(electrodes[2], electrodes[3]),
        ])
    });
    // The highest rms over a second at any speed.
    assert_sizes("tooth_resonance", 0.05, |mut effect| {
        let at_speed = |speed: f64| {
            let motion = Cruise(Pose::new(speed, 0.0, 0.0));
            let values: Vec<_> = (0..2000)
                .map(|i| {
                    displacement_m(
                        &mut *effect,
                        &instant(&motion, speed * 1e5 + f64::from(i) * 1e-3, 0.0),
                    )
                })
                .collect();
            rms(values[1000..].iter().flatten().copied())
        };
        (30..120)
            .map(|i| f64::from(i) * 0.5e-3)
            .map(at_speed)
            .fold(0.0, f64::max)
    });
    // A wander of metres over half a square metre: the cable's pull takes every direction.
    assert_sizes("cable_drag", 0.6, |mut effect| {
        let mut values = Vec::new();
        for i in 0..200_000 {
            let t = f64::from(i) * 1e-4;
            let still = Pose::new(
                0.2 * (3.1 * t).sin() + 0.15 * (1.7 * t).cos(),
                0.25 * (2.3 * t).sin(),
                0.0,
            );
            values.push(displacement_m(&mut *effect, &instant(&still, t, 0.0)));
        }
        rms(values.into_iter().flatten())
    });
}

#[test]
fn a_slip_is_whole_teeth_from_a_moment_on() {
    for seed in 0..50 {
        let mut effect = drawn("cycle_slip", seed);
        let still = Pose::default();
        let teeth: Vec<_> = (0..1000)
            .map(|i| effect.teeth(&instant(&still, f64::from(i) * 0.1, 0.0)))
            .collect();
        assert_eq!(teeth[0], [0; 4]);
        assert_ne!(teeth[999], [0; 4]);
        let changes = teeth.windows(2).filter(|pair| pair[0] != pair[1]).count();
        assert!((1..=2).contains(&changes));
    }
}

#[test]
fn the_same_seed_draws_the_same_effect_and_another_a_different_one() {
    for entry in CATALOGUE.iter().chain(unlisted::UNLISTED) {
        let trace = |seed: u64| {
            let mut effect = drawn(entry.name, seed);
            let motion = Cruise(Pose::new(30e-3, 20e-3, 1e-3));
            let mut trace = vec![effect.coordination_delay_s()];
            for i in 0..2000 {
                let at = instant(&motion, f64::from(i) * 0.05, f64::from(i) * 1e-3);
                trace.extend(displacement_m(&mut *effect, &at));
                let (mut u, mut pose) = ([0.3, -0.5], Pose::default());
                effect.deflection(&at, &mut u);
                effect.reference(&at, &mut pose);
                trace.extend(u.into_iter().chain(effect.beacon_m(&at)).chain([pose.x_m]));
                trace.extend(effect.teeth(&at).map(f64::from));
                let mut channels = Channels {
                    electrodes: [1e4; 4],
                    psd_sum_counts: 2e4,
                    ..Channels::default()
                };
                effect.analog(&at, &mut channels);
                trace.extend(channels.electrodes);
                let mut codes = Codes {
                    quadrature: [[12_345, -6_789]; 4],
                    ..Default::default()
                };
                effect.codes(&at, &mut codes);
                trace.extend(
                    codes
                        .quadrature
                        .as_flattened()
                        .iter()
                        .map(|c| f64::from(*c)),
                );
            }
            trace
        };
        assert_eq!(trace(5), trace(5), "{}", entry.name);
        assert!(
            (6..16).any(|seed| trace(seed) != trace(5)),
            "{}",
            entry.name
        );
    }
}

#[test]
fn the_names_of_the_contract_stand_first() {
    let names: Vec<_> = CATALOGUE.iter().map(|entry| entry.name).collect();
    let wanted = "lateral_dependence extra_harmonics tooth_variation angle_dependence psd_nonlinearity psd_misalignment \
                  thermal_drift velocity_lag psd_latency hysteresis gap_variation beacon_vibration axis_skew cycle_slip \
                  outlier_bursts excess_noise adc_clipping quadrature_drift span_error";
    let wanted: Vec<&str> = wanted.split_whitespace().collect();
    assert_eq!(names[..wanted.len()], wanted);
}
