//! The same table in every dialect gives the same recording; other units, other wiring; and no bytes make it panic.

use convert::{Asked, Converted, Order, Runs, convert, read};
use proptest::prelude::*;
use std::f64::consts::TAU;
use std::fmt::Write as _;
use std::path::Path;

const PITCH_M: f64 = 1.0e-3;

/// A row of a log of one encoder: time s, sine, cosine, stage m.
type Logged = [f64; 4];

/// An encoder that goes to and fro: 400 Hz, five pitches, an error of equation (3)'s kind, a little noise.
fn encoder() -> Vec<Logged> {
    let mut state = 3_u64;
    let mut noise = || {
        state = state
            .wrapping_mul(6_364_136_223_846_793_005)
            .wrapping_add(1_442_695_040_888_963_407);
        ((state >> 11) as f64 / (1_u64 << 53) as f64 - 0.5) * 12.0_f64.sqrt()
    };
    (0..4000)
        .map(|row| {
            let t_s = f64::from(row) / 400.0;
            let turns = 5.0 * (0.8 * t_s).sin();
            let read = turns + 0.004 * (TAU * turns).sin();
            let (sine, cosine) = (TAU * read).sin_cos();
            let count = |part: f64, noise: f64| (8000.0 * part + 6.0 * noise).round();
            let (first, second) = (noise(), noise());
            [
                t_s,
                count(sine, first),
                count(cosine, second),
                turns * PITCH_M,
            ]
        })
        .collect()
}

/// How a table is written.
#[derive(Clone, Debug)]
struct Written {
    separator: &'static str,
    decimal_comma: bool,
    line_end: &'static str,
    mark: bool,
    header: &'static str,
    quoted: bool,
    trailing: bool,
}

fn text(rows: &[Logged], written: &Written) -> Vec<u8> {
    let join = |fields: [String; 4]| {
        let quote = |field: String| {
            if written.quoted {
                format!("\"{field}\"")
            } else {
                field
            }
        };
        let end = if written.trailing {
            written.separator
        } else {
            ""
        };
        fields.map(quote).join(written.separator) + end + written.line_end
    };
    let number = |value: f64| {
        let text = format!("{value}");
        if written.decimal_comma {
            text.replace('.', ",")
        } else {
            text
        }
    };
    let mut text =
        written.header.to_owned() + &join(["time", "sin", "cos", "stage"].map(str::to_owned));
    for [t_s, sine, cosine, stage_m] in rows {
        text += &join([
            number(*t_s),
            number(*sine),
            number(*cosine),
            format_stage(*stage_m, &number),
        ]);
    }
    [
        if written.mark {
            b"\xef\xbb\xbf".as_slice()
        } else {
            b""
        },
        text.as_bytes(),
    ]
    .concat()
}

/// Millimetres with seven decimals.
fn format_stage(stage_m: f64, number: &dyn Fn(f64) -> String) -> String {
    number((stage_m * 1.0e10).round() / 1.0e7)
}

fn order(columns: &[&str]) -> Order {
    Order {
        columns: columns
            .iter()
            .map(|column| Asked::parse(column).unwrap())
            .collect(),
        pitch_m: Some(PITCH_M),
        runs: Runs::Reversals,
        ..Order::default()
    }
}

const COLUMNS: [&str; 4] = ["t_s=time", "q1s=sin", "q1c=cos", "ref_x_m=stage:mm"];

fn converted(bytes: &[u8], order: &Order) -> Result<Converted, String> {
    let file = Path::new("log.csv");
    let log = read(file, bytes).map_err(|error| error.to_string())?;
    convert(file, &log, order).map_err(|error| error.to_string())
}

fn plain() -> Written {
    Written {
        separator: ",",
        decimal_comma: false,
        line_end: "\n",
        mark: false,
        header: "",
        quoted: false,
        trailing: false,
    }
}

