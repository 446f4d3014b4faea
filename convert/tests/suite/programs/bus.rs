//! Frames of a CAN bus as candump writes them, by their DBC file.

use super::{MM, beside, close, converted, log_of, order, read_turns, shaft_turns};
use convert::{Beside, convert, read_with};
use recording::Column;
use std::f64::consts::TAU;
use std::path::Path;

#[test]
fn signals_of_a_bus_by_its_dbc_file() {
    let columns = ["p1_m=Pos_Estimate", "ref_x_m=Place"];
    let made = converted("can-utils.log", &columns, None);
    let single = 1.5 * f64::from(f32::EPSILON) * MM;
    close(
        &made,
        Column::Position(0),
        |t_s| read_turns(t_s) * MM,
        single + 3.0 * 1e-6 * MM,
    );
    // Between messages 10 ms apart a swing of 1.5 turns at 2 rad/s bends by an eighth of 6 turns/s² times their square; a step of the
    // signal is 0.0001 degrees.
    let bend = 6.0 * 0.01_f64.powi(2) / 8.0;
    close(
        &made,
        Column::Reference(0),
        |t_s| shaft_turns(t_s) * MM,
        (bend + 1e-4 / 360.0) * MM,
    );
    let note = made
        .told
        .done
        .iter()
        .find(|done| done.starts_with("Place.Place was interpolated"))
        .unwrap();
    let told: f64 = note
        .rsplit_once("off by ")
        .unwrap()
        .1
        .strip_suffix(" deg rms")
        .unwrap()
        .parse()
        .unwrap();
    let swing: f64 = (0..240)
        .map(|row| (2.0 * f64::from(row) / 200.0).sin().powi(2))
        .sum::<f64>()
        / 240.0;
    let wanted = bend * 360.0 * swing.sqrt();
    assert!((told - wanted).abs() < 0.02 * wanted, "{note}: {wanted}");

    // Multiplexed, of 29 bits, most significant byte first; temperatures come once in fifty.
    let beside = Beside {
        rows_of: Some("raw".into()),
        ..beside()
    };
    let log = log_of("can-utils.log", &beside).unwrap();
    let made = convert(
        Path::new("can-utils.log"),
        &log,
        &order(
            &["q1s=Sine*2", "q1c=Cosine*2", "ref_x_m=Pos_Estimate"],
            None,
        ),
    )
    .unwrap();
    let sine = made.recording.samples.column(Column::Sine(0));
    let held: Vec<f64> = sine
        .iter()
        .copied()
        .filter(|value| value.is_finite())
        .collect();
    assert_eq!((sine.len(), held.len()), (245, 240));
    assert_eq!(held[30], (8000.0 * (TAU * read_turns(0.15)).sin()).round());
    let temperature = log
        .columns
        .iter()
        .find(|column| column.name == "Raw.Temp")
        .unwrap();
    assert_eq!(
        temperature
            .numbers
            .iter()
            .copied()
            .filter(|value| value.is_finite())
            .collect::<Vec<_>>(),
        [21.5; 5]
    );
}

/// Of several senders each is a kind of message of its own.
#[test]
fn senders_are_told_apart_where_the_dbc_file_names_none() {
    let text = "BO_ 2582713086 Heading: 8 X\n SG_ Place : 8|16@1+ (0.5,0) [0|0] \"deg\" X\n";
    let beside = Beside {
        dbc: Some(("a.dbc".into(), text.into())),
        ..Beside::default()
    };
    let read = |frames: &str| {
        let log = read_with(Path::new("a.log"), frames.as_bytes(), &beside).unwrap();
        let names = log.columns.iter().map(|column| column.name.clone());
        (names.collect::<Vec<_>>(), log.columns[1].numbers.clone())
    };
    let one = "(1.0) can0 09F11280#000200\n(1.1) can0 09F11280#000400\n";
    let (names, places) = read(one);
    assert_eq!(names, ["time", "Heading.Place"]);
    assert_eq!(places, [1.0, 2.0]);
    let (names, places) = read(&format!("{one}(1.05) can0 09F1127F#000300\n"));
    assert_eq!(names, ["time", "Heading_80.Place", "Heading_7F.Place"]);
    assert_eq!(places, [1.0, 2.0]);
}

/// All bits set are "not available" on a bus of SAE J1939, and a reading elsewhere.
#[test]
fn what_is_not_available_is_no_reading() {
    let read = |id: u32, frame: &str| {
        let text = format!("BO_ {id} Heading: 8 X\n SG_ Place : 8|16@1+ (0.5,0) [0|0] \"deg\" X\n");
        let beside = Beside {
            dbc: Some(("a.dbc".into(), text)),
            ..Beside::default()
        };
        let frames = format!("(1.0) can0 {frame}#000200\n(1.1) can0 {frame}#00FFFF\n");
        let log = read_with(Path::new("a.log"), frames.as_bytes(), &beside).unwrap();
        (log.columns[1].numbers.clone(), log.notes)
    };
    let (places, notes) = read(2_582_713_086, "09F11280");
    assert!(places[0] == 1.0 && places[1].is_nan());
    assert_eq!(
        notes,
        ["1 of 2 messages Heading say that Place has no value"]
    );
    let (places, notes) = read(0x123, "123");
    assert_eq!((places, notes.len()), (vec![1.0, 32_767.5], 0));
}
