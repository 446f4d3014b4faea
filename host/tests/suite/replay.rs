//! `courier replay` on real recordings and on made ones.

use crate::common::{Ran, courier, shared};
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Normal};
use recording::{Electronics, Existing, Geometry, Meta, Recording, Row, Samples};
use serde_json::Value;
use std::f64::consts::TAU;

fn figures(value: &Value) -> [f64; 3] {
    ["raw_rms_m", "calibrated_rms_m", "batch_f64_rms_m"]
        .map(|key| value["held_out"][key].as_f64().unwrap())
}

/// Figure asked for: the incremental f32 solution within 1 % of batch f64 on held-out stretches. The published raw error
/// is 5.95 degrees rms, 16.5 µm as written there; a third of the motion is a sample of it.
#[test]
fn real_recordings_incremental_against_batch() {
    for (name, raw_range_m, calibrated_limit_m) in [
        ("ess-rotary-normal", 15.0e-6..18.5e-6, 9.0e-6),
        ("ess-rotary-drive-divided", 3.3e-6..4.0e-6, 3.6e-6),
    ] {
        let Some(path) = shared(name) else { continue };
        let told = courier(&["replay", path.to_str().unwrap(), "--json"]).json();
        let [raw_m, calibrated_m, batch_m] = figures(&told);
        println!("{name}: raw {raw_m:.3e}, equation (3) {calibrated_m:.3e}, batch {batch_m:.3e}");
        assert!((calibrated_m / batch_m - 1.0).abs() < 0.01);
        assert!(raw_range_m.contains(&raw_m), "{name}: raw {raw_m}");
        assert!(
            calibrated_m < calibrated_limit_m && calibrated_m < raw_m,
            "{name}: calibrated {calibrated_m}"
        );
    }
}

const PITCH_M: f64 = 1.016e-3;
const SPAN_M: f64 = 9.7e-3;

/// Correction e of a segment as a function of its output, equation (3): orders of equation (3), its own amplitudes and phases.
fn error_m(segment: usize, output_m: f64) -> f64 {
    let phase = TAU * output_m / PITCH_M;
    let shift = segment as f64;
    8.0e-6 * (phase + shift).sin()
        + 5.0e-6 * (2.0 * phase - shift).cos()
        + 3.0e-6 * (4.0 * phase + 2.0 * shift).sin()
}

/// Four segments over scattered poses as whole counts of 25000, with a reference.
fn scatter(noise_counts: f64) -> Recording {
    let mut samples = Samples::default();
    let mut generator = ChaCha8Rng::seed_from_u64(1);
    let noise = Normal::new(0.0, noise_counts).unwrap();
    // Weyl sequences: even cover of the poses.
    let weyl = |index: usize, step: f64| (index as f64 * step).fract();
    for index in 0..3000 {
        let pose = [
            10.0 * PITCH_M * weyl(index, 0.754_877_666),
            10.0 * PITCH_M * weyl(index, 0.569_840_290),
            (2.0 * weyl(index, 0.430_159_709) - 1.0) * 0.5_f64.to_radians(),
        ];
        let place_m = [
            pose[0] + 0.5 * SPAN_M * pose[2],
            pose[1] + 0.5 * SPAN_M * pose[2],
            pose[0] - 0.5 * SPAN_M * pose[2],
            pose[1] - 0.5 * SPAN_M * pose[2],
        ];
        let mut row = Row {
            t_s: index as f64,
            run: "scatter",
            reference: pose.map(Some),
            ..Row::default()
        };
        for (segment, place_m) in place_m.into_iter().enumerate() {
            // place = output + e(output), solved for the output: the slope of e is below 0.2.
            let output_m =
                (0..40).fold(place_m, |output_m, _| place_m - error_m(segment, output_m));
            let turns = output_m / PITCH_M;
            let (sine, cosine) = (TAU * turns).sin_cos();
            let pair =
                [sine, cosine].map(|part| (25_000.0 * part + noise.sample(&mut generator)).round());
            row.quadrature_counts[segment] = Some(pair);
            row.teeth[segment] = Some((turns - pair[0].atan2(pair[1]) / TAU).round() as i32);
        }
        samples.push(&row);
    }
    let electronics = Electronics {
        adc_bits: Some(16),
        amplitude_counts: Some(25_000.0),
        quadrature_noise_counts: Some(noise_counts),
        ..Electronics::default()
    };
    let geometry = Geometry {
        pitch_m: PITCH_M,
        span_m: Some(SPAN_M),
        lateral_m: Some(3.0e-3),
    };
    Recording {
        meta: Meta {
            device: "made".into(),
            source: "test".into(),
            names: recording::Names::default(),
            geometry,
            coordination: None,
            electronics,
        },
        samples,
        warnings: Vec::new(),
    }
}

