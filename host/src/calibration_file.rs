//! A calibration as a file on the host: JSON, so that it can be read, compared and kept.

use anyhow::{Context, Result, ensure};
use courier_sensor::beacon::BeaconSettings;
use courier_sensor::calibration::joint::JointLimits;
use courier_sensor::calibration::record::{Calibration, OLDEST_VERSION, VERSION, check_sensor};
use courier_sensor::geometry::Geometry;
use courier_sensor::settings::{ConfigError, Settings};
use serde::{Deserialize, Serialize};
use std::io::Read as _;
use std::path::Path;

/// Longest file that is read, bytes: a calibration is a few thousand.
const LIMIT_BYTES: u64 = 1 << 20;

/// The file's one object.
#[derive(Debug, Serialize, Deserialize)]
pub struct CalibrationFile {
    /// Version of the record that it holds.
    courier_calibration: u16,
    /// What is in it.
    calibration: Calibration,
}

impl CalibrationFile {
    /// For writing.
    pub fn new(calibration: Calibration) -> Self {
        Self {
            courier_calibration: VERSION,
            calibration,
        }
    }

    /// The file's text.
    ///
    /// # Errors
    /// None in practice: every field can be written.
    pub fn to_json(&self) -> Result<String> {
        Ok(serde_json::to_string_pretty(self)?)
    }

    /// Reads and checks a file.
    ///
    /// # Errors
    /// It cannot be read, is no calibration of a known version, or holds numbers that cannot be used.
    pub fn read(path: &Path) -> Result<Calibration> {
        let place = || path.display().to_string();
        let mut text = String::new();
        let wanted = || format!("{}: a readable calibration was wanted", path.display());
        let file = std::fs::File::open(path).with_context(wanted)?;
        file.take(LIMIT_BYTES)
            .read_to_string(&mut text)
            .with_context(wanted)?;
        let value: serde_json::Value = serde_json::from_str(&text)
            .with_context(|| format!("{}: wanted JSON", path.display()))?;
        let version = value
            .get("courier_calibration")
            .and_then(serde_json::Value::as_u64);
        let known = u64::from(OLDEST_VERSION)..=u64::from(VERSION);
        ensure!(
            version.is_some_and(|version| known.contains(&version)),
            "{}: key courier_calibration, found {}, wanted {OLDEST_VERSION} to {VERSION}",
            path.display(),
            version.map_or("none".to_owned(), |version| version.to_string())
        );
        let file: Self = serde_json::from_value(value)
            .with_context(|| format!("{}: wanted a calibration", path.display()))?;
        usable(&file.calibration)
            .with_context(|| format!("{}: lengths in metres", path.display()))?;
        file.calibration.validate().with_context(place)?;
        check_teeth(&file.calibration).with_context(place)?;
        check_sensor(&file.calibration, &Geometry::PAPER).with_context(place)?;
        Ok(file.calibration)
    }
}

/// The beacon stands on the platen, wherever its zero is.
fn check_teeth(calibration: &Calibration) -> Result<()> {
    const LONGEST_M: f32 = 100.0;
    let most = LONGEST_M / calibration.geometry.pitch_m;
    for teeth in calibration
        .beacon
        .iter()
        .flat_map(|beacon| beacon.origin_teeth)
    {
        ensure!(
            teeth as f32 <= most && teeth as f32 >= -most,
            "beacon.origin_teeth is {teeth}, wanted -{most:.0} to {most:.0}"
        );
    }
    Ok(())
}

/// Refuses a geometry that is not the board's own: pitch, span and what the drawing says must be the same, height and lever arm
/// within what a joint calibration may find.
///
/// # Errors
/// The first length that differs.
pub fn check_own_geometry(calibration: &Calibration) -> Result<()> {
    let (found, own) = (&calibration.geometry, &Geometry::PAPER);
    let fitted = JointLimits::default().geometry_share;
    let [lever_x_m, lever_y_m] = [(0, "lever_m[0]"), (1, "lever_m[1]")]
        .map(|(axis, name)| (name, found.lever_m[axis], own.lever_m[axis], fitted));
    // A lever arm is judged by its length: one part of it may be small.
    let length_m = own.lever_m[0].hypot(own.lever_m[1]);
    let numbers = [
        ("pitch_m", found.pitch_m, own.pitch_m, 0.0),
        ("span_m", found.span_m, own.span_m, 0.0),
        ("lateral_m", found.lateral_m, own.lateral_m, 0.0),
        (
            "tan_full_scale",
            found.tan_full_scale,
            own.tan_full_scale,
            0.0,
        ),
        ("height_m", found.height_m, own.height_m, fitted),
        lever_x_m,
        lever_y_m,
    ];
    for (name, found, wanted, share) in numbers {
        let size = if name.starts_with("lever") {
            length_m
        } else {
            wanted
        };
        ensure!(
            (found - wanted).abs() <= share * size.abs(),
            "geometry.{name}: found {found}, wanted the board's own {wanted}{} (or --other-geometry)",
            if share > 0.0 {
                format!(" within {}", share * size.abs())
            } else {
                String::new()
            }
        );
    }
    Ok(())
}

/// What a board would check before it takes a calibration, so that the number and its range can be named.
fn usable(calibration: &Calibration) -> Result<(), ConfigError> {
    let settings = Settings {
        geometry: calibration.geometry,
        pairs: calibration.pairs,
        model: Some(calibration.model.clone()),
        beacon: calibration.beacon.as_ref().map(|beacon| BeaconSettings {
            origin_teeth: beacon.origin_teeth,
            origin_m: beacon.origin_m,
            sensor: beacon.sensor,
            segment_sd_m: beacon.segment_sd_m,
            displacement_sd_m: beacon.displacement_sd_m,
        }),
        ..Settings::default()
    };
    settings.validate()
}

