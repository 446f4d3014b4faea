//! One value of a row in the table of answers, with the type that its column has in every file.

use serde_json::{Value, json};

/// A value, or none.
#[derive(Clone, Debug, PartialEq)]
pub enum Cell {
    /// Text.
    Text(Option<String>),
    /// A number; not finite is none.
    Real(Option<f64>),
    /// A whole number.
    Whole(Option<i32>),
}

impl Cell {
    /// Text that is none where it is empty.
    pub fn text(text: impl Into<String>) -> Self {
        Self::Text(Some(text.into()).filter(|text| !text.is_empty()))
    }

    /// A number.
    pub fn real(value: f64) -> Self {
        Self::Real(Some(value).filter(|value| value.is_finite()))
    }

    /// A number of things.
    pub fn count(value: usize) -> Self {
        Self::Whole(i32::try_from(value).ok())
    }

    /// As JSON has it.
    pub fn json(&self) -> Value {
        match self {
            Self::Text(text) => json!(text),
            Self::Real(value) => json!(value),
            Self::Whole(value) => json!(value),
        }
    }
}

/// A row: names of columns and their values, in the order in which they are written.
pub type Row = Vec<(String, Cell)>;
