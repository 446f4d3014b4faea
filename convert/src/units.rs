//! Units in which logs state what a recording states in SI.

use recording::Column;

/// What kind of quantity a column of a recording holds.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Quantity {
    /// Seconds.
    Time,
    /// Metres; a log may hold an angle of a shaft instead.
    Length,
    /// Radians.
    Angle,
    /// Degrees Celsius.
    Temperature,
    /// Counts of a converter; a log may hold volts instead.
    Counts,
    /// Whole teeth.
    Teeth,
}

impl Quantity {
    /// That of a recording's column.
    #[must_use]
    pub fn of(column: Column) -> Self {
        match column {
            Column::Time => Self::Time,
            Column::Sine(_) | Column::Cosine(_) | Column::Electrode(_) => Self::Counts,
            Column::Teeth(_) => Self::Teeth,
            Column::Position(_) => Self::Length,
            Column::Temperature => Self::Temperature,
            Column::Commanded(axis) | Column::Reference(axis) if axis < 2 => Self::Length,
            Column::Commanded(_) | Column::Reference(_) => Self::Angle,
        }
    }

    /// Name of the unit that a column is taken in where nothing else is said.
    #[must_use]
    pub fn default_unit(self) -> Unit {
        match self {
            Self::Time => Unit::linear("s", 1.0),
            Self::Length => Unit::linear("m", 1.0),
            Self::Angle => Unit::linear("rad", 1.0),
            Self::Temperature => Unit::linear("C", 1.0),
            Self::Counts => Unit::linear("counts", 1.0),
            Self::Teeth => Unit::linear("teeth", 1.0),
        }
    }

    /// Every unit that such a column may be in.
    #[must_use]
    pub fn units(self) -> Vec<Unit> {
        let linear = |list: &[(&'static str, f64)]| -> Vec<Unit> {
            list.iter()
                .map(|(name, factor)| Unit::linear(name, *factor))
                .collect()
        };
        match self {
            Self::Time => linear(&[
                ("s", 1.0),
                ("ms", 1e-3),
                ("us", 1e-6),
                ("ns", 1e-9),
                ("min", 60.0),
                ("h", 3600.0),
            ]),
            Self::Length => {
                let mut units = linear(&LENGTHS);
                units.extend(TURNS.map(|(name, turns)| Unit::turn(name, turns)));
                units
            }
            Self::Angle => TURNS
                .map(|(name, turns)| Unit::linear(name, turns * std::f64::consts::TAU))
                .to_vec(),
            Self::Temperature => vec![
                Unit::linear("C", 1.0),
                Unit {
                    name: "K",
                    factor: 1.0,
                    offset: -273.15,
                    of_turn: false,
                },
                Unit {
                    name: "F",
                    factor: 5.0 / 9.0,
                    offset: -160.0 / 9.0,
                    of_turn: false,
                },
            ],
            Self::Counts => linear(&[("counts", 1.0), ("V", 1.0), ("mV", 1e-3)]),
            Self::Teeth => linear(&[("teeth", 1.0)]),
        }
    }

    /// The unit of this name, capitals or not; `µ` and `u`, `°` and `deg` are alike.
    #[must_use]
    pub fn unit(self, name: &str) -> Option<Unit> {
        let plain = plain(name);
        let wanted = SYNONYMS
            .iter()
            .find(|(other, _)| *other == plain)
            .map_or(plain.as_str(), |(_, known)| known);
        self.units()
            .into_iter()
            .find(|unit| unit.name.eq_ignore_ascii_case(wanted))
    }

    /// Names of the units, for a message.
    #[must_use]
    pub fn unit_names(self) -> String {
        let names: Vec<&str> = self.units().iter().map(|unit| unit.name).collect();
        names.join(", ")
    }
}

/// Lengths and their metres; an inch is 25.4 mm by definition.
const LENGTHS: [(&str, f64); 6] = [
    ("m", 1.0),
    ("mm", 1e-3),
    ("um", 1e-6),
    ("nm", 1e-9),
    ("cm", 1e-2),
    ("inch", 25.4e-3),
];

/// Angles and their turns.
const TURNS: [(&str, f64); 6] = [
    ("rad", 1.0 / std::f64::consts::TAU),
    ("mrad", 1e-3 / std::f64::consts::TAU),
    ("deg", 1.0 / 360.0),
    ("turn", 1.0),
    ("arcmin", 1.0 / 21_600.0),
    ("arcsec", 1.0 / 1_296_000.0),
];

/// Other names of units, in small letters and with `u` for `µ`.
const SYNONYMS: [(&str, &str); 24] = [
    ("sec", "s"),
    ("second", "s"),
    ("seconds", "s"),
    ("msec", "ms"),
    ("usec", "us"),
    ("micron", "um"),
    ("microns", "um"),
    ("in", "inch"),
    ("°", "deg"),
    ("degree", "deg"),
    ("degrees", "deg"),
    ("turns", "turn"),
    ("rev", "turn"),
    ("revs", "turn"),
    ("rad", "rad"),
    ("°c", "c"),
    ("degc", "c"),
    ("celsius", "c"),
    ("kelvin", "k"),
    ("°f", "f"),
    ("count", "counts"),
    ("lsb", "counts"),
    ("volt", "v"),
    ("volts", "v"),
];

fn plain(name: &str) -> String {
    name.trim().to_lowercase().replace(['µ', 'μ'], "u")
}

/// A unit: `value * factor + offset` is in the recording's own.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Unit {
    /// Its name.
    pub name: &'static str,
    /// Factor to the recording's unit, or to turns of a shaft.
    pub factor: f64,
    /// Added after it.
    pub offset: f64,
    /// True of an angle in a column of lengths: a turn becomes so many periods, and a period a pitch.
    pub of_turn: bool,
}

