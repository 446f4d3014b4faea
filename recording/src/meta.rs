//! `recording.toml`: nominal geometry and stated noise.

use crate::column::{Column, CountLimits};
use crate::error::{Error, one_line};
use crate::keys::{Keys, Range, describe, missing};
use crate::layout::SCHEMA;
use crate::samples::Samples;
use std::path::Path;
use toml::{Table, Value};

/// `[geometry]`.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Geometry {
    /// Tooth pitch rho, m.
    pub pitch_m: f64,
    /// Nominal distance between the segments of a pair, l_s of equation (4), m; needed by recordings with a pair.
    pub span_m: Option<f64>,
    /// Nominal lateral offset of a segment, l_o of equation (9), m; needed by recordings with four segments.
    pub lateral_m: Option<f64>,
}

/// `[coordination]`, nominal values before calibration.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Coordination {
    /// Height h of the beacon over the diode, equation (10), m.
    pub height_m: f64,
    /// Lever arm l_x, equation (11), m.
    pub lever_x_m: f64,
    /// Lever arm l_y, equation (11), m.
    pub lever_y_m: f64,
    /// tan(psi) at a normalised deflection of 1.
    pub tan_full_scale: f64,
}

/// `[electronics]`. What the recording's columns need is there; the rest may be missing.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Electronics {
    /// Bits of the quadrature converter, signed: 16 counts from -32768 to 32767.
    pub adc_bits: Option<u32>,
    /// Amplitude of the sine and cosine, counts.
    pub amplitude_counts: Option<f64>,
    /// Noise of each quadrature channel before rounding to whole counts, rms counts.
    pub quadrature_noise_counts: Option<f64>,
    /// Sum of the two electrodes of an axis, counts.
    pub psd_sum_counts: Option<f64>,
    /// Noise of each electrode, rms counts.
    pub psd_noise_counts: Option<f64>,
    /// Noise of logged positions, rms m.
    pub position_noise_m: Option<f64>,
}

/// What was recorded with what: names by which recordings of several couriers and platens go together. Empty where none is stated.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Names {
    /// The courier, as its board introduces itself.
    pub courier_id: String,
    /// The platen under it.
    pub platen_id: String,
    /// The beacon above it: one that has not moved over the platen keeps its name.
    pub beacon_id: String,
    /// Version of the board's firmware.
    pub firmware: String,
}

/// `recording.toml`.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Meta {
    /// The device, free text.
    pub device: String,
    /// Where the recording comes from, free text.
    pub source: String,
    /// Which courier, platen, beacon and firmware.
    pub names: Names,
    /// Nominal geometry of the platen sensor.
    pub geometry: Geometry,
    /// Nominal geometry of the coordination sensor; there if any electrode was recorded.
    pub coordination: Option<Coordination>,
    /// Converters and noise.
    pub electronics: Electronics,
}

const PITCH_M: Range = (1.0e-7, 0.1);
const LENGTH_M: Range = (-10.0, 10.0);
const POSITIVE_LENGTH_M: Range = (1.0e-7, 10.0);
const NOISE_M: Range = (0.0, 1.0e-2);
const POSITIVE: Range = (1.0e-9, 1.0e9);
const NOT_NEGATIVE: Range = (0.0, 1.0e9);
const BITS: Range = (4.0, 32.0);

/// An electrode's count may pass the nominal sum of its pair, as under stray light, but not by more than this.
const ELECTRODE_OVER_SUM: f64 = 2.0;

impl Meta {
    /// Parses and checks the text of a `recording.toml`; unknown keys are named in `warnings`.
    ///
    /// # Errors
    /// Not TOML, another schema, a missing or ill-typed key, a number that is not finite or has the wrong unit.
    pub(crate) fn parse(
        file: &Path,
        text: &str,
        warnings: &mut Vec<String>,
    ) -> Result<Self, Error> {
        let text = text.strip_prefix('\u{feff}').unwrap_or(text);
        let table: Table = text.parse().map_err(|error| not_toml(file, text, &error))?;
        check_schema(file, &table)?;
        let mut root = Keys::new(
            file,
            "",
            &table,
            &[
                "schema",
                "device",
                "source",
                "courier_id",
                "platen_id",
                "beacon_id",
                "firmware",
                "geometry",
                "coordination",
                "electronics",
            ],
        );
        let meta = Self {
            device: root.text("device")?,
            source: root.text("source")?,
            names: Names {
                courier_id: root.text("courier_id")?,
                platen_id: root.text("platen_id")?,
                beacon_id: root.text("beacon_id")?,
                firmware: root.text("firmware")?,
            },
            geometry: geometry(
                &mut root
                    .table("geometry", &["pitch_m", "span_m", "lateral_m"])?
                    .ok_or_else(|| {
                        missing(file, "[geometry]", "the table [geometry] with pitch_m")
                    })?,
            )?,
            coordination: root
                .table(
                    "coordination",
                    &["height_m", "lever_x_m", "lever_y_m", "tan_full_scale"],
                )?
                .map(|mut keys| coordination(&mut keys))
                .transpose()?,
            electronics: root
                .table("electronics", &ELECTRONICS_KEYS)?
                .map(|mut keys| electronics(&mut keys))
                .transpose()?
                .ok_or_else(|| {
                    missing(
                        file,
                        "[electronics]",
                        "the table [electronics] with the stated noise",
                    )
                })?,
        };
        root.warn(warnings);
        Ok(meta)
    }