/// Warnings of a log with these columns, or why it is refused, as one text.
fn warned(rows: &[Logged], columns: &[&str]) -> String {
    match converted(&text(rows, &plain()), &order(columns)) {
        Ok(made) => made
            .told
            .warnings
            .iter()
            .map(|warning| format!("{}; {}\n", warning.what, warning.mend))
            .collect(),
        Err(line) => line,
    }
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(24))]

    #[test]
    fn a_table_is_the_same_in_every_dialect(
        separator in prop::sample::select(vec![",", ";", "\t", "  "]),
        decimal_comma: bool,
        crlf: bool,
        mark: bool,
        quoted: bool,
        trailing: bool,
        header in prop::sample::select(vec!["", "# ", "made on Monday\n\n", "# one comment\n"]),
    ) {
        let rows = &encoder()[..400];
        // Blanks neither quote nor end a row.
        let blanks = separator == "  ";
        let written = Written {
            separator,
            // Where commas separate, a decimal comma stands in quotation marks.
            quoted: !blanks && (quoted || (decimal_comma && separator == ",")),
            decimal_comma,
            line_end: if crlf { "\r\n" } else { "\n" },
            mark,
            header,
            trailing: trailing && !blanks,
        };
        let wanted = converted(&text(rows, &plain()), &order(&COLUMNS)).unwrap();
        let found = converted(&text(rows, &written), &order(&COLUMNS)).unwrap();
        prop_assert_eq!(found.recording, wanted.recording);
    }

    #[test]
    fn no_bytes_make_it_panic(bytes in prop::collection::vec(any::<u8>(), 0..300), spec in ".{0,20}") {
        let _ = converted(&bytes, &order(&[]));
        let table = [b"t_s,p1_m,ref_x_m\n0,1,2\n".as_slice(), &bytes].concat();
        let _ = converted(&table, &order(&[]));
        if let Ok(asked) = Asked::parse(&format!("ref_y_m={spec}")) {
            let _ = converted(&table, &Order { columns: vec![asked], ..order(&[]) });
        }
    }

    #[test]
    fn numbers_of_any_kind_end_in_a_recording_or_in_one_line(
        rows in prop::collection::vec(prop::array::uniform4(prop_oneof![
            (-3_i32..3).prop_map(f64::from), any::<f64>(), -1.0e-3..1.0e-3_f64, Just(f64::NAN)
        ]), 1..40),
        rate: bool,
    ) {
        let mut log = String::from("time;sin;cos;stage\n");
        for [t, s, c, x] in rows {
            writeln!(log, "{t};{s};{c};{x}").unwrap();
        }
        let asked = Order { rate_hz: rate.then_some(100.0), ..order(if rate { &COLUMNS[1..] } else { &COLUMNS }) };
        if let Err(line) = converted(log.as_bytes(), &asked) {
            prop_assert!(line.starts_with("log.csv:") && !line.contains('\n'), "{line}");
        }
    }
}

#[test]
fn teeth_noise_and_amplitude_are_those_of_the_encoder() {
    let rows = encoder();
    let made = converted(&text(&rows, &plain()), &order(&COLUMNS)).unwrap();
    assert_eq!(made.told.warnings, []);
    let samples = &made.recording.samples;
    for (row, [.., stage_m]) in rows.iter().enumerate() {
        let off_m = samples.unmodified_m(0, row, PITCH_M).unwrap() - stage_m;
        assert!(off_m.abs() < 0.01 * PITCH_M, "row {row}: {off_m}");
    }
    let electronics = made.recording.meta.electronics;
    let noise = electronics.quadrature_noise_counts.unwrap() / 6.0;
    assert!((noise - 1.0).abs() < 0.1, "{electronics:?}");
    assert!(
        (electronics.amplitude_counts.unwrap() / 8000.0 - 1.0).abs() < 0.01,
        "{electronics:?}"
    );
}

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

/// Each wrong statement, and what the warning names.
#[test]
fn what_looks_wrong_is_told_with_the_option_that_mends_it() {
    let rows = encoder();
    for (columns, wanted) in [
        (
            ["t_s=time", "q1s=sin", "q1c=cos", "ref_x_m=stage:m"],
            "--column ref_x_m=stage:mm",
        ),
        (
            ["t_s=time", "q1s=sin", "q1c=cos", "ref_x_m=stage:um"],
            "--column ref_x_m=stage:mm",
        ),
        (
            ["t_s=time", "q1s=sin", "q1c=cos", "ref_x_m=stage:mm*-1"],
            "counts down where ref_x_m rises; --column ref_x_m=stage:mm if",
        ),
        (
            ["t_s=time", "q1s=cos", "q1c=sin", "ref_x_m=stage:mm"],
            "exchange the columns of q1s and q1c",
        ),
        (
            ["t_s=time", "q1s=sin", "q1c=sin", "ref_x_m=stage:mm"],
            "on no circle",
        ),
        (
            ["t_s=time:h", "q1s=sin", "q1c=cos", "ref_x_m=stage:mm"],
            "--column t_s=time:UNIT",
        ),
    ] {
        let told = warned(&rows, &columns);
        assert!(told.contains(wanted), "{columns:?}: {told}");
    }
    let off: Vec<Logged> = rows
        .iter()
        .map(|[t_s, s, c, x]| [*t_s, *s, *c, x * 1.01])
        .collect();
    let told = warned(&off, &COLUMNS);
    assert!(
        told.contains("% further than ref_x_m; --pitch 0.00101m"),
        "{told}"
    );
    // A stage of another axis: as far, a quarter of a period later.
    let other: Vec<Logged> = rows
        .iter()
        .map(|[t_s, s, c, _]| [*t_s, *s, *c, 5.0 * PITCH_M * (0.8 * t_s).cos()])
        .collect();
    let told = warned(&other, &COLUMNS);
    assert!(told.contains("segment 1 does not follow ref_x_m"), "{told}");
    let mut gap = rows.clone();
    gap.drain(1000..1100);
    assert!(warned(&gap, &COLUMNS).contains("time jumps at 1 rows, the first row 1002"));
}

