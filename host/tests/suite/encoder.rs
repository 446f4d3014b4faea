//! `courier encoder`: the example's log without its reference, the forms, what it refuses.

use crate::common::{asked, json};
use std::path::Path;

/// The example's log beside the working folder, with the options that name its columns.
fn with_log(words: &str) -> (tempfile::TempDir, String) {
    let folder = tempfile::tempdir().unwrap();
    let log = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/encoder-log/log.csv");
    std::fs::copy(log, folder.path().join("log.csv")).unwrap();
    (
        folder,
        format!(
            "encoder log.csv --column t_s=time:ms --column q1s=sin --column q1c=cos --pitch 1.016mm {words}"
        ),
    )
}

/// What `courier replay` finds with the stage for a reference (docs/your-sensor.md: 7.34 µm raw), this finds without: orders 1, 2, 4, 6
/// alone are in the simulated encoder.
#[test]
fn the_examples_log_tells_its_encoder_without_the_stage() {
    let (folder, line) = with_log("--out e.json --json");
    let answer = json(&asked(folder.path(), &line).quiet());
    let size = |order: usize| {
        let of = &answer["harmonics"][order - 1];
        of["sine_m"]
            .as_f64()
            .unwrap()
            .hypot(of["cosine_m"].as_f64().unwrap())
    };
    for order in [1, 2, 4, 6] {
        assert!(size(order) > 1.0e-6, "{answer:#}");
    }
    for order in [3, 5, 7, 8] {
        assert!(size(order) < 0.1e-6, "{answer:#}");
    }
    // The whole: the stage's 7.34 µm, of which the lag at both speeds takes a part.
    let whole = (1..=8)
        .map(|order| 0.5 * size(order).powi(2))
        .sum::<f64>()
        .sqrt();
    assert!((whole / 7.34e-6 - 1.0).abs() < 0.1, "{whole}");
    // The calibration can be read again, and told.
    let worth = asked(folder.path(), "compare e.json --budget --json").quiet();
    assert!(worth.contains("budget"), "{worth}");
}

/// A log that SimpleFOC's own loop printed, of a motor that was simulated: its sensor reads 0.02 sin(shaft - 0.7) rad too much
/// (convert/tests/files/monitor.cpp), a turn is written as a millimetre.
#[test]
fn an_eccentric_magnet_comes_out_of_a_log_of_simplefoc() {
    let folder = tempfile::tempdir().unwrap();
    let log =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../convert/tests/files/simplefoc-loop.log");
    std::fs::copy(log, folder.path().join("loop.log")).unwrap();
    let line = "encoder loop.log --rate-hz 50 --column p1_m=#3:rad --json";
    let answer = json(&asked(folder.path(), line).quiet());
    let off = 0.02 / std::f64::consts::TAU * 1.0e-3;
    let first = &answer["harmonics"][0];
    let stated = first["deviation_m"].as_f64().unwrap();
    // Added to the place: minus what is read too much.
    for (part, wanted) in [
        ("sine_m", -off * 0.7_f64.cos()),
        ("cosine_m", off * 0.7_f64.sin()),
    ] {
        let found = first[part].as_f64().unwrap();
        assert!(
            (found - wanted).abs() < 3.0 * stated,
            "{part}: {found} for {wanted}, stated {stated}"
        );
    }
    assert!(stated < 0.01 * off, "{stated}");
}

/// A shaft of eight periods a turn whose scale is off centre: the place is read 20 µm too far, and too short, once a turn.
#[test]
fn a_calibration_says_that_it_leaves_the_orders_of_the_turn_out() {
    let folder = tempfile::tempdir().unwrap();
    let mut log = String::from("sin,cos\n");
    let mut noise = 1_u32;
    for k in 0..4000 {
        let turns = f64::from(k) / 500.0;
        let periods = 8.0 * turns + 0.02 * (std::f64::consts::TAU * turns).sin();
        let (sine, cosine) = (std::f64::consts::TAU * periods).sin_cos();
        let counts = [sine, cosine].map(|signal| {
            noise = noise.wrapping_mul(1_664_525).wrapping_add(1_013_904_223);
            8000.0 * signal + 4.0 * (f64::from(noise) / f64::from(u32::MAX) - 0.5)
        });
        log += &format!("{:.0},{:.0}\n", counts[0], counts[1]);
    }
    std::fs::write(folder.path().join("log.csv"), log).unwrap();
    let line = "encoder log.csv --rate-hz 1000 --column q1s=sin --column q1c=cos --pitch 1mm --periods-per-turn 8 --json";
    let answer = json(&asked(folder.path(), line).quiet());
    let orders = answer["turn"]["orders"].as_array().unwrap().len();
    assert!(orders > 0, "{answer:#}");
    let kept = asked(folder.path(), &format!("{line} --out e.json"));
    assert_eq!(
        (kept.code, kept.err),
        (
            0,
            format!(
                "courier: warning: e.json: without the {orders} orders of the turn, since a calibration knows one signal period; --form c or simplefoc has them\n"
            )
        )
    );
    assert!(folder.path().join("e.json").is_file());
}

#[test]
fn constants_come_in_each_form() {
    for (form, part) in [
        ("c", "encoder_phase_rad"),
        ("moteus", "compensation_table.255"),
        ("simplefoc", "calibration_lut[200]"),
    ] {
        let (folder, line) = with_log(&format!("--form {form}"));
        let text = asked(folder.path(), &line).quiet();
        assert!(text.contains(part), "{form}: {text}");
    }
}

#[test]
fn what_cannot_be_learned_from_is_refused_in_one_line() {
    let (folder, line) = with_log("--segment 2");
    asked(folder.path(), &line).refused(&[
        "log.csv",
        "found no output of segment 2",
        "q2s and q2c",
    ]);
    let (folder, line) = with_log("--form c --json");
    asked(folder.path(), &line).refused(&["--form", "--json"]);
    let short: String = std::fs::read_to_string(folder.path().join("log.csv"))
        .unwrap()
        .lines()
        .take(500)
        .map(|line| format!("{line}\n"))
        .collect();
    std::fs::write(folder.path().join("log.csv"), short).unwrap();
    let (_, line) = with_log("--out e.json");
    asked(folder.path(), &line).refused(&["log.csv", "no whole circle", "over several periods"]);
    assert!(!folder.path().join("e.json").exists());
}
