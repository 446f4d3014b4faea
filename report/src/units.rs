//! Amounts as a reader is told them: lengths in micrometres, angles in milliradians, times in microseconds, ratios in percent.

use diagnosis::verdict::answer::{Follows, Magnitude, Named};

/// A unit of the model, the one that it is told in, and how many of those make one of these.
const UNITS: [(&str, &str, f64); 10] = [
    ("m", "µm", 1.0e6),
    ("rad", "mrad", 1.0e3),
    ("s", "µs", 1.0e6),
    ("s²/m", "µs per m/s", 1.0e6),
    ("m/K", "µm/K", 1.0e6),
    ("m/K²", "µm/K²", 1.0e6),
    ("m/rad", "µm/mrad", 1.0e3),
    ("m/rad²", "µm/mrad²", 1.0),
    ("m/rad⁴", "µm/mrad⁴", 1.0e-6),
    ("1", "%", 1.0e2),
];
/// Units of logged columns by what their names end with, as in `aux_motor_a`.
const OF_COLUMNS: [(&str, &str); 17] = [
    ("a", "A"),
    ("ma", "mA"),
    ("v", "V"),
    ("mv", "mV"),
    ("w", "W"),
    ("c", "°C"),
    ("k", "K"),
    ("rh", "% RH"),
    ("pa", "Pa"),
    ("hpa", "hPa"),
    ("n", "N"),
    ("nm", "N m"),
    ("m", "m"),
    ("rad", "rad"),
    ("hz", "Hz"),
    ("rpm", "rpm"),
    ("mt", "mT"),
];
/// Most digits after the point.
const DIGITS: i32 = 9;
/// Digits of a value whose deviation is not known.
const OF_A_VALUE: i32 = 3;

/// An amount with its deviation and its unit, e.g. `1.234 ± 0.012 µm`.
#[must_use]
pub fn amount(magnitude: &Magnitude) -> String {
    let known = UNITS.iter().find(|(unit, _, _)| *unit == magnitude.unit);
    let (unit, factor) = known.map_or((magnitude.unit.as_str(), 1.0), |(_, told, by)| (told, *by));
    let deviation = magnitude.deviation.map(|d| d * factor);
    format!("{} {unit}", beside(magnitude.value * factor, deviation))
}

/// The unit of a logged column by the end of its name; none where that is no unit.
#[must_use]
pub fn of_column(name: &str) -> Option<&'static str> {
    let end = name.rsplit('_').next()?;
    let unit = OF_COLUMNS.iter().find(|(known, _)| *known == end);
    unit.map(|(_, unit)| *unit)
}

/// How what is left follows a logged column, e.g. `0.400 ± 0.012 µm rms for 1 A of aux_motor_a in segment_2, other at each phase of a tooth`.
#[must_use]
pub fn follows(what: &Follows) -> String {
    let [slope, deviation] = [what.per_unit_m, what.deviation_m].map(|m| 1.0e6 * m);
    let one = of_column(&what.column).map_or_else(
        || format!("one unit of {}", what.column),
        |unit| format!("1 {unit} of {}", what.column),
    );
    let over = if what.over_teeth {
        ", other at each phase of a tooth"
    } else {
        ""
    };
    format!(
        "{} µm rms for {one} in {}{over}",
        beside(slope, Some(deviation)),
        what.of
    )
}

/// An amount's name, where micrometres are written as they are elsewhere.
#[must_use]
pub fn name(magnitude: &Magnitude) -> String {
    magnitude.name.replace(" um ", " µm ")
}

/// An effect's total, e.g. `3.0 ± 0.1 µm rms`; none where it has none.
#[must_use]
pub fn total(effect: &Named) -> Option<String> {
    let value = 1.0e6 * effect.total_rms_m?;
    let deviation = effect.total_deviation_m.map(|d| 1.0e6 * d);
    Some(format!("{} µm rms", beside(value, deviation)))
}

/// A length in micrometres to so many digits that tell something.
#[must_use]
pub fn micrometres(length_m: f64) -> String {
    format!("{} µm", significant(1.0e6 * length_m, OF_A_VALUE))
}

/// A value to two digits of its deviation. What has no deviation, or a negligible one, stands alone.
fn beside(value: f64, deviation: Option<f64>) -> String {
    let Some(deviation) = deviation.filter(|d| d.is_finite() && *d > 0.0) else {
        return significant(value, OF_A_VALUE);
    };
    let digits = (1 - magnitude(deviation)).clamp(0, DIGITS) as usize;
    let value = format!("{value:.digits$}");
    let value = match value.strip_prefix('-') {
        Some(size) if size.parse() == Ok(0.0) => size,
        _ => &value,
    };
    format!("{value} ± {deviation:.digits$}")
}

/// A value to so many digits, without zeros at its end.
fn significant(value: f64, digits: i32) -> String {
    let after = (digits - 1 - magnitude(value)).clamp(0, DIGITS) as usize;
    let text = format!("{value:.after$}");
    if text.contains('.') {
        text.trim_end_matches('0').trim_end_matches('.').to_owned()
    } else {
        text
    }
}

/// Power of ten of the first digit that is not zero.
fn magnitude(value: f64) -> i32 {
    if value == 0.0 {
        0
    } else {
        value.abs().log10().floor() as i32
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn an_amount_is_told_in_one_unit_to_two_digits_of_its_deviation() {
        let told = |value: f64, deviation: Option<f64>, unit: &str| {
            amount(&Magnitude {
                name: String::new(),
                value,
                deviation,
                unit: unit.into(),
            })
        };
        assert_eq!(told(1.23456e-6, Some(1.2e-8), "m"), "1.235 ± 0.012 µm");
        assert_eq!(told(-5.0e-5, Some(2.0e-6), "s"), "-50.0 ± 2.0 µs");
        assert_eq!(told(1.5e-4, Some(1.0e-5), "1"), "0.0150 ± 0.0010 %");
        assert_eq!(told(0.5e-9, None, "m"), "0.0005 µm");
        assert_eq!(told(-1.0, Some(0.0), "teeth"), "-1 teeth");
        assert_eq!(told(2.5e-3, None, "rad"), "2.5 mrad");
        assert_eq!(told(1234.56e-6, Some(150.0e-6), "m"), "1235 ± 150 µm");
        assert_eq!(told(7.0, None, "samples"), "7 samples");
        assert_eq!(
            told(-2.0e-9, Some(1.7e-7), "s²/m"),
            "0.00 ± 0.17 µs per m/s"
        );
    }

    #[test]
    fn what_follows_a_column_is_told_by_its_unit() {
        let mut what = Follows {
            column: "aux_motor_a".into(),
            of: "segment_2".into(),
            over_teeth: true,
            per_unit_m: 4.0e-7,
            deviation_m: 1.2e-8,
        };
        assert_eq!(
            follows(&what),
            "0.400 ± 0.012 µm rms for 1 A of aux_motor_a in segment_2, other at each phase of a tooth"
        );
        what.column = "aux_load".into();
        what.over_teeth = false;
        assert_eq!(
            follows(&what),
            "0.400 ± 0.012 µm rms for one unit of aux_load in segment_2"
        );
    }

    #[test]
    fn no_amount_of_the_catalogue_is_told_as_a_bare_one() {
        for (unit, told, _) in UNITS {
            assert_ne!(told, "1", "{unit}");
        }
    }
}
