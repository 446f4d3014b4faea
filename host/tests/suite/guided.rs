//! `courier record --until-answers`: the same answers as a survey in a third of its time, by a controller and by hand, and what cannot be
//! answered is told.

use crate::common::{CALIBRATE, asked, courier_in, json_in};
use anyhow::Result;
use courier::board::{Choice, Link};
use courier::capture::{Capture, Commanded, Ending, Mover, Order};
use courier::destination::Destination;
use courier::interrupt::Interrupted;
use courier::recorder::Recorder;
use effects::motion::Pose;
use guided::motion::{Area, Move};
use guided::question::Question;
use indicatif::ProgressBar;
use recording::Recording;
use serde_json::Value;
use std::path::Path;

/// Size of the effects, µm rms: a tenth of what an uncalibrated sensor is wrong by.
const SIZE_UM: u32 = 3;

/// What a diagnosis says: verdict and causes.
fn verdict(diagnosis: &Value) -> (String, Vec<String>) {
    let effects = diagnosis["effects"].as_array().unwrap();
    let mut names: Vec<String> = effects
        .iter()
        .map(|effect| effect["name"].as_str().unwrap().to_owned())
        .collect();
    names.sort();
    (diagnosis["verdict"].as_str().unwrap().to_owned(), names)
}

/// Options of a simulated courier with one effect.
fn courier_with(effect: &str, seed: u64) -> String {
    format!("--sim-preset ideal --sim-seed {seed} --sim-effect {effect}={SIZE_UM}")
}

/// Surveys a courier and returns the time that it took, s.
fn survey(folder: &Path, courier: &str) -> f64 {
    asked(
        folder,
        &format!("{courier} record survey --survey 0,0,0 --force"),
    );
    let survey = Recording::read(folder.join("survey")).unwrap();
    let t_s = survey.samples.t_s();
    t_s[t_s.len() - 1] - t_s[0]
}

/// Captures until an effect is answered for; returns what the diagnosis says, if there is one, and the time that it took, s.
fn capture(folder: &Path, courier: &str, effect: &str) -> (Option<(String, Vec<String>)>, f64) {
    let words =
        format!("{courier} record guided --until-answers {effect} --json=guided.json --force");
    asked(folder, &words);
    let answer = json_in(folder.join("guided.json"));
    let diagnosis = &answer["diagnosis"];
    (
        diagnosis.is_object().then(|| verdict(diagnosis)),
        answer["seconds"].as_f64().unwrap(),
    )
}

/// Prints the figure and returns the median share of a survey's time: what has not the wanted answer counts as never answered.
fn median_share(pairs: &[(bool, f64)], wanted: &str) -> f64 {
    let mut shares: Vec<f64> = pairs
        .iter()
        .map(|(is_same, share)| if *is_same { *share } else { f64::INFINITY })
        .collect();
    shares.sort_by(f64::total_cmp);
    let median = shares[shares.len() / 2];
    println!(
        "guided capture: {wanted} in {} of {}, in {:.0} % of its time in the median (a third is wanted)",
        pairs.iter().filter(|(is_same, _)| *is_same).count(),
        pairs.len(),
        100.0 * median
    );
    median
}

/// The survey's own answers are the nightly form's to compare: here the effect that was put in is to be named.
#[test]
fn some_answers_take_a_third_of_a_surveys_time() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let seed = 3_102_274;
    let survey_s = survey(folder, &courier_with("velocity_lag", seed));
    let pairs = ["velocity_lag", "psd_latency"].map(|effect| {
        let (told, seconds) = capture(folder, &courier_with(effect, seed), effect);
        let named = told.is_some_and(|(_, names)| names == [effect]);
        (named, seconds / survey_s)
    });
    let share = median_share(&pairs, "the courier's effect, beside a survey,");
    assert!(share <= 1.0 / 3.0, "{share}");
}

