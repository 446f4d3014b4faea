//! The columns of `samples.csv`: names, and what a value must be.

/// A numeric column of `samples.csv`. Segments and axes are indices from 0; `run` is not numeric and apart.
#[derive(Clone, Copy, Debug, PartialEq, Eq, Hash)]
pub enum Column {
    /// `t_s`, seconds.
    Time,
    /// `q1s` … `q4s`, counts.
    Sine(usize),
    /// `q1c` … `q4c`, counts.
    Cosine(usize),
    /// `n1` … `n4`, whole teeth.
    Teeth(usize),
    /// `p1_m` … `p4_m`, metres.
    Position(usize),
    /// `psd_xp`, `psd_xn`, `psd_yp`, `psd_yn`, counts.
    Electrode(usize),
    /// `temp_c`, degrees Celsius.
    Temperature,
    /// `cmd_x_m`, `cmd_y_m`, `cmd_theta_rad`.
    Commanded(usize),
    /// `ref_x_m`, `ref_y_m`, `ref_theta_rad`.
    Reference(usize),
}

/// The quantity beside the layout's columns that is an encoder's index: a pulse once a turn, of any levels.
pub const INDEX: &str = "aux_index";

/// True for the name of a quantity that is logged beside the layout's columns: `aux_` and letters, digits or underscores.
pub(crate) fn is_logged(name: &str) -> bool {
    let rest = name.strip_prefix("aux_").unwrap_or("");
    !rest.is_empty() && rest.chars().all(|c| c.is_ascii_alphanumeric() || c == '_')
}

/// Number of numeric columns.
pub(crate) const COUNT: usize = 28;

/// Every numeric column in the order in which they are written, with its name.
pub const COLUMNS: [(Column, &str); COUNT] = [
    (Column::Time, "t_s"),
    (Column::Sine(0), "q1s"),
    (Column::Cosine(0), "q1c"),
    (Column::Sine(1), "q2s"),
    (Column::Cosine(1), "q2c"),
    (Column::Sine(2), "q3s"),
    (Column::Cosine(2), "q3c"),
    (Column::Sine(3), "q4s"),
    (Column::Cosine(3), "q4c"),
    (Column::Teeth(0), "n1"),
    (Column::Teeth(1), "n2"),
    (Column::Teeth(2), "n3"),
    (Column::Teeth(3), "n4"),
    (Column::Position(0), "p1_m"),
    (Column::Position(1), "p2_m"),
    (Column::Position(2), "p3_m"),
    (Column::Position(3), "p4_m"),
    (Column::Electrode(0), "psd_xp"),
    (Column::Electrode(1), "psd_xn"),
    (Column::Electrode(2), "psd_yp"),
    (Column::Electrode(3), "psd_yn"),
    (Column::Temperature, "temp_c"),
    (Column::Commanded(0), "cmd_x_m"),
    (Column::Commanded(1), "cmd_y_m"),
    (Column::Commanded(2), "cmd_theta_rad"),
    (Column::Reference(0), "ref_x_m"),
    (Column::Reference(1), "ref_y_m"),
    (Column::Reference(2), "ref_theta_rad"),
];

/// Largest length that is taken for metres: anything longer is a unit gone wrong.
const LENGTH_LIMIT_M: f64 = 1.0e3;
/// Largest angle, radians: many turns of a rotary rig, and no more.
const ANGLE_LIMIT_RAD: f64 = 1.0e4;
/// Largest time, seconds: Unix time fits, Unix time in milliseconds does not.
const TIME_LIMIT_S: f64 = 1.0e11;
/// Range of temperatures, degrees Celsius: absolute zero to beyond any board.
const TEMPERATURE_RANGE_C: [f64; 2] = [-273.15, 500.0];

/// What the tables of units say about the range of counts.
#[derive(Clone, Copy, Debug, Default)]
pub(crate) struct CountLimits {
    /// Lowest and highest quadrature count of the converter.
    pub quadrature: Option<[f64; 2]>,
    /// Lowest and highest electrode count.
    pub electrode: Option<[f64; 2]>,
}

impl Column {
    /// Name in the header row; an index out of range gives that of the last such column.
    pub fn name(self) -> &'static str {
        COLUMNS[self.index()].1
    }

    /// The column of this name.
    pub fn by_name(name: &str) -> Option<Self> {
        COLUMNS
            .iter()
            .find(|(_, known)| *known == name)
            .map(|(column, _)| *column)
    }

    /// Place in [`COLUMNS`].
    pub(crate) fn index(self) -> usize {
        match self {
            Self::Time => 0,
            Self::Sine(segment) => 1 + 2 * segment.min(3),
            Self::Cosine(segment) => 2 + 2 * segment.min(3),
            Self::Teeth(segment) => 9 + segment.min(3),
            Self::Position(segment) => 13 + segment.min(3),
            Self::Electrode(electrode) => 17 + electrode.min(3),
            Self::Temperature => 21,
            Self::Commanded(axis) => 22 + axis.min(2),
            Self::Reference(axis) => 25 + axis.min(2),
        }
    }

    /// True of columns that a converter counts.
    pub(crate) fn is_count(self) -> bool {
        matches!(self, Self::Sine(_) | Self::Cosine(_) | Self::Electrode(_))
    }

    /// Says what was wanted if `value` cannot stand in this column.
    pub(crate) fn check(self, value: f64, limits: &CountLimits) -> Result<(), String> {
        if !value.is_finite() {
            return Err("a finite number".to_owned());
        }
        match self {
            Self::Sine(_) | Self::Cosine(_) => counts(value, limits.quadrature),
            Self::Electrode(_) => counts(value, limits.electrode),
            Self::Teeth(_) if value.fract() != 0.0 || value.abs() > f64::from(i32::MAX) => {
                Err("a whole number of teeth within 32 bits".to_owned())
            }
            Self::Teeth(_) => Ok(()),
            Self::Time => within(value, [-TIME_LIMIT_S, TIME_LIMIT_S], "s"),
            Self::Temperature => within(value, TEMPERATURE_RANGE_C, "°C"),
            Self::Commanded(2) | Self::Reference(2) => {
                within(value, [-ANGLE_LIMIT_RAD, ANGLE_LIMIT_RAD], "rad")
            }
            Self::Position(_) | Self::Commanded(_) | Self::Reference(_) => {
                within(value, [-LENGTH_LIMIT_M, LENGTH_LIMIT_M], "m")
            }
        }
    }
}

fn within(value: f64, [low, high]: [f64; 2], unit: &str) -> Result<(), String> {
    if (low..=high).contains(&value) {
        Ok(())
    } else {
        Err(format!("{low} to {high} {unit}"))
    }
}

fn counts(value: f64, range: Option<[f64; 2]>) -> Result<(), String> {
    match range {
        Some([low, high]) if !(low..=high).contains(&value) => Err(format!(
            "a count within the converter's range, {low} to {high}"
        )),
        _ => Ok(()),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn table_and_index_agree() {
        for (place, (column, name)) in COLUMNS.iter().enumerate() {
            assert_eq!(column.index(), place);
            assert_eq!(Column::by_name(name), Some(*column));
        }
    }
}
