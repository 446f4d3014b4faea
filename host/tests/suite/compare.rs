//! `courier compare`: what it tells of calibrations, and what it refuses.

use crate::common::{Ran, courier_in};
use courier::calibration_file::CalibrationFile;
use courier_sensor::calibration::record::{Beacon, Calibration, Gauge, Method};
use courier_sensor::device::Device;
use courier_sensor::geometry::Geometry;
use courier_sensor::model::{ErrorModel, Term, TermTable};
use std::path::Path;

/// A platen calibration of 1000 poses at the paper's motion with 1 µm left; sine and cosine of order 1 of segment 1 as given, metres.
fn calibration(order_1_m: [f32; 2]) -> Calibration {
    let mut calibration = Calibration::identity(Geometry::PAPER);
    calibration.model = ErrorModel::zero(TermTable::equation_3());
    calibration.model.coefficients[0][0] = order_1_m;
    calibration.amplitude_counts = [20_000.0; 4];
    calibration.device = Device(*b"paper-000001");
    let quality = &mut calibration.quality;
    (quality.poses, quality.unknowns, quality.rank) = (1000, 33, 33);
    (quality.residual_after_m, quality.predicted_worst_m) = (1.0e-6, 0.19e-6);
    calibration
}

fn write(folder: &Path, name: &str, calibration: Calibration) {
    let text = CalibrationFile::new(calibration).to_json().unwrap();
    std::fs::write(folder.join(name), text).unwrap();
}

/// A folder with three calibrations, of which the second differs by a third of a micrometre and the third by three.
fn folder() -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    for (name, size_m) in [
        ("a.json", 10.0e-6),
        ("b.json", 10.1e-6),
        ("c.json", 13.0e-6),
    ] {
        write(folder.path(), name, calibration([size_m, -4.0e-6]));
    }
    folder
}

fn compare(folder: &Path, words: &str) -> Ran {
    let words: Vec<&str> = ["compare"].into_iter().chain(words.split(' ')).collect();
    courier_in(folder, &words)
}

#[test]
fn a_change_is_told_with_its_term_its_size_and_its_place() {
    let folder = folder();
    let told = compare(folder.path(), "a.json c.json --json").json();
    let pair = &told["differences"][0];
    assert_eq!(pair["changed"], true, "{pair}");
    assert_eq!(pair["test"]["known"]["directions"], 32, "{pair}");
    assert_eq!(pair["terms"][0]["name"], "order 1, segment 1", "{pair}");
    assert_eq!(pair["terms"][0]["changed"], true);
    assert_eq!(pair["terms"][1]["changed"], false);
    // Half of 3 µm, at a quarter of a tooth; seen by segment 1 through half the span at the largest angle.
    let x = &pair["largest"][0];
    assert!(
        (x["value"].as_f64().unwrap().abs() / 1.5e-6 - 1.0).abs() < 0.01,
        "{x}"
    );
    assert_eq!(x["changed"], true);
    assert!(
        pair["largest"][1]["value"].as_f64().unwrap().abs() < 1.0e-9,
        "{pair}"
    );
    let text = compare(folder.path(), "a.json c.json").quiet();
    for word in [
        "changed beyond chance",
        "order 1, segment 1",
        "3.00 µm",
        "32 directions",
        "gauge",
    ] {
        assert!(text.contains(word), "{word}: {text}");
    }
    let text = compare(folder.path(), "a.json b.json").quiet();
    assert!(
        text.contains("b.json against a.json: no change beyond chance"),
        "{text}"
    );
}

#[test]
fn three_have_a_trend() {
    let folder = folder();
    let told = compare(folder.path(), "a.json b.json c.json --json").json();
    assert_eq!(told["differences"].as_array().unwrap().len(), 2);
    let line = &told["trend"]["known"];
    assert_eq!(
        (line["over"].as_str(), line["changes"].as_bool()),
        (Some("order"), Some(true)),
        "{line}"
    );
    // 0, 0.1 and 3 µm over 0, 1 and 2: 1.5 a step.
    assert!(
        (line["terms"][0]["change"].as_f64().unwrap() / 1.5e-6 - 1.0).abs() < 0.01,
        "{line}"
    );
    let text = compare(folder.path(), "a.json b.json c.json").quiet();
    assert!(
        text.contains("trend a step: a slope beyond chance"),
        "{text}"
    );
}

