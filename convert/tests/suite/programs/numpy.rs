//! Arrays of NumPy, and the captures of ODrive that are such arrays.

use super::{MM, close, converted, read_turns, shaft_turns};
use recording::Column;
use std::f64::consts::TAU;

#[test]
fn numpy_tables_and_archives() {
    let named = ["t_s=t:s", "q1s=sin", "q1c=cos", "ref_x_m=stage:turn"];
    let numbered = ["t_s=#1:s", "q1s=#2", "q1c=#3", "ref_x_m=#4:turn"];
    // Resolution of `stage`, kept as a number of 32 bits, at 1.5 turns.
    let single = 1.5 * f64::from(f32::EPSILON) * MM;
    for (name, columns, off) in [
        ("structured.npy", &named, single),
        ("columns.npz", &named, 1e-15),
        ("compressed.npz", &named, 1e-15),
        ("plain.npy", &numbered, 1e-15),
    ] {
        let made = converted(name, columns, None);
        assert_eq!(made.recording.samples.len(), 240, "{name}");
        close(
            &made,
            Column::Reference(0),
            |t_s| shaft_turns(t_s) * MM,
            off,
        );
        close(
            &made,
            Column::Sine(0),
            |t_s| (8000.0 * (TAU * read_turns(t_s)).sin()).round(),
            0.0,
        );
        close(
            &made,
            Column::Cosine(0),
            |t_s| (8000.0 * (TAU * read_turns(t_s)).cos()).round(),
            0.0,
        );
    }
    // Its times are of 32 bits as well, so that the shaft is elsewhere by its speed, 3 turns/s, times their resolution.
    let made = converted("fortran.npy", &numbered, None);
    close(
        &made,
        Column::Reference(0),
        |t_s| shaft_turns(t_s) * MM,
        single + 3.0 * 1.2 * f64::from(f32::EPSILON) * MM,
    );
}

#[test]
fn odrive_captures_in_either_count_of_time() {
    for (name, rate_hz, told) in [
        ("odrive-cycles.npy", 8000.0, "control cycles"),
        ("odrive-nanoseconds.npy", 8000.0, "nanoseconds"),
    ] {
        let made = converted(
            name,
            &[
                "p1_m=axis0.pos_estimate",
                "cmd_x_m=axis0.controller.pos_setpoint",
            ],
            None,
        );
        assert!(
            (made.told.rate_hz - rate_hz).abs() < 1e-6,
            "{name}: {}",
            made.told.rate_hz
        );
        assert!(
            made.told.done.iter().any(|done| done.contains(told)),
            "{:?}",
            made.told.done
        );
        // The values were taken 200 a second; the capture's clock says 8000.
        close(
            &made,
            Column::Position(0),
            |t_s| read_turns(40.0 * t_s) * MM,
            1.5 * f64::from(f32::EPSILON) * MM,
        );
    }
}
