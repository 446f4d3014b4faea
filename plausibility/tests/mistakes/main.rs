//! Mis-wired and mis-stated recordings are recognised, and nothing right is taken for wrong.

mod draw;
mod kinds;

use draw::Needs;
use kinds::{Mistake, all, made, recognised};
use plausibility::check;
use specimens::{Case, Conditions};

/// Of how many recordings a kind's are recognised; each that is not is printed. The kind's number makes its seeds its own.
fn found((kind, mistake): (usize, &Mistake), seeds: std::ops::Range<u64>) -> usize {
    let mut count = 0;
    for seed in seeds {
        let right = draw::recording(1000 * kind as u64 + seed, mistake.needs, 2);
        let wrong = made(mistake, &right);
        let findings = check(&wrong);
        if recognised(mistake, &findings, &wrong.meta) {
            count += 1;
        } else {
            println!(
                "{}, seed {seed}, {} rows:",
                mistake.name,
                wrong.samples.len()
            );
            findings.iter().for_each(|f| println!("    {f}"));
        }
    }
    count
}

/// Of how many right recordings something is told; each is printed.
fn told(seeds: std::ops::Range<u64>) -> usize {
    let mut count = 0;
    for seed in seeds {
        let needs = Needs {
            beacon: seed % 4 != 0,
            reference: seed % 3 == 0,
            positions: seed % 5 == 0,
            single: seed % 12 == 3,
            long_lever: false,
        };
        let mut right = draw::recording(seed, needs, 3);
        if seed % 4 == 1 {
            let rows = right.samples.len();
            right = draw::cut(&right, rows * (1 + seed as usize % 7) / 8);
        }
        let findings = check(&right);
        if !findings.is_empty() {
            count += 1;
            println!("seed {seed}, {} rows:", right.samples.len());
            findings.iter().for_each(|f| println!("    {f}"));
        }
    }
    count
}

/// First seed and number of a long run, by the environment: `PLAUSIBILITY_SEED`, `PLAUSIBILITY_COUNT`.
fn asked(name: &str, otherwise: u64) -> u64 {
    let value = std::env::var(name).ok().and_then(|v| v.parse().ok());
    value.unwrap_or(otherwise)
}

#[test]
fn each_kind_is_recognised_once() {
    let kinds = all().into_iter().enumerate();
    let missed: Vec<&str> = kinds
        .filter(|kind| found(*kind, 0..1) != 1)
        .map(|(_, mistake)| mistake.name)
        .collect();
    assert_eq!(missed, [""; 0]);
}

/// The kind of this name, and its number.
fn kind(name: &str) -> (usize, &'static Mistake) {
    let mut kinds = all().into_iter().enumerate();
    let found = kinds.find(|(_, mistake)| mistake.name == name);
    found.unwrap_or_else(|| panic!("no kind {name}"))
}

/// Wires are exchanged and a counter slips by a tooth: the slip is seen whatever the wires are.
#[test]
fn a_slip_hides_no_mistake() {
    for name in [
        "segments 1 and 3 exchanged",
        "sine and cosine of segment 4 exchanged",
        "reference in inches",
    ] {
        let (_, mistake) = kind(name);
        let mut right = draw::recording(31, mistake.needs, 0);
        draw::slip(&mut right, 1);
        assert_eq!(check(&right), [], "{name}");
        let wrong = made(mistake, &right);
        let findings = check(&wrong);
        assert!(
            recognised(mistake, &findings, &wrong.meta),
            "{name}: {findings:?}"
        );
    }
}

/// Recordings on which each of these was missed once: errors that follow the tooth phase were taken for those of a sensor, and angles that
/// are hardly larger than the segments' error were not looked at.
#[test]
fn small_angles_and_errors_as_wide_as_a_tooth_are_told() {
    for (name, seed) in [
        ("column q1c inverted", 701),
        ("reference's angle in mrad", 701),
        ("reference's angle in mrad", 801),
        ("reference's angle of the wrong sign", 703),
        ("reference's x of the wrong sign", 704),
    ] {
        assert_eq!(found(kind(name), seed..seed + 1), 1, "{name}, {seed}");
    }
}