#[test]
fn repeats_tell_what_chance_is() {
    let folder = folder();
    let text = compare(folder.path(), "a.json b.json c.json --repeats 2").quiet();
    assert!(
        text.contains("repeats scatter about their mean") && text.contains("raised by 1.00"),
        "{text}"
    );
    // With all three as repeats of one state nothing has changed.
    let told = compare(folder.path(), "a.json b.json c.json --repeats 3 --json").json();
    assert!(
        told["repeats"]["known"]["raised"].as_f64().unwrap() > 2.0,
        "{told}"
    );
    assert_eq!(told["differences"][1]["changed"], false, "{told}");
}

#[test]
fn a_budget_lists_its_contributions() {
    let folder = folder();
    let words = "a.json --budget --at 50.8,0,0 --within-k 2 --teeth-um 0.5 --json";
    let told = compare(folder.path(), words).json();
    let budget = &told["budgets"][0]["known"]["budgets"][0];
    let list = budget["contributions"].as_array().unwrap();
    let of = |name: &str| {
        list.iter()
            .find(|of| of["name"].as_str().unwrap().contains(name))
            .unwrap()
    };
    assert_eq!(
        (
            of("teeth")["kind"].as_str(),
            of("readings")["kind"].as_str()
        ),
        (Some("B"), Some("A"))
    );
    // 50.8 mm of steel within 2 K.
    let expansion = of("temperature")["contribution"].as_f64().unwrap();
    assert!(
        (expansion / (50.8e-3 * 11.5e-6 * 2.0 / 3.0_f64.sqrt()) - 1.0).abs() < 1.0e-3,
        "{budget}"
    );
    let squares: f64 = list
        .iter()
        .map(|of| of["contribution"].as_f64().unwrap().powi(2))
        .sum();
    assert!(
        (squares.sqrt() / budget["combined"].as_f64().unwrap() - 1.0).abs() < 1.0e-6,
        "{budget}"
    );
    let text = compare(folder.path(), "a.json --budget").quiet();
    for word in [
        "budget of x",
        "coverage factor",
        "over the workspace",
        "not counted",
    ] {
        assert!(text.contains(word), "{word}: {text}");
    }
}

#[test]
fn a_page_shows_the_change_and_the_budget() {
    let folder = folder();
    let words = "a.json c.json b.json --budget --report page.html";
    compare(folder.path(), words).quiet();
    let page = std::fs::read_to_string(folder.path().join("page.html")).unwrap();
    for word in [
        "c.json against a.json",
        "Change of the position over a tooth",
        "Terms that changed",
        "Trend",
        "Contributions to x",
        "Expanded uncertainty over a tooth",
        "SHA-256 of a.json",
        "<svg role=\"img\"",
    ] {
        assert!(page.contains(word), "{word}");
    }
    // Every anchor once.
    let anchors: Vec<&str> = page
        .split(" id=\"")
        .skip(1)
        .filter_map(|rest| rest.split('"').next())
        .collect();
    let mut once = anchors.clone();
    once.sort_unstable();
    once.dedup();
    assert_eq!(once.len(), anchors.len(), "{anchors:?}");
}

