//! What the readings say of the stated geometry, beside what is stated.

use serde::{Deserialize, Serialize};

/// A stated value and the same by the data.
#[derive(Clone, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct Fitted {
    /// Its key in `recording.toml`: `height_m`, `lever_x_m`, `lever_y_m`, `span_m` or `pitch_m`.
    pub name: String,
    /// As stated, m.
    pub stated_m: f64,
    /// By the data, m. A height is that at the stated full scale.
    pub found_m: f64,
    /// How far off it may be, m: as if all that the fit leaves were one error that moves with what the value acts on.
    pub error_m: f64,
}

impl Fitted {
    /// From a value over the stated one, and the error of that.
    pub(crate) fn scaled(name: &str, stated_m: f64, [share, error]: [f64; 2]) -> Self {
        Self {
            name: name.into(),
            stated_m,
            found_m: share * stated_m,
            error_m: error * stated_m.abs(),
        }
    }
}