/// Missed once: a courier that rests most of the time makes of an error as wide as a tooth a small one, and an angle that is three times
/// its own error tells a lever arm's sign, if not its length.
#[test]
fn much_rest_and_little_turning_hide_no_mistake() {
    for (name, seed) in [
        ("column q1c inverted", 26_112_647),
        ("lever_x of the wrong sign", 26_112_644),
        ("reference's angle of the wrong sign", 31_415_928),
        ("segments 2 and 4 reversed", 71_828_182),
        (
            "one segment's sine and cosine columns exchanged",
            57_721_567,
        ),
        (
            "one segment's sine and cosine columns exchanged",
            57_721_568,
        ),
        (
            "one segment's sine and cosine columns exchanged",
            14_142_138,
        ),
    ] {
        assert_eq!(found(kind(name), seed..seed + 1), 1, "{name}, {seed}");
    }
}

/// Missed once, in 2 of 400 cut surveys: a turn of some rows, too few to take equation (3) out of them, closes better by chance with other
/// wires.
#[test]
fn a_turn_of_few_rows_accuses_no_wire() {
    let needs = Needs {
        beacon: false,
        ..Needs::default()
    };
    for seed in 0..24 {
        let whole = draw::recording(seed, needs, 0);
        let names = whole.samples.run_names().to_vec();
        let mut turned = 0;
        let few = whole.with_rows(|k, _| {
            turned += usize::from(names[whole.samples.run_number(k)] == "spin");
            names[whole.samples.run_number(k)] == "spin" && turned % 5 == 0 && turned <= 5 * 60
        });
        assert_eq!(check(&few), [], "{seed}, {} rows", few.samples.len());
    }
}

#[test]
fn nothing_is_told_of_right_recordings() {
    assert_eq!(told(0..12), 0);
}

/// Of how many right recordings of motions that are drawn anew something is told; each is printed. Some of them have effects.
fn told_of_drawn_motions(seed: u64, cases: impl Iterator<Item = usize>) -> usize {
    let mut count = 0;
    for number in cases {
        let recording = Case::draw(number, seed, Conditions::Drawn).recorded(0);
        let findings = check(&recording);
        if !findings.is_empty() {
            println!("case {number} of seed {seed}: {findings:?}");
            count += 1;
        }
    }
    count
}

/// Told once to have another lever arm than stated: one segment of a pair was not recorded, and what the courier turns was a part of the
/// place by the other one, half a span for each radian, 4.85 mm beside a lever arm of 5.
#[test]
fn a_pair_of_one_segment_makes_no_lever_arm_wrong() {
    assert_eq!(told_of_drawn_motions(6024, [7].into_iter()), 0);
    assert_eq!(
        told_of_drawn_motions(6046, [26, 59, 190, 274].into_iter()),
        0
    );
}

/// Told once to have sine and cosine of both segments of a pair exchanged: a counter had slipped while another run was on, and the poses at rest
/// before and after it were taken for one run with one zero.
#[test]
fn a_slip_between_two_parts_of_a_run_makes_no_reading_wrong() {
    assert_eq!(told_of_drawn_motions(6047, [261].into_iter()), 0);
}

/// The same was told of a courier that went along one line: the reference's x and y then move in proportion, and of what each is by itself nothing
/// is known.
#[test]
fn a_way_along_one_line_makes_no_reading_wrong() {
    assert_eq!(told_of_drawn_motions(6047, [357].into_iter()), 0);
}

/// Wanted: no more false alarms than one in two hundred.
#[test]
#[ignore = "some minutes: the nightly checks run it"]
fn hardly_anything_is_told_of_four_hundred_motions_that_are_drawn_anew() {
    let told = told_of_drawn_motions(asked("PLAUSIBILITY_SEED", 6048), 0..400);
    assert!(told <= 2, "{told} of 400");
}

#[test]
#[ignore = "some minutes: the nightly checks run it"]
fn every_kind_is_recognised_five_times() {
    let seed = asked("PLAUSIBILITY_SEED", 100);
    let count = asked("PLAUSIBILITY_COUNT", 5);
    let kinds = all();
    let asked_for = kinds.len() * count as usize;
    let recognised: usize = kinds
        .iter()
        .enumerate()
        .map(|(number, mistake)| found((number, mistake), seed..seed + count))
        .sum();
    println!(
        "{recognised} of {asked_for} recognised, {} kinds",
        kinds.len()
    );
    assert_eq!(recognised, asked_for);
}

#[test]
#[ignore = "some minutes: the nightly checks run it"]
fn nothing_is_told_of_five_hundred_right_recordings() {
    let seed = asked("PLAUSIBILITY_SEED", 1_000_000);
    assert_eq!(told(seed..seed + asked("PLAUSIBILITY_RIGHT", 500)), 0);
}