/// Errors of equation (3)'s orders are gone from g_p and from the position, which was never fitted.
#[test]
fn four_segments_calibrate_each_other() {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("scatter");
    scatter(6.0).write(&path, Existing::Refuse).unwrap();
    let told = courier(&["replay", path.to_str().unwrap(), "--json"]).json();
    let [raw_m, calibrated_m, batch_m] = figures(&told);
    // Noise with that of rounding: pitch / (2 pi) * n / 25000 a segment, twice that in g_p, times the rms of 1 + de/dp.
    let noise_counts = (6.0_f64.powi(2) + 1.0 / 12.0).sqrt();
    let slope = (TAU / PITCH_M)
        * ((8.0e-6_f64.powi(2) + 10.0e-6_f64.powi(2) + 12.0e-6_f64.powi(2)) / 2.0).sqrt();
    let floor_m = 2.0 * PITCH_M / TAU * noise_counts / 25_000.0 * slope.hypot(1.0);
    println!("g_p: raw {raw_m:.3e}, equation (3) {calibrated_m:.3e}, noise floor {floor_m:.3e}");
    assert!(raw_m > 1.0e-5, "raw {raw_m}");
    assert!((calibrated_m / batch_m - 1.0).abs() < 0.01);
    assert!(
        (0.9..1.1).contains(&(calibrated_m / floor_m)),
        "calibrated {calibrated_m} over a floor of {floor_m}"
    );
    let positions = told["position"].as_array().unwrap();
    assert_eq!(positions.len(), 2);
    for position in positions {
        let [raw_m, calibrated_m] =
            ["raw_rms_m", "calibrated_rms_m"].map(|key| position[key].as_f64().unwrap());
        assert!(calibrated_m < 0.02 * raw_m, "{position}");
    }
}

/// A change of a row of this number.
type Change = fn(usize, &mut Row);

/// Replays a scatter of poses with every row changed.
fn replay_changed(name: &str, change: Change) -> Ran {
    let folder = tempfile::tempdir().unwrap();
    let wrong = scatter(6.0).with_rows(|index, row| {
        change(index, row);
        true
    });
    let path = folder.path().join(name);
    wrong.write(&path, Existing::Refuse).unwrap();
    courier(&["replay", path.to_str().unwrap(), "--json"])
}

/// Whatever is exchanged in the wiring, it is named and nothing is computed.
#[test]
fn a_wrong_wiring_is_refused() {
    let exchanged: [(&str, &str, Change); 4] = [
        ("one", "segments 1 and 3 are exchanged", |_, row| {
            row.quadrature_counts.swap(0, 2);
            row.teeth.swap(0, 2);
        }),
        ("two", "segments 1 and 2 are exchanged", |_, row| {
            row.quadrature_counts.swap(0, 1);
            row.teeth.swap(0, 1);
        }),
        ("three", "q1s and q1c are exchanged", |_, row| {
            row.quadrature_counts[0].as_mut().unwrap().swap(0, 1);
        }),
        ("four", "q4c has the wrong sign", |_, row| {
            let [_, cosine] = row.quadrature_counts[3].as_mut().unwrap();
            *cosine = -*cosine;
        }),
    ];
    for (name, wanted, exchange) in exchanged {
        replay_changed(name, exchange).refused(&[name, wanted]);
    }
}

/// Tooth counts that were lost are no wire's doing: what remains is told to be no error of a sensor, and the exit code is 1.
#[test]
fn a_residual_of_the_size_of_the_pitch_is_remarked_on() {
    let ran = replay_changed("lost", |index, row| {
        row.teeth[2] = row.teeth[2].map(|n| n + (index % 5) as i32);
    });
    assert_eq!(ran.code, 1, "{}", ran.err);
    assert!(ran.err.contains("of the pitch"), "{}", ran.err);
    let told = crate::common::json(&ran.out);
    assert_eq!(told["remarks"][0]["channel"], "g_p");
}

#[test]
fn what_cannot_be_replayed_is_said_in_one_line() {
    let folder = tempfile::tempdir().unwrap();
    let cases: [(&str, &str, &str); 4] = [
        (
            "alone",
            "t_s,p1_m\n0,0\n1,1e-4\n",
            "found neither four segments nor a reference",
        ),
        (
            "short",
            "t_s,p1_m,ref_x_m\n0,0,0\n1,1e-4,1e-4\n",
            "segment_1: found 1 samples to fit that move, wanted 18 or more for 9 parameters",
        ),
        (
            "still",
            &still(),
            "segment_1: found 1 samples to fit that move",
        ),
        ("corner", &corner(), "segment_1: the motion determines "),
    ];
    for (name, samples, wanted) in cases {
        let path = folder.path().join(name);
        std::fs::create_dir(&path).unwrap();
        std::fs::write(
            path.join("recording.toml"),
            "schema = 1\n[geometry]\npitch_m = 1e-3\n[electronics]\nposition_noise_m = 1e-8\n",
        )
        .unwrap();
        std::fs::write(path.join("samples.csv"), samples).unwrap();
        courier(&["replay", path.to_str().unwrap(), "--json"]).refused(&[wanted]);
    }
}

/// A thousand samples of one place.
fn still() -> String {
    (0..1000).fold("t_s,p1_m,ref_x_m\n".to_owned(), |text, index| {
        format!("{text}{index},1e-4,1e-4\n")
    })
}

/// A hundredth of a pitch, finely: the orders cannot be told apart there.
fn corner() -> String {
    (0..100).fold("t_s,p1_m,ref_x_m\n".to_owned(), |text, index| {
        let place_m = 1.0e-8 * f64::from(index) * 30.0;
        format!("{text}{index},{place_m:e},{place_m:e}\n")
    })
}
