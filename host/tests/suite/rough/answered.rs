//! What is unusual but no hindrance: other rates, jumps in time, missing and unknown columns, positions instead of counts.

use super::field::{LATERAL, courier, diagnose, diagnose_text, sound, times, with_lateral};
use recording::{Recording, Row};
use std::f64::consts::TAU;

/// The sound courier has no gap, the other one its effect.
fn answered(change: impl Fn(&Recording) -> Recording) {
    assert_eq!(diagnose(&change(&sound())).verdict(), "no_gap");
    assert_eq!(diagnose(&change(&with_lateral())).names(), [LATERAL]);
}

#[test]
fn rates_from_10_hz_to_20_khz() {
    answered(|of| times(of, |i, _| 0.1 * i as f64));
    answered(|of| times(of, |i, _| 5e-5 * i as f64));
}

#[test]
fn times_that_jump() {
    let jumping = |of: &Recording| times(of, |i, t| t + if i > 1000 { 3600.0 } else { 0.0 });
    answered(jumping);
    let notes = diagnose(&jumping(&sound())).answer()["notes"].to_string();
    assert!(notes.contains("jumps by 3600"), "{notes}");
    answered(|of| times(of, |i, t| 1.75e9 + t + 7.0 * (i / 97) as f64));
}

#[test]
fn times_that_do_not_pass() {
    let sound = sound();
    let at = |i: usize| sound.samples.t_s()[i];
    let text = |from: f64, to: f64| {
        move |table: String| table.replace(&format!("\n{from},"), &format!("\n{to},"))
    };
    diagnose_text(&sound, text(at(1500), at(1490))).refused(&[
        "samples.csv",
        "row 1502",
        "t_s",
        "after",
    ]);
    diagnose_text(&sound, text(at(1500), at(1499))).refused(&[
        "samples.csv",
        "row 1502",
        "t_s",
        "after",
    ]);
    for bad in [f64::NAN, f64::INFINITY] {
        diagnose_text(&sound, text(at(1500), bad)).refused(&["row 1502", "t_s", "finite"]);
    }
}

#[test]
fn columns_that_are_missing_or_unknown() {
    let bare = |row: &mut Row| {
        row.run = "";
        row.temperature_c = None;
        row.commanded = [None; 3];
        true
    };
    answered(|of| of.with_rows(|_, row| bare(row)));
    let told = diagnose_text(&sound(), |table| {
        let lines: Vec<String> = table
            .lines()
            .map(|line| format!("{line},{}", line.len()))
            .collect();
        lines.join("\n")
    });
    assert_eq!(told.verdict(), "no_gap");
    assert!(
        told.warnings().contains("is not known"),
        "{}",
        told.warnings()
    );
    let without_count = diagnose_text(&sound(), |table| table.replacen(",n2,", ",m2,", 1));
    without_count.refused(&["samples.csv", "column n2"]);
}

/// Without the coordination sensor, one reading in three missing, or positions logged in whole micrometres.
#[test]
fn part_of_the_channels() {
    let no_beacon = |of: &Recording| {
        of.with_rows(|_, row| {
            row.electrode_counts = None;
            true
        })
    };
    assert_eq!(diagnose(&no_beacon(&sound())).verdict(), "no_gap");
    diagnose(&no_beacon(&with_lateral())).names_only(&[LATERAL]);
    answered(|of| {
        of.with_rows(|i, row| {
            if i % 3 == 0 {
                (row.quadrature_counts[0], row.teeth[0]) = (None, None);
            }
            true
        })
    });
}

#[test]
fn positions_instead_of_counts() {
    let logged = |of: &Recording, digits: f64| {
        let (pitch_m, electronics) = (of.meta.geometry.pitch_m, of.meta.electronics);
        let mut out = of.with_rows(|_, row| {
            for s in 0..4 {
                let p = recording::unmodified_m(
                    row.teeth[s].unwrap(),
                    row.quadrature_counts[s].unwrap(),
                    pitch_m,
                );
                row.position_m[s] = Some((p * digits).round() / digits);
                (row.quadrature_counts[s], row.teeth[s]) = (None, None);
            }
            true
        });
        let noise =
            electronics.quadrature_noise_counts.unwrap() / electronics.amplitude_counts.unwrap();
        out.meta.electronics.position_noise_m = Some(noise / TAU * pitch_m);
        out
    };
    answered(|of| logged(of, 1e9));
    // Rounded to whole micrometres: errors that last while the courier rests are more than the noise, and no cause.
    diagnose(&logged(&sound(), 1e6)).names_only(&["excess_noise"]);
    diagnose(&logged(&with_lateral(), 1e6)).names_only(&["excess_noise", LATERAL]);
}

/// There and back at one speed a delay and the direction of travel do the same: both are told, with the motion that tells them
/// apart, in the keys of diagnosis.md.
#[test]
fn two_causes_that_this_motion_does_not_tell_apart() {
    let whole = courier(35, &[("hysteresis", 2.0e-6)], true);
    let run = |row: &Row| row.run.to_owned();
    let mut lengths = std::collections::HashMap::new();
    for i in 0..whole.samples.len() {
        *lengths.entry(run(&whole.samples.row(i))).or_insert(0) += 1;
    }
    let passed = std::cell::RefCell::new(std::collections::HashMap::new());
    let steady = whole.with_rows(|_, row| {
        let mut passed = passed.borrow_mut();
        let place = passed.entry(run(row)).or_insert(0);
        *place += 1;
        // Without the ramps of the speed.
        let middle = (15..85).contains(&(100 * *place / lengths[row.run]));
        middle && row.run.starts_with("flyby") && !row.run.ends_with("slow")
    });
    let answer = diagnose(&steady).answer();
    assert_eq!(answer["verdict"], "alias", "{answer}");
    super::schema::check(&answer);
    let effect = &answer["effects"][0];
    let mut told = vec![effect["name"].as_str().unwrap()];
    told.extend(
        effect["aliases"]
            .as_array()
            .unwrap()
            .iter()
            .map(|a| a.as_str().unwrap()),
    );
    assert!(
        told.contains(&"hysteresis") && told.contains(&"velocity_lag"),
        "{told:?}"
    );
    assert!(
        effect["break_alias"].as_str().unwrap().contains("speeds"),
        "{effect}"
    );
}

/// The answer has the keys of diagnosis.md and no others, whatever the verdict.
#[test]
fn keys_to_the_letter() {
    let short = sound().with_rows(|i, _| i < 100);
    let tripled = sound().with_rows(|_, row| {
        // An error that no catalogue has: with the square of the angle.
        let theta = row.commanded[2].unwrap_or(0.0);
        let shift = (2.0e4 * theta * theta).round() as i32;
        row.teeth[0] = row.teeth[0].map(|n| n + shift);
        true
    });
    let mut verdicts: Vec<String> = [&sound(), &with_lateral(), &short, &tripled]
        .into_iter()
        .map(|of| {
            let answer = diagnose(of).answer();
            super::schema::check(&answer);
            answer["verdict"].as_str().unwrap().to_owned()
        })
        .collect();
    verdicts.sort();
    assert_eq!(
        verdicts,
        ["insufficient_data", "named", "no_gap", "unknown"]
    );
}
