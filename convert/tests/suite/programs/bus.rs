//! Frames of a CAN bus as candump writes them, by their DBC file.

use super::{MM, beside, close, converted, log_of, order, read_turns, shaft_turns};
use convert::{Beside, convert};
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