#[cfg(test)]
mod tests {
    use super::*;
    use courier_sensor::calibration::record::Beacon;
    use courier_sensor::model::{ErrorModel, Multiplier, Term, TermTable};
    use serde_json::{Value, json};

    /// A joint calibration with a term of every kind.
    fn sound() -> Value {
        let mut calibration = Calibration::identity(Geometry::PAPER);
        let mut terms = TermTable::equation_9();
        for term in [
            Term::own(3),
            Term::own(1).with_theta(1),
            Term {
                multiplier: Multiplier::Temperature,
                ..Term::own(1)
            },
        ] {
            terms.push(term).unwrap();
        }
        calibration.model = ErrorModel::zero(terms);
        calibration.beacon = Some(Beacon {
            segment_sd_m: 1.0e-6,
            displacement_sd_m: 1.0e-6,
            ..Beacon::default()
        });
        serde_json::to_value(CalibrationFile::new(calibration)).unwrap()
    }

    /// What the file is refused for; none if it is taken.
    fn refusal(file: &Value) -> Option<String> {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("c.json");
        std::fs::write(&path, file.to_string()).unwrap();
        CalibrationFile::read(&path)
            .err()
            .map(|error| format!("{error:#}"))
    }

    /// JSON pointers of all numbers.
    fn numbers(value: &Value, at: &str, found: &mut Vec<String>) {
        match value {
            Value::Number(_) => found.push(at.to_owned()),
            Value::Object(fields) => fields
                .iter()
                .for_each(|(name, value)| numbers(value, &format!("{at}/{name}"), found)),
            Value::Array(items) => items
                .iter()
                .enumerate()
                .for_each(|(place, value)| numbers(value, &format!("{at}/{place}"), found)),
            _ => {}
        }
    }

    #[test]
    fn every_number_has_a_range() {
        let file = sound();
        assert_eq!(refusal(&file), None);
        let mut places = Vec::new();
        numbers(&file["calibration"], "/calibration", &mut places);
        assert!(places.len() > 60, "{places:?}");
        for place in places {
            for bad in [json!(1.0e30), json!(-1.0e30), Value::Null] {
                let mut file = file.clone();
                *file.pointer_mut(&place).unwrap() = bad.clone();
                let told = refusal(&file);
                assert!(told.is_some(), "{place} = {bad} was taken");
            }
        }
    }

    /// The kinds of mistakes that people make, each with the field's name, what was found and what was wanted.
    #[test]
    fn impossible_numbers_are_named() {
        let cases = [
            (
                "geometry/pitch_m",
                json!(2.032e-3),
                "pitch_m is 0.002032, wanted 0.00090958",
            ),
            (
                "geometry/span_m",
                json!(0.097),
                "span_m is 0.097, wanted 0.00485",
            ),
            (
                "amplitude_counts/2",
                json!(-1.0),
                "amplitude_counts is -1, wanted 0",
            ),
            (
                "temperature_c",
                json!(-400),
                "temperature_c is -400, wanted -65 to 150",
            ),
            (
                "beacon/sensor/3",
                json!(2.0),
                "beacon.sensor is 2, wanted -1 to 1",
            ),
            (
                "model/coefficients/0/1/0",
                json!(0.1),
                "segment 2's coefficients add up to 0.1 m, wanted at most half a pitch",
            ),
            (
                "model/coefficients/6/0/0",
                json!(0.1),
                "segment 1: coefficient of term 6",
            ),
            (
                "model/constants_m/0",
                json!(1.0e6),
                "segment 1: constant, found 1000000",
            ),
            ("pairs/1/gain", json!(-1.0), "gain is -1, wanted 0.1 to 10"),
            ("quality/residual_after_m", json!(-1.0), "quality"),
        ];
        for (place, bad, wanted) in cases {
            let mut file = sound();
            *file.pointer_mut(&format!("/calibration/{place}")).unwrap() = bad;
            let told = refusal(&file).unwrap_or_default();
            assert!(
                told.contains(wanted),
                "{place}: wanted {wanted:?} in {told:?}"
            );
            assert!(!told.contains("Some("), "{told}");
        }
    }

    #[test]
    fn another_geometry_is_told_from_an_impossible_one() {
        let read = |change: fn(&mut Geometry)| {
            let mut calibration = Calibration::identity(Geometry::PAPER);
            change(&mut calibration.geometry);
            check_own_geometry(&calibration).map_err(|error| error.to_string())
        };
        assert_eq!(read(|_| ()), Ok(()));
        // What a joint calibration may find.
        assert_eq!(read(|g| (g.height_m, g.lever_m[1]) = (0.0511, 0.0)), Ok(()));
        let told = read(|g| g.pitch_m *= 1.01).unwrap_err();
        for word in ["pitch_m", "0.00102616", "0.001016", "--other-geometry"] {
            assert!(told.contains(word), "{told}");
        }
        assert!(
            read(|g| g.lever_m[0] = -0.09)
                .unwrap_err()
                .contains("lever_m[0]")
        );
        assert!(read(|g| g.height_m = 0.5).unwrap_err().contains("height_m"));
        let mut other = Calibration::identity(Geometry::PAPER);
        other.geometry.pitch_m *= 1.01;
        assert_eq!(check_sensor(&other, &Geometry::PAPER), Ok(()));
    }
}