/// Steps of over half a pitch: by the reference where there is one, refused where there is none.
#[test]
fn steps_of_over_half_a_pitch() {
    let quick: Vec<Logged> = encoder().into_iter().step_by(80).collect();
    let made = converted(&text(&quick, &plain()), &order(&COLUMNS)).unwrap();
    for (row, [.., stage_m]) in quick.iter().enumerate() {
        let off_m = made
            .recording
            .samples
            .unmodified_m(0, row, PITCH_M)
            .unwrap()
            - stage_m;
        assert!(off_m.abs() < 0.01 * PITCH_M, "row {row}: {off_m}");
    }
    let alone = converted(&text(&quick, &plain()), &order(&COLUMNS[..3])).unwrap_err();
    assert!(
        alone.contains("column n1, found") && alone.contains("half a pitch"),
        "{alone}"
    );
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

#[test]
fn errors_name_row_and_column_of_the_log() {
    for (log, columns, wanted) in [
        (
            "time;sin;cos\n0;1;2\n1;x;2\n",
            &COLUMNS[..3],
            "log.csv: row 3, column sin, found \"x\", wanted a number",
        ),
        (
            "time;sin;cos\n0;1;2\n0;1;2\n",
            &COLUMNS[..3],
            "log.csv: row 3, column time, found 0, wanted a time after the row before, 0; --rate-hz",
        ),
        (
            "time;sin;cos\n0;1;2\n;1;2\n",
            &COLUMNS[..3],
            "log.csv: row 3, column time, found no time, wanted one in every row; --rate-hz",
        ),
        (
            "time;sin;cos\n0;1;2\n1;1\n2;1;2\n",
            &COLUMNS[..3],
            "log.csv: row 3, found 2 fields, wanted 3 as in the other rows",
        ),
        (
            "time;sin;cos\n0;1;2\n",
            &["t_s=time", "q1s=sin"],
            "found nothing for q1c, wanted --column q1c=COLUMN",
        ),
        (
            "time;sin;cos\n0;1;2\n",
            &["t_s=time"],
            "found nothing for any segment",
        ),
        (
            "time;sin;cos\n0;1;2\n",
            &["t_s=time", "q1s=sinus", "q1c=cos"],
            "found no column \"sinus\", wanted one of \"time\", \"sin\", \"cos\"",
        ),
        (
            "a;sin;cos\n0;1;2\n",
            &["q1s=sin", "q1c=cos"],
            "found no column of time, wanted --column t_s=",
        ),
        (
            "time;p1_m\n0;5000\n",
            &["t_s=time"],
            "row 2, column p1_m (for p1_m), found 5000, wanted -1000 to 1000 m",
        ),
    ] {
        let stated = convert::Stated {
            position_noise_m: Some(1.0e-8),
            noise_counts: Some(1.0),
            ..Default::default()
        };
        let error = converted(
            log.as_bytes(),
            &Order {
                stated,
                ..order(columns)
            },
        )
        .unwrap_err();
        assert!(error.contains(wanted), "{log:?}: {error}");
    }
    let none = Order {
        pitch_m: None,
        ..order(&COLUMNS[..3])
    };
    assert!(
        converted(b"time;sin;cos\n0;1;2\n1;1;2\n", &none)
            .unwrap_err()
            .contains("--pitch LENGTH")
    );
}

/// A reference that stands still tells no reversal: the segment does.
#[test]
fn runs_are_told_by_what_travels() {
    let standing: Vec<Logged> = encoder()
        .iter()
        .map(|[t_s, s, c, _]| [*t_s, *s, *c, 0.0])
        .collect();
    let runs = |rows: &[Logged]| {
        let made = converted(&text(rows, &plain()), &order(&COLUMNS)).unwrap();
        made.told.runs.len()
    };
    assert_eq!(runs(&standing), runs(&encoder()));
    assert!(runs(&standing) > 1);
}