impl Unit {
    fn linear(name: &'static str, factor: f64) -> Self {
        Self {
            name,
            factor,
            offset: 0.0,
            of_turn: false,
        }
    }

    fn turn(name: &'static str, turns: f64) -> Self {
        Self {
            name,
            factor: turns,
            offset: 0.0,
            of_turn: true,
        }
    }

    /// True of any angle: such a column may begin anew at each turn.
    #[must_use]
    pub fn is_angle(&self) -> bool {
        TURNS.iter().any(|(name, _)| *name == self.name)
    }

    /// One whole turn in this unit, where it is one of angles.
    #[must_use]
    pub fn turn_in_it(&self) -> Option<f64> {
        TURNS
            .iter()
            .find(|(name, _)| *name == self.name)
            .map(|(_, turns)| 1.0 / turns)
    }
}

/// A length with its unit, as in `1.016mm`; metres without one.
///
/// # Errors
/// No number, or no unit of length; in words.
pub fn length_m(text: &str) -> Result<f64, String> {
    let wanted = "wanted a length as in 1.016mm: a number and m, mm, um, nm, cm or inch";
    let text = text.trim();
    let unit_at = text
        .find(|letter: char| letter.is_alphabetic() && !"eE".contains(letter))
        .unwrap_or(text.len());
    let (number, unit) = text.split_at(unit_at);
    let number: f64 = number.trim().parse().map_err(|_| wanted.to_owned())?;
    let unit = match unit {
        "" => Some(Quantity::Length.default_unit()),
        _ => Quantity::Length.unit(unit).filter(|unit| !unit.of_turn),
    };
    let length_m = number * unit.ok_or(wanted)?.factor;
    length_m
        .is_finite()
        .then_some(length_m)
        .ok_or_else(|| wanted.to_owned())
}

/// The unit that a column's name ends with, as in `stage [mm]`, `stage (mm)` or `stage_mm`, where such a column can be in it. Bare
/// `_in` is none: it is more often an input than an inch.
#[must_use]
pub fn unit_in_name(quantity: Quantity, name: &str) -> Option<Unit> {
    let name = name.trim();
    let bracketed = [('[', ']'), ('(', ')')]
        .into_iter()
        .find_map(|(open, close)| {
            name.strip_suffix(close)?
                .rsplit_once(open)
                .map(|(_, unit)| unit)
        });
    let suffix = || {
        name.rsplit_once('_')
            .map(|(_, unit)| unit)
            .filter(|unit| *unit != "in")
    };
    quantity.unit(bracketed.or_else(suffix)?)
}

/// The name of a column without the unit in brackets behind it.
#[must_use]
pub fn name_without_unit(name: &str) -> &str {
    name.split(['[', '(']).next().unwrap_or(name).trim()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn units_by_name_and_by_the_name_of_a_column() {
        for (quantity, name, factor) in [
            (Quantity::Length, "mm", 1e-3),
            (Quantity::Length, "µm", 1e-6),
            (Quantity::Length, "UM", 1e-6),
            (Quantity::Length, "°", 1.0 / 360.0),
            (Quantity::Angle, "deg", std::f64::consts::PI / 180.0),
            (Quantity::Time, "ms", 1e-3),
            (Quantity::Counts, "mV", 1e-3),
        ] {
            let unit = quantity.unit(name).unwrap();
            assert!(
                (unit.factor / factor - 1.0).abs() < 1e-12,
                "{name}: {unit:?}"
            );
        }
        assert_eq!(Quantity::Length.unit("K"), None);
        for (name, unit) in [
            ("stage [mm]", Some("mm")),
            ("stage (µm)", Some("um")),
            ("stage_deg", Some("deg")),
            ("stage_in", None),
            ("stage", None),
        ] {
            assert_eq!(
                unit_in_name(Quantity::Length, name).map(|unit| unit.name),
                unit,
                "{name}"
            );
        }
        assert_eq!(name_without_unit("stage [mm]"), "stage");
    }

    #[test]
    fn lengths_with_their_units() {
        for (text, length) in [
            ("1.016mm", 1.016e-3),
            ("1e-3", 1.0e-3),
            ("-9.7 mm", -9.7e-3),
            ("0.1inch", 2.54e-3),
            ("5e2µm", 5.0e-4),
        ] {
            assert!(
                (length_m(text).unwrap() / length - 1.0).abs() < 1e-12,
                "{text}"
            );
        }
        for text in ["", "mm", "1kg", "1deg", "1mm2", "e"] {
            assert!(length_m(text).is_err(), "{text}");
        }
    }

    #[test]
    fn temperatures_by_their_fixed_points() {
        let celsius = |name: &str, value: f64| {
            let unit = Quantity::Temperature.unit(name).unwrap();
            value * unit.factor + unit.offset
        };
        for (name, ice, steam) in [
            ("C", 0.0, 100.0),
            ("K", 273.15, 373.15),
            ("°F", 32.0, 212.0),
        ] {
            assert!(celsius(name, ice).abs() < 1e-9, "{name}");
            assert!((celsius(name, steam) - 100.0).abs() < 1e-9, "{name}");
        }
    }
}