#[test]
#[ignore = "nightly: surveys and captures of the whole catalogue, some minutes"]
fn the_catalogues_answers_take_a_third_of_a_surveys_time() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let pair = |effect: &str| {
        let courier = courier_with(effect, 90_417_263);
        let survey_s = survey(folder, &courier);
        asked(folder, "diagnose survey --json=survey.json");
        let surveyed = verdict(&json_in(folder.join("survey.json")));
        let (told, seconds) = capture(folder, &courier, effect);
        let is_same = told.as_ref() == Some(&surveyed);
        if !is_same {
            println!("guided capture: {effect}: {told:?}, by its survey {surveyed:?}");
        }
        (is_same, seconds / survey_s)
    };
    let pairs: Vec<(bool, f64)> = effects::cards().map(|card| pair(card.name)).collect();
    let share = median_share(&pairs, "the survey's answer");
    assert!(share <= 1.0 / 3.0, "{share}");
}

/// A simulated hand goes some ten percent too far or not far enough, at a pace of its own.
#[test]
fn a_hand_is_told_what_to_do_and_its_recording_answers() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let told = asked(
        folder,
        "--sim-preset ideal --sim-seed 5 --sim-effect velocity_lag=3 record r --until-answers velocity_lag --by-hand --json=r.json",
    )
    .quiet();
    let answer = json_in(folder.join("r.json"));
    assert_eq!(answer["ending"], "answered", "{told}");
    assert_eq!(
        verdict(&answer["diagnosis"]),
        ("named".into(), vec!["velocity_lag".into()])
    );
    for words in [
        "now: push it ",
        " by hand, ",
        "degrees to the ",
        " µm",
        "velocity_lag: answered",
    ] {
        assert!(told.contains(words), "{words}: {told}");
    }
    // What was made is what the segments saw, and not what was asked for.
    let first = &answer["motions"][0];
    let went_mm =
        1.0e3 * (first["to"]["x_m"].as_f64().unwrap() - first["from"]["x_m"].as_f64().unwrap());
    assert!(
        (went_mm - 10.0).abs() > 0.01 && (went_mm - 10.0).abs() < 6.0,
        "{went_mm}"
    );
}

#[test]
fn calibration_terms_are_known_in_micrometres() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let told = asked(
        folder,
        "--sim-preset ideal record r --until-answers platen --json",
    )
    .json();
    assert_eq!(
        (&told["ending"], &told["lost"]),
        (&"answered".into(), &0.into())
    );
    let known = told["known"].as_array().unwrap();
    assert_eq!(known.len(), 4);
    for part in known {
        let deviation_m = part["deviation_m"].as_f64().unwrap();
        assert!(deviation_m > 0.0 && deviation_m < 0.2e-6, "{part}");
    }
}

/// The recording is kept; the reason and what would help are told.
#[test]
fn what_no_motion_answers_is_told() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    for (question, wanted) in [
        ("thermal_drift", "a temperature that changes"),
        ("psd_latency --about 60,60,0", "a beacon in sight"),
    ] {
        let words = format!("--sim-preset ideal record r --force --until-answers {question}");
        let ran = courier_in(folder, &words.split(' ').collect::<Vec<_>>());
        assert_eq!(ran.code, 1, "{}", ran.err);
        assert!(
            ran.out.contains("nothing within reach shows it"),
            "{}",
            ran.out
        );
        assert!(ran.out.contains(wanted), "{}", ran.out);
        assert!(Recording::read(folder.join("r")).unwrap().samples.len() > 1000);
    }
}

#[test]
fn wrong_questions_are_refused() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    for (options, wanted) in [
        (
            "--until-answers tooth_resonance",
            "platen, joint, all or an effect",
        ),
        ("--until-answers all --survey 0,0,0", "cannot be used with"),
        ("--by-hand", "--until-answers"),
        (
            "--until-answers all --most-seconds 1",
            "--most-seconds: found 1",
        ),
        ("--until-answers all --about 9000,0,0", "x in metres is 9"),
    ] {
        asked(folder, &format!("record x {options}")).refused(&[wanted]);
    }
    assert_eq!(std::fs::read_dir(folder).unwrap().count(), 0);
}

/// A controller whose user interrupts at the fourth motion.
struct Interrupts(Commanded, u32);

impl Mover for Interrupts {
    fn start(&mut self, area: &Area) -> Pose {
        self.0.start(area)
    }

    fn make(
        &mut self,
        link: &mut Link,
        recorder: &mut Recorder,
        bar: &ProgressBar,
        go: Move,
    ) -> Result<Pose> {
        self.1 += 1;
        anyhow::ensure!(self.1 < 4, Interrupted);
        self.0.make(link, recorder, bar, go)
    }
}