    /// Checks that the tables hold what the recorded columns need.
    pub(crate) fn check_against(&self, file: &Path, samples: &Samples) -> Result<(), Error> {
        let segments: [bool; 4] = std::array::from_fn(|segment| samples.has_segment(segment));
        let has = |column: fn(usize) -> Column| (0..4).any(|index| samples.has(column(index)));
        let need = |there: bool, key: &str, why: &str| {
            if there {
                Ok(())
            } else {
                Err(missing(file, key, why))
            }
        };
        let electronics = &self.electronics;
        if (segments[0] && segments[2]) || (segments[1] && segments[3]) {
            need(
                self.geometry.span_m.is_some(),
                "[geometry] span_m",
                "the distance of a pair's segments, m",
            )?;
        }
        if segments == [true; 4] {
            need(
                self.geometry.lateral_m.is_some(),
                "[geometry] lateral_m",
                "the lateral offset of a segment, m",
            )?;
        }
        if has(Column::Sine) {
            let key = |key: &str| format!("[electronics] {key}");
            let why = "a number, since quadrature counts were recorded";
            need(electronics.adc_bits.is_some(), &key("adc_bits"), why)?;
            need(
                electronics.amplitude_counts.is_some(),
                &key("amplitude_counts"),
                why,
            )?;
            need(
                electronics.quadrature_noise_counts.is_some(),
                &key("quadrature_noise_counts"),
                why,
            )?;
        }
        if has(Column::Position) {
            let why = "the noise of the recorded positions, m";
            need(
                electronics.position_noise_m.is_some(),
                "[electronics] position_noise_m",
                why,
            )?;
        }
        if has(Column::Electrode) {
            let why = "a number, since electrodes were recorded";
            need(
                self.coordination.is_some(),
                "[coordination]",
                "the table [coordination], since electrodes were recorded",
            )?;
            need(
                electronics.psd_sum_counts.is_some(),
                "[electronics] psd_sum_counts",
                why,
            )?;
            need(
                electronics.psd_noise_counts.is_some(),
                "[electronics] psd_noise_counts",
                why,
            )?;
        }
        Ok(())
    }

    /// Ranges of counts that the converters can have given.
    pub(crate) fn count_limits(&self) -> CountLimits {
        let full_scale = self
            .electronics
            .adc_bits
            .map(|bits| 2f64.powi(bits as i32 - 1));
        let electrode = self.electronics.psd_sum_counts.map(|sum| {
            let limit = (ELECTRODE_OVER_SUM * sum)
                .max(full_scale.unwrap_or(0.0))
                .ceil();
            [-limit, limit]
        });
        CountLimits {
            quadrature: full_scale.map(|full_scale| [-full_scale, full_scale - 1.0]),
            electrode,
        }
    }