/// A joint calibration that did not fit all together tells no covariance, nor does one over which a model was loaded: the difference stands alone.
#[test]
fn without_a_covariance_the_difference_alone_is_told() {
    let folder = folder();
    let mut joint = calibration([12.0e-6, 0.0]);
    (joint.method, joint.gauge) = (Method::Joint, Gauge::OffsetsSpreadBeaconFree);
    joint.beacon = Some(Beacon {
        segment_sd_m: 1.0e-6,
        displacement_sd_m: 1.0e-6,
        ..Beacon::default()
    });
    write(folder.path(), "joint.json", joint);
    let mut loaded = calibration([12.0e-6, 0.0]);
    loaded.model.constants_m = [1.0e-6, 0.0, 0.0, 0.0];
    loaded.model.terms.push(Term::lateral(1)).unwrap();
    loaded.model.coefficients.push([[0.0; 2]; 4]).unwrap();
    write(folder.path(), "loaded.json", loaded);
    for (name, why) in [
        ("joint.json", "33 unknowns were fitted last"),
        ("loaded.json", "a model was loaded over it"),
    ] {
        let text = compare(folder.path(), &format!("a.json {name}")).quiet();
        assert!(text.contains(why) && text.contains("not told"), "{text}");
        let told = compare(folder.path(), &format!("a.json {name} --json")).json();
        assert!(told["differences"][0]["changed"].is_null(), "{told}");
        assert!(
            told["differences"][0]["largest"][0]["value"]
                .as_f64()
                .unwrap()
                != 0.0
        );
    }
}

/// The example's recording, against a calibration that its board could have.
#[test]
fn a_recording_is_fitted_and_compared() {
    let folder = folder();
    let mut own = calibration([1.0e-6, 0.0]);
    own.device = Device(*b"ideal-000003");
    write(folder.path(), "own.json", own);
    let example = Path::new(env!("CARGO_MANIFEST_DIR")).join("../examples/survey-lateral");
    let example = example.to_str().unwrap();
    let told = compare(
        folder.path(),
        &format!("{example} own.json --budget --json"),
    )
    .json();
    assert_eq!(told["differences"][0]["changed"], true, "{told}");
    assert_eq!(told["differences"][0]["test"]["known"]["directions"], 32);
    assert!(
        told["budgets"][0]["known"]["budgets"][0]["expanded"]
            .as_f64()
            .unwrap()
            > 1.0e-7
    );
    compare(folder.path(), &format!("{example} a.json")).refused(&[
        "board paper-000001",
        "ideal-000003",
        "--other-device",
    ]);
}

#[test]
fn what_cannot_be_compared_is_refused_in_one_line() {
    let folder = folder();
    let at = folder.path();
    let with = |name: &str, change: fn(&mut Calibration)| {
        let mut other = calibration([12.0e-6, 0.0]);
        change(&mut other);
        write(at, name, other);
    };
    with("board.json", |c| c.device = Device(*b"paper-000002"));
    with("pitch.json", |c| c.geometry.pitch_m = 1.02e-3);
    with("span.json", |c| c.geometry.span_m = 9.8e-3);
    with("lateral.json", |c| c.geometry.lateral_m = 2.9e-3);
    std::fs::write(at.join("map.json"), "{\"courier_tooth_map\": 3}").unwrap();
    std::fs::write(at.join("text.json"), "hello").unwrap();
    std::fs::create_dir(at.join("empty")).unwrap();
    let cases: [(&str, &[&str]); 13] = [
        (
            "a.json b.json --repeats 3",
            &["--repeats", "found 3", "2 to 2"],
        ),
        (
            "a.json board.json",
            &[
                "board.json",
                "board paper-000002",
                "paper-000001",
                "--other-device",
            ],
        ),
        ("a.json pitch.json", &["pitch.json", "pitch_m", "0.001016"]),
        ("a.json span.json", &["span.json", "span_m", "0.0097"]),
        ("a.json lateral.json", &["lateral.json", "lateral_m"]),
        ("a.json a.json", &["a.json", "the very values", "another"]),
        ("a.json", &["a.json", "alone", "--budget"]),
        ("a.json none.json", &["none.json", "wanted a calibration"]),
        ("a.json map.json", &["map.json", "wanted a calibration"]),
        ("a.json text.json", &["text.json", "wanted a calibration"]),
        ("a.json empty", &["empty", "recording.toml"]),
        (
            "a.json b.json --turn-deg 9",
            &["--turn-deg", "found 9", "0 to 2.8"],
        ),
        ("a.json --budget --teeth-um -1", &["--teeth-um", "found -1"]),
    ];
    for (words, wanted) in cases {
        compare(at, words).refused(wanted);
    }
    compare(at, "a.json board.json --other-device").quiet();
}
