//! Other units, rates and coordinates say the same.

use crate::log::{COLUMNS, Logged, PITCH_M, converted, encoder, order, plain, text, warned};
use convert::{Converted, Order};

#[test]
fn units_and_rates_say_the_same() {
    let rows = encoder();
    let wanted = converted(&text(&rows, &plain()), &order(&COLUMNS))
        .unwrap()
        .recording
        .samples;
    let other: Vec<Logged> = rows
        .iter()
        .map(|[t_s, s, c, x]| [t_s * 1.0e3, *s + 32_768.0, *c + 32_768.0, x * -1.0e3])
        .collect();
    let columns = [
        "t_s=time:ms",
        "q1s=sin-32768",
        "q1c=cos-32768",
        "ref_x_m=stage:um*-1",
    ];
    let ms = converted(&text(&other, &plain()), &order(&columns))
        .unwrap()
        .recording
        .samples;
    let rate = Order {
        rate_hz: Some(400.0),
        ..order(&columns[1..])
    };
    let by_rate = converted(&text(&other, &plain()), &rate)
        .unwrap()
        .recording
        .samples;
    for index in 0..wanted.len() {
        assert_eq!(
            wanted.row(index).quadrature_counts,
            ms.row(index).quadrature_counts
        );
        assert_eq!(wanted.row(index).teeth, by_rate.row(index).teeth);
        for found in [&ms, &by_rate] {
            assert!((wanted.t_s()[index] - found.t_s()[index]).abs() < 1.0e-9);
            let off_m =
                wanted.row(index).reference[0].unwrap() - found.row(index).reference[0].unwrap();
            assert!(off_m.abs() < 1.0e-9, "{off_m}");
        }
    }
}

/// A shaft: one period a turn and five, against an angle in degrees that begins anew at each turn.
#[test]
fn turns_of_a_shaft_are_lengths() {
    let rows = encoder();
    for periods in [1.0, 5.0] {
        let angle = |x: f64| (x / PITCH_M / periods * 360.0).rem_euclid(360.0);
        let rotary: Vec<Logged> = rows
            .iter()
            .map(|[t_s, s, c, x]| [*t_s, *s, *c, angle(*x) * 1.0e-3])
            .collect();
        let columns = ["t_s=time", "q1s=sin", "q1c=cos", "ref_x_m=stage:deg"];
        let asked = Order {
            periods_per_turn: Some(periods),
            ..order(&columns)
        };
        let made = converted(&text(&rotary, &plain()), &asked).unwrap();
        assert_eq!(made.told.warnings, []);
        let reference = made
            .recording
            .samples
            .column(recording::Column::Reference(0));
        let off_m = |index: usize| reference[index] - reference[0] - rows[index][3] + rows[0][3];
        assert!((0..rows.len()).all(|index| off_m(index).abs() < 1.0e-8));
    }
    let rotary: Vec<Logged> = rows
        .iter()
        .map(|[t_s, s, c, x]| [*t_s, *s, *c, x / PITCH_M / 5.0 * 1.0e-3])
        .collect();
    let told = warned(
        &rotary,
        &["t_s=time", "q1s=sin", "q1c=cos", "ref_x_m=stage:turn"],
    );
    assert!(told.contains("--periods-per-turn 5"), "{told}");
}

#[test]
fn volts_become_counts() {
    let rows = encoder();
    let volts: Vec<Logged> = rows
        .iter()
        .map(|[t_s, s, c, x]| [*t_s, 1.65 + s / 8000.0, 1.65 + c / 8000.0, *x])
        .collect();
    let made = converted(&text(&volts, &plain()), &order(&COLUMNS)).unwrap();
    let wanted = converted(&text(&rows, &plain()), &order(&COLUMNS)).unwrap();
    for (index, [.., stage_m]) in rows.iter().enumerate() {
        let off_m = made
            .recording
            .samples
            .unmodified_m(0, index, PITCH_M)
            .unwrap()
            - stage_m;
        assert!(off_m.abs() < 0.01 * PITCH_M, "row {index}: {off_m}");
    }
    let relative = |made: &Converted| {
        let electronics = made.recording.meta.electronics;
        electronics.quadrature_noise_counts.unwrap() / electronics.amplitude_counts.unwrap()
    };
    assert!((relative(&made) / relative(&wanted) - 1.0).abs() < 0.02);
    assert!(
        made.told
            .assumed
            .iter()
            .any(|assumed| assumed.what.contains("no whole counts")),
        "{:?}",
        made.told
    );
    let stated = Order {
        stated: convert::Stated {
            adc_bits: Some(12),
            full_scale: Some(3.3),
            ..Default::default()
        },
        ..order(&COLUMNS)
    };
    let made = converted(&text(&volts, &plain()), &stated).unwrap();
    assert!(
        (made.recording.meta.electronics.amplitude_counts.unwrap() / (2048.0 / 3.3) - 1.0).abs()
            < 0.01
    );
}