    /// The text of a `recording.toml` that parses to the same value.
    #[must_use]
    pub fn to_toml(&self) -> String {
        let mut root = Table::new();
        root.insert("schema".into(), Value::Integer(SCHEMA));
        root.insert("device".into(), Value::String(self.device.clone()));
        root.insert("source".into(), Value::String(self.source.clone()));
        let names = &self.names;
        for (key, name) in [
            ("courier_id", &names.courier_id),
            ("platen_id", &names.platen_id),
            ("beacon_id", &names.beacon_id),
            ("firmware", &names.firmware),
        ] {
            if !name.is_empty() {
                root.insert(key.into(), Value::String(name.clone()));
            }
        }
        let geometry = &self.geometry;
        insert(
            &mut root,
            "geometry",
            [
                ("pitch_m", Some(geometry.pitch_m)),
                ("span_m", geometry.span_m),
                ("lateral_m", geometry.lateral_m),
            ],
        );
        if let Some(coordination) = &self.coordination {
            insert(
                &mut root,
                "coordination",
                [
                    ("height_m", Some(coordination.height_m)),
                    ("lever_x_m", Some(coordination.lever_x_m)),
                    ("lever_y_m", Some(coordination.lever_y_m)),
                    ("tan_full_scale", Some(coordination.tan_full_scale)),
                ],
            );
        }
        let electronics = &self.electronics;
        let mut table = Table::new();
        if let Some(bits) = electronics.adc_bits {
            table.insert("adc_bits".into(), Value::Integer(i64::from(bits)));
        }
        root.insert("electronics".into(), Value::Table(table));
        insert(
            &mut root,
            "electronics",
            [
                ("amplitude_counts", electronics.amplitude_counts),
                (
                    "quadrature_noise_counts",
                    electronics.quadrature_noise_counts,
                ),
                ("psd_sum_counts", electronics.psd_sum_counts),
                ("psd_noise_counts", electronics.psd_noise_counts),
                ("position_noise_m", electronics.position_noise_m),
            ],
        );
        root.to_string()
    }
}

const ELECTRONICS_KEYS: [&str; 6] = [
    "adc_bits",
    "amplitude_counts",
    "quadrature_noise_counts",
    "psd_sum_counts",
    "psd_noise_counts",
    "position_noise_m",
];

fn insert<const N: usize>(root: &mut Table, name: &str, keys: [(&str, Option<f64>); N]) {
    let table = root
        .entry(name)
        .or_insert_with(|| Value::Table(Table::new()));
    for (key, value) in keys {
        if let (Some(value), Some(table)) = (value, table.as_table_mut()) {
            table.insert(key.into(), Value::Float(value));
        }
    }
}

fn geometry(keys: &mut Keys) -> Result<Geometry, Error> {
    Ok(Geometry {
        pitch_m: keys.required("pitch_m", PITCH_M)?,
        span_m: keys.number("span_m", POSITIVE_LENGTH_M)?,
        lateral_m: keys.number("lateral_m", LENGTH_M)?,
    })
}

fn coordination(keys: &mut Keys) -> Result<Coordination, Error> {
    Ok(Coordination {
        height_m: keys.required("height_m", POSITIVE_LENGTH_M)?,
        lever_x_m: keys.required("lever_x_m", LENGTH_M)?,
        lever_y_m: keys.required("lever_y_m", LENGTH_M)?,
        tan_full_scale: keys.required("tan_full_scale", POSITIVE)?,
    })
}

fn electronics(keys: &mut Keys) -> Result<Electronics, Error> {
    let bits = keys.number("adc_bits", BITS)?;
    if let Some(bits) = bits.filter(|bits| bits.fract() != 0.0) {
        return Err(keys.error("adc_bits", bits.to_string(), "a whole number of bits"));
    }
    Ok(Electronics {
        adc_bits: bits.map(|bits| bits as u32),
        amplitude_counts: keys.number("amplitude_counts", POSITIVE)?,
        quadrature_noise_counts: keys.number("quadrature_noise_counts", NOT_NEGATIVE)?,
        psd_sum_counts: keys.number("psd_sum_counts", POSITIVE)?,
        psd_noise_counts: keys.number("psd_noise_counts", NOT_NEGATIVE)?,
        position_noise_m: keys.number("position_noise_m", NOISE_M)?,
    })
}

fn not_toml(file: &Path, text: &str, error: &toml::de::Error) -> Error {
    let row = error
        .span()
        .map(|span| 1 + text[..span.start.min(text.len())].matches('\n').count() as u64);
    let found = one_line(error.message().lines().next().unwrap_or("an error"), 120);
    let error = Error::new(file, found, "TOML");
    match row {
        Some(row) => error.row(row),
        None => error,
    }
}

fn check_schema(file: &Path, table: &Table) -> Result<(), Error> {
    match table.get("schema") {
        Some(Value::Integer(SCHEMA)) => Ok(()),
        Some(other) => Err(Error::new(
            file,
            describe(other),
            format!("{SCHEMA}, the only schema that is known"),
        )
        .column("schema")),
        None => Err(missing(file, "schema", &format!("{SCHEMA}"))),
    }
}
