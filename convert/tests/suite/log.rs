//! A log of one encoder, as different programs would write it.

use convert::{Asked, Converted, Order, Runs, convert, read};
use std::f64::consts::TAU;
use std::path::Path;

pub const PITCH_M: f64 = 1.0e-3;

/// A row of a log of one encoder: time s, sine, cosine, stage m.
pub type Logged = [f64; 4];

/// An encoder that goes to and fro: 400 Hz, five pitches, an error of equation (3)'s kind, a little noise.
pub fn encoder() -> Vec<Logged> {
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
pub struct Written {
    pub separator: &'static str,
    pub decimal_comma: bool,
    pub line_end: &'static str,
    pub mark: bool,
    pub header: &'static str,
    pub quoted: bool,
    pub trailing: bool,
}

pub fn text(rows: &[Logged], written: &Written) -> Vec<u8> {
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

pub fn order(columns: &[&str]) -> Order {
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

pub const COLUMNS: [&str; 4] = ["t_s=time", "q1s=sin", "q1c=cos", "ref_x_m=stage:mm"];

pub fn converted(bytes: &[u8], order: &Order) -> Result<Converted, String> {
    let file = Path::new("log.csv");
    let log = read(file, bytes).map_err(|error| error.to_string())?;
    convert(file, &log, order).map_err(|error| error.to_string())
}

pub fn plain() -> Written {
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
pub fn warned(rows: &[Logged], columns: &[&str]) -> String {
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
