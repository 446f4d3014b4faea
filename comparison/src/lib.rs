//! Calibrations compared: whether their difference is more than chance, which terms changed, by how many micrometres and where; how
//! several of them go with time; and what a calibrated position or angle is worth, as an uncertainty budget.
//!
//! `estimate` (values and covariance of one calibration; `record` makes it of what a board stores, by `design`, which knows the `rows`, of `visited` poses or as `expected` by the `phases` that were passed, or, under a beacon, `joint`) -> `difference` ->
//! `significance` (all together), `changes` (term by term), `largest` (over the `workspace`), `trend` (over several), each ± by how `repeats` scatter; `budget` is of
//! one estimate. `answer` puts together what is asked. `distribution` has the quantiles. Values in, values out: no file, no clock.

pub mod answer;
pub mod budget;
pub mod changes;
mod coefficients;
mod design;
pub mod difference;
pub mod distribution;
pub mod estimate;
mod expected;
mod joint;
pub mod largest;
mod lateral;
mod phases;
pub mod record;
pub mod repeats;
mod rows;
pub mod significance;
pub mod trend;
mod visited;
pub mod workspace;

/// What intervals and tests are for: 95 %, two-sided. By definition as is usual (Fisher 1925).
pub const COVERAGE: f64 = 0.95;