#[test]
fn an_interruption_keeps_what_is_recorded() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path().join("r");
    let mut board = Choice::default().open().unwrap();
    let to = Destination {
        folder: folder.clone(),
        force: false,
    };
    let order = Order {
        question: Question::All,
        area: Area::of_survey(Pose::default()),
        most_seconds: 25.0,
    };
    let mut recorder =
        Recorder::begin(&mut board.link, board.world.as_ref(), &to, 20, true).unwrap();
    recorder.know_noise(&mut board.link, None).unwrap();
    let mut mover = Interrupts(Commanded::default(), 0);
    let answer = Capture::new(&order, &mut recorder, &mut mover)
        .run(&mut board.link, &ProgressBar::hidden(), &mut |_| Ok(()))
        .unwrap();
    assert_eq!(
        (answer.ending, answer.motions.len()),
        (Ending::Interrupted, 3)
    );
    let recorded = recorder.finish().unwrap();
    let read = Recording::read(&folder).unwrap();
    assert_eq!(read.samples.len(), recorded.samples as usize);
    assert_eq!(read.samples.run_names().len(), 3);
}

/// The next is foreseen with the height and the lever arm that the calibration in force has, not with those of the drawing.
#[test]
fn a_guided_calibration_is_foreseen_with_the_boards_own_geometry() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let guided = "--sim-preset ideal --sim-flash a.bin calibrate --guided --held-out 20 --dry-run --target-um 0.5 --json=g.json";
    let told = asked(folder, guided).quiet();
    assert!(
        told.contains("of the drawing, since no calibration is in force: span 9.70 mm"),
        "{told}"
    );
    assert_eq!(
        json_in(folder.join("g.json"))["guided"]["geometry"]["read"],
        false
    );
    asked(folder, CALIBRATE).quiet();
    asked(folder, "--sim-preset ideal --sim-flash a.bin export c.json").quiet();
    let mut stored = json_in(folder.join("c.json"));
    stored["calibration"]["geometry"]["height_m"] = 0.0513.into();
    std::fs::write(folder.join("d.json"), stored.to_string()).unwrap();
    asked(folder, "--sim-preset ideal --sim-flash a.bin import d.json").quiet();
    // The one in force is as good, so it may stay.
    let told = asked(folder, guided).out;
    for words in ["of the calibration in force", "height 51.30 mm"] {
        assert!(told.contains(words), "{words}: {told}");
    }
    let geometry = json_in(folder.join("g.json"))["guided"]["geometry"].clone();
    assert_eq!(geometry["read"], true);
    let height_m = geometry["height_m"].as_f64().unwrap();
    assert!((height_m - 0.0513).abs() < 1.0e-8, "{geometry}");
}

/// As many poses as its terms need: what is foreseen before the first is what the board then fits.
#[test]
fn a_guided_calibration_ends_when_its_terms_are_told() {
    let temporary = tempfile::tempdir().unwrap();
    let folder = temporary.path();
    let calibrate = "--sim-preset ideal calibrate --guided --held-out 20 --dry-run";
    let told = asked(
        folder,
        &format!("{calibrate} --target-um 0.3 --json=a.json"),
    )
    .quiet();
    for words in [
        "what would: lateral terms: go under a beacon",
        "own order 4 ± 0.",
        "accepted: ",
    ] {
        assert!(told.contains(words), "{words}: {told}");
    }
    let answer = json_in(folder.join("a.json"));
    let foreseen = answer["guided"]["poses"].as_u64().unwrap();
    assert!((40..333).contains(&foreseen), "{foreseen}");
    assert!(
        told.contains(&format!("accepted: {foreseen} poses")),
        "{told}"
    );
    let groups = answer["guided"]["groups"].as_array().unwrap();
    let order_4 = groups.iter().find(|g| g["group"] == "own order 4").unwrap();
    assert!(order_4["deviation_m"].as_f64().unwrap() <= 0.3e-6);
    // A thirtieth of the deviation would take nine hundred times the poses.
    let refused = format!("{calibrate} --target-um 0.01");
    asked(folder, &refused).refused(&["--guided: found no group", "--target-um"]);
}
