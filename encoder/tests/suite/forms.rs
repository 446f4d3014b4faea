//! Tables in other programs' forms do what the answer does: each is read here as that program reads it.

use crate::spun::{Spins, pair_read, random};
use encoder::{Answer, LogUnit, Question, forms, learn};
use std::collections::BTreeMap;
use std::f64::consts::TAU;

fn signals(turns: f64) -> [f64; 2] {
    let phase = TAU * turns;
    [
        60.0 + 1500.0 * phase.sin(),
        -30.0 + 1580.0 * (phase + 0.06).cos(),
    ]
}

/// The same as a converter without sign logs it.
pub fn logged(turns: f64) -> [f64; 2] {
    signals(turns).map(|count| count + 2048.0)
}

pub fn answer() -> Answer {
    let mut random = random(3);
    let (t_s, places) = Spins::by_hand().places(&mut random);
    let mut input = pair_read(&t_s, &places, signals, 1.0, &mut random);
    input.unit = LogUnit {
        centre: [2048.0; 2],
        scale: 1.0,
    };
    learn(&input, &Question::default()).unwrap()
}

fn wrapped(turns: f64) -> f64 {
    turns - turns.round()
}

fn numbers(text: &str) -> Vec<f64> {
    text.split([',', ' '])
        .filter_map(|word| word.trim_end_matches('f').parse().ok())
        .collect()
}

/// What moteus makes of a line (mjlib/micro/persistent_config.cc, serializable_handler_detail.h): words parted by one space; a name whose parts are
/// parted by points, the first a group; the rest a value, which is read as C does up to where no number goes on, without a word where it is none. So a
/// number is held to the type that the name has: whole ones of the table and the common offset, and within its bounds.
fn set_by(line: &str) -> (&str, f64) {
    let words: Vec<&str> = line.split(' ').collect();
    let ["conf", "set", name, value] = words[..] else {
        panic!("{line}: wanted `conf set NAME VALUE`")
    };
    let number: f64 = value
        .parse()
        .unwrap_or_else(|_| panic!("{line}: no number"));
    let bounds = match name.split('.').collect::<Vec<_>>()[..] {
        ["aux1", "sine_cosine", "common"] => Some([0.0, 65_535.0]),
        [
            "motor_position",
            "sources",
            "0",
            "compensation_table",
            entry,
        ] => {
            assert!(entry.parse::<u16>().unwrap() < 256, "{line}");
            // A leading zero would be octal there.
            assert!(
                value == "0" || !value.trim_start_matches('-').starts_with('0'),
                "{line}"
            );
            Some([-128.0, 127.0])
        }
        ["motor_position", "sources", "0", "compensation_scale"] => None,
        _ => panic!("{line}: a name that moteus has not"),
    };
    if let Some([low, high]) = bounds {
        assert!(!value.contains(['.', 'e']), "{line}: wanted a whole number");
        assert!(
            (low..=high).contains(&number),
            "{line}: wanted {low} to {high}"
        );
    }
    (name, number)
}

/// fw/aux_port.h and fw/motor_position.h of moteus: the phase and half a turn, and a table of 256 that is read at i / 256.
#[test]
fn moteus_reads_its_table_right() {
    let answer = answer();
    let text = forms::moteus(&answer);
    let set: BTreeMap<&str, f64> = text.lines().map(set_by).collect();
    // Each once: the offset, the table and its scale.
    assert_eq!((set.len(), text.lines().count()), (258, 258));
    let value = |key: &str| set[key];
    let common = value("aux1.sine_cosine.common");
    let scale = value("motor_position.sources.0.compensation_scale") / 127.0;
    let table: Vec<f64> = (0..256)
        .map(|entry| {
            scale
                * value(&format!(
                    "motor_position.sources.0.compensation_table.{entry}"
                ))
        })
        .collect();
    for k in 0..1000 {
        let turns = f64::from(k) / 1000.0;
        let [sine, cosine] = logged(turns);
        let ratio = (sine - common).atan2(cosine - common) / TAU + 0.5;
        let (entry, share) = ((ratio * 256.0) as usize % 256, (ratio * 256.0).fract());
        let compensated = ratio + table[entry] * (1.0 - share) + table[(entry + 1) % 256] * share;
        let wanted = answer.calibrated(turns, Some(signals(turns))) + 0.5;
        // Half a number of the table.
        assert!(
            wrapped(compensated - wanted).abs() < 0.6 * scale,
            "{k}: {compensated} {wanted}"
        );
    }
}

/// A log about zero has an offset that moteus' type would wrap around.
#[test]
fn an_offset_that_moteus_cannot_hold_is_left_out() {
    let mut answer = answer();
    answer.unit.centre = [0.0; 2];
    answer.channels.as_mut().unwrap().offset_counts = [-30.0; 2];
    let text = forms::moteus(&answer);
    let (told, set): (Vec<&str>, Vec<&str>) = text.lines().partition(|line| line.starts_with('#'));
    assert!(told.len() == 1 && told[0].contains("-30"), "{told:?}");
    assert_eq!(set.into_iter().map(set_by).count(), 257);
}

/// CalibratedSensor.cpp of SimpleFOCDrivers: read at i 2π / n of the shaft, and taken off.
#[test]
fn simplefoc_reads_its_table_right() {
    let answer = answer();
    for periods in [1_usize, 20] {
        let text = forms::simplefoc(&answer, periods as u32);
        let list = |name: &str| {
            let line = text.lines().find(|line| line.contains(name)).unwrap();
            numbers(&line[line.find('{').unwrap() + 1..line.find('}').unwrap()])
        };
        let [centres, table] = [list("encoder_centres"), list("calibration_lut")];
        let count = table.len() as f64;
        for k in 0..1000 {
            let turns = f64::from(k) * periods as f64 / 1000.0;
            let [sine, cosine] = logged(turns);
            let read = (sine - centres[0]).atan2(cosine - centres[1]) / TAU;
            let place = turns + wrapped(read - turns);
            let at = (place / periods as f64).rem_euclid(1.0) * count;
            let (entry, share) = (at as usize % table.len(), at.fract());
            let offset = table[entry] * (1.0 - share) + table[(entry + 1) % table.len()] * share;
            let calibrated = place - offset / TAU * periods as f64;
            let wanted = answer.calibrated(turns, Some(signals(turns)));
            // Order 2 of 0.01 turns, linear between 16 places: (2 π 2 / 16)² / 8 of it; and six digits.
            assert!(
                (calibrated - wanted).abs() < 1.0e-3,
                "{k}: {calibrated} {wanted}"
            );
        }
    }
}
