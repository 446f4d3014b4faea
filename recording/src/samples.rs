//! Samples in columns, and one row of them.

use crate::column::{COUNT, Column};
use std::collections::HashMap;
use std::f64::consts::TAU;
use std::ops::Range;

/// A stretch ends at a gap of over this many sample intervals.
const GAP_INTERVALS: f64 = 10.0;

/// One sample. `None` is not measured. Segments and axes are in the order of the columns.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Row<'a> {
    /// Time, s.
    pub t_s: f64,
    /// Name of the motion.
    pub run: &'a str,
    /// `[segment][sine, cosine]`, counts.
    pub quadrature_counts: [Option<[f64; 2]>; 4],
    /// Tooth count of each segment.
    pub teeth: [Option<i32>; 4],
    /// Unmodified output of each segment, where no counts were logged, m.
    pub position_m: [Option<f64>; 4],
    /// Electrodes x+, x-, y+, y-, counts.
    pub electrode_counts: Option<[f64; 4]>,
    /// Board temperature, degrees Celsius.
    pub temperature_c: Option<f64>,
    /// Commanded x (m), y (m), theta (rad): open loop, never a truth.
    pub commanded: [Option<f64>; 3],
    /// Independent reference x (m), y (m), theta (rad).
    pub reference: [Option<f64>; 3],
}

impl Row<'_> {
    /// Value of one column; NaN where it was not measured.
    pub fn get(&self, column: Column) -> f64 {
        let value = match column {
            Column::Time => Some(self.t_s),
            Column::Sine(segment) => self.quadrature_counts[segment].map(|pair| pair[0]),
            Column::Cosine(segment) => self.quadrature_counts[segment].map(|pair| pair[1]),
            Column::Teeth(segment) => self.teeth[segment].map(f64::from),
            Column::Position(segment) => self.position_m[segment],
            Column::Electrode(electrode) => self.electrode_counts.map(|counts| counts[electrode]),
            Column::Temperature => self.temperature_c,
            Column::Commanded(axis) => self.commanded[axis],
            Column::Reference(axis) => self.reference[axis],
        };
        value.unwrap_or(f64::NAN)
    }
}

/// The unmodified output `(teeth + atan2(sine, cosine) / 2 pi) * pitch`, metres.
pub fn unmodified_m(teeth: i32, [sine, cosine]: [f64; 2], pitch_m: f64) -> f64 {
    (f64::from(teeth) + sine.atan2(cosine) / TAU) * pitch_m
}

/// All samples, a vector a column. A column without a single value takes no memory.
#[derive(Clone, Debug, Default)]
pub struct Samples {
    length: usize,
    columns: [Vec<f64>; COUNT],
    runs: Vec<u32>,
    run_names: Vec<String>,
    run_numbers: HashMap<String, u32>,
    logged: Vec<Logged>,
}

/// A quantity that was logged beside the layout's columns: `aux_` and a name, in any unit.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Logged {
    /// Name of the column, with its `aux_`.
    pub name: String,
    /// One value a sample, NaN where it was not measured.
    pub values: Vec<f64>,
}

impl Samples {
    /// Number of samples.
    pub fn len(&self) -> usize {
        self.length
    }

    /// True without a sample.
    pub fn is_empty(&self) -> bool {
        self.length == 0
    }

    /// True if the column holds at least one value.
    pub fn has(&self, column: Column) -> bool {
        !self.columns[column.index()].is_empty()
    }

    /// The column, `[len()]` with NaN where not measured; empty if it holds no value at all.
    pub fn column(&self, column: Column) -> &[f64] {
        &self.columns[column.index()]
    }

    /// One value, `None` where it was not measured.
    pub fn get(&self, column: Column, index: usize) -> Option<f64> {
        self.column(column)
            .get(index)
            .copied()
            .filter(|value| !value.is_nan())
    }

    /// Quantities that were logged beside the layout's columns, in the order of the file; those without a value are not among them.
    pub fn logged(&self) -> &[Logged] {
        &self.logged
    }

    /// Adds such a quantity, of as many values as there are samples: further ones are dropped, missing ones are not measured.
    pub fn log(&mut self, mut logged: Logged) {
        logged.values.resize(self.length, f64::NAN);
        if logged.values.iter().any(|value| !value.is_nan()) {
            self.logged.push(logged);
        }
    }

    /// Times, s, strictly increasing.
    pub fn t_s(&self) -> &[f64] {
        self.column(Column::Time)
    }

    /// Name of the motion that the sample belongs to; empty if there is none.
    pub fn run(&self, index: usize) -> &str {
        self.run_names
            .get(self.runs[index] as usize)
            .map_or("", String::as_str)
    }

    /// Number of the motion, in order of first appearance: an index into [`Samples::run_names`].
    pub fn run_number(&self, index: usize) -> usize {
        self.runs[index] as usize
    }

    /// Names of all motions in order of first appearance.
    pub fn run_names(&self) -> &[String] {
        &self.run_names
    }

    /// Sine and cosine of a segment, where both were measured, counts.
    pub fn quadrature_counts(&self, segment: usize, index: usize) -> Option<[f64; 2]> {
        Some([
            self.get(Column::Sine(segment), index)?,
            self.get(Column::Cosine(segment), index)?,
        ])
    }

    /// Tooth count of a segment.
    pub fn teeth(&self, segment: usize, index: usize) -> Option<i32> {
        self.get(Column::Teeth(segment), index)
            .map(|teeth| teeth as i32)
    }

    /// Electrodes x+, x-, y+, y-, where all four were measured, counts.
    pub fn electrode_counts(&self, index: usize) -> Option<[f64; 4]> {
        let mut counts = [0.0; 4];
        for (electrode, count) in counts.iter_mut().enumerate() {
            *count = self.get(Column::Electrode(electrode), index)?;
        }
        Some(counts)
    }

    /// Unmodified output of a segment: from the counts where there are any, else as logged, metres.
    pub fn unmodified_m(&self, segment: usize, index: usize, pitch_m: f64) -> Option<f64> {
        match (
            self.quadrature_counts(segment, index),
            self.teeth(segment, index),
        ) {
            (Some(pair), Some(teeth)) => Some(unmodified_m(teeth, pair, pitch_m)),
            _ => self.get(Column::Position(segment), index),
        }
    }

    /// True if the segment has an output anywhere, by counts or as logged.
    pub fn has_segment(&self, segment: usize) -> bool {
        self.has(Column::Position(segment))
            || (self.has(Column::Sine(segment)) && self.has(Column::Teeth(segment)))
    }

    /// One sample.
    pub fn row(&self, index: usize) -> Row<'_> {
        Row {
            t_s: self.t_s()[index],
            run: self.run(index),
            quadrature_counts: std::array::from_fn(|segment| {
                self.quadrature_counts(segment, index)
            }),
            teeth: std::array::from_fn(|segment| self.teeth(segment, index)),
            position_m: std::array::from_fn(|segment| self.get(Column::Position(segment), index)),
            electrode_counts: self.electrode_counts(index),
            temperature_c: self.get(Column::Temperature, index),
            commanded: std::array::from_fn(|axis| self.get(Column::Commanded(axis), index)),
            reference: std::array::from_fn(|axis| self.get(Column::Reference(axis), index)),
        }
    }

    /// Appends a sample without any check: [`crate::Writer`] and the reader do those.
    pub fn push(&mut self, row: &Row) {
        for (place, (column, _)) in crate::COLUMNS.iter().enumerate() {
            self.set_next(place, row.get(*column));
        }
        self.end_row(row.run);
    }

    /// Puts `value` into the row that [`Samples::end_row`] will end; columns not set stay unmeasured.
    pub(crate) fn set_next(&mut self, place: usize, value: f64) {
        let column = &mut self.columns[place];
        if !value.is_nan() {
            column.resize(self.length, f64::NAN);
            column.push(value);
        }
    }

    /// Ends the row begun by [`Samples::set_next`].
    pub(crate) fn end_row(&mut self, run: &str) {
        let number = self.run_number_of(run);
        self.runs.push(number);
        self.length += 1;
        for column in self.columns.iter_mut().filter(|column| !column.is_empty()) {
            column.resize(self.length, f64::NAN);
        }
    }

    /// So many samples without a value, of these motions in order, each with its number of samples; further ones have none.
    pub(crate) fn of_runs(length: usize, runs: &[(String, usize)]) -> Self {
        let mut samples = Self::default();
        for (name, count) in runs {
            let number = samples.run_number_of(name.trim());
            let end = length.min(samples.runs.len().saturating_add(*count));
            samples.runs.resize(end, number);
        }
        if samples.runs.len() < length {
            let number = samples.run_number_of("");
            samples.runs.resize(length, number);
        }
        samples.length = length;
        samples
    }

    /// A whole column, `[len()]` with NaN where not measured.
    pub(crate) fn set_column(&mut self, column: Column, values: Vec<f64>) {
        if values.iter().any(|value| !value.is_nan()) {
            self.columns[column.index()] = values;
        }
    }

    fn run_number_of(&mut self, run: &str) -> u32 {
        if let Some(number) = self.run_numbers.get(run) {
            return *number;
        }
        let number = self.run_names.len() as u32;
        self.run_names.push(run.to_owned());
        self.run_numbers.insert(run.to_owned(), number);
        number
    }

    /// Median difference of time between neighbours, s; `None` with fewer than two samples.
    pub fn sample_interval_s(&self) -> Option<f64> {
        let mut differences: Vec<f64> = self
            .t_s()
            .windows(2)
            .map(|pair| pair[1] - pair[0])
            .collect();
        let middle = differences.len() / 2;
        if differences.is_empty() {
            return None;
        }
        Some(*differences.select_nth_unstable_by(middle, f64::total_cmp).1)
    }

    /// Sampling instants within the stretches that have no row, by the rows' times; none where these are not regular: fewer than nine in ten
    /// neighbours are one interval apart.
    pub fn missed_instants(&self) -> usize {
        let Some(interval_s) = self.sample_interval_s() else {
            return 0;
        };
        let neighbours = self.stretches().into_iter().flat_map(|stretch| {
            self.t_s()[stretch]
                .windows(2)
                .map(|pair| instants_between(pair[0], pair[1], interval_s))
                .collect::<Vec<u32>>()
        });
        let between: Vec<u32> = neighbours.collect();
        let next = between.iter().filter(|instants| **instants == 0).count();
        match next * 10 >= between.len() * 9 {
            true => between.iter().map(|instants| *instants as usize).sum(),
            false => 0,
        }
    }

    /// Stretches without a gap of over ten sample intervals, in order; together they are all samples.
    pub fn stretches(&self) -> Vec<Range<usize>> {
        let Some(interval_s) = self.sample_interval_s() else {
            return if self.is_empty() {
                Vec::new()
            } else {
                std::iter::once(0..self.length).collect()
            };
        };
        let times = self.t_s();
        let mut stretches = Vec::new();
        let mut start = 0;
        for index in 1..self.length {
            if times[index] - times[index - 1] > GAP_INTERVALS * interval_s {
                stretches.push(start..index);
                start = index;
            }
        }
        stretches.push(start..self.length);
        stretches
    }
}

/// Sampling instants between two times that lie so many intervals apart; the times' own are not among them.
pub fn instants_between(from_s: f64, to_s: f64, interval_s: f64) -> u32 {
    (((to_s - from_s) / interval_s).round() as u32).saturating_sub(1)
}

/// Equal if every row is, bit for bit.
impl PartialEq for Samples {
    fn eq(&self, other: &Self) -> bool {
        self.length == other.length
            && (0..self.length).all(|index| self.row(index) == other.row(index))
            && self.logged.len() == other.logged.len()
            && self.logged.iter().zip(&other.logged).all(|(one, other)| {
                let bits = |logged: &Logged| logged.values.iter().map(|v| v.to_bits()).collect();
                let (a, b): (Vec<u64>, Vec<u64>) = (bits(one), bits(other));
                one.name == other.name && a == b
            })
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn at(times: &[f64]) -> Samples {
        let mut samples = Samples::default();
        for &t_s in times {
            samples.push(&Row {
                t_s,
                ..Row::default()
            });
        }
        samples
    }

    #[test]
    fn instants_without_a_row_are_counted_where_times_are_regular() {
        let regular: Vec<f64> = (0..100).map(|k| f64::from(k) * 5.0e-5).collect();
        assert_eq!(at(&regular).missed_instants(), 0);
        let with_gaps: Vec<f64> = (0..100)
            .filter(|k| !(20..23).contains(k) && *k != 50)
            .map(|k| f64::from(k) * 5.0e-5)
            .collect();
        assert_eq!(at(&with_gaps).missed_instants(), 4);
        // Poses that were visited one by one.
        let poses: Vec<f64> = (0..100).map(|k| f64::from(k * k)).collect();
        assert_eq!(at(&poses).missed_instants(), 0);
        assert_eq!(at(&[1.0]).missed_instants(), 0);
    }

    #[test]
    fn a_gap_of_over_ten_intervals_starts_a_stretch() {
        let samples = at(&[0.0, 1.0, 2.0, 3.0, 13.0, 14.0, 24.5, 25.5]);
        assert_eq!(samples.sample_interval_s(), Some(1.0));
        assert_eq!(samples.stretches(), [0..6, 6..8]);
        assert!(at(&[]).stretches().is_empty());
        assert_eq!(at(&[5.0]).stretches().len(), 1);
    }

    #[test]
    fn unmeasured_fields_stay_apart_from_values() {
        let mut samples = Samples::default();
        samples.push(&Row {
            t_s: 0.0,
            run: "a",
            ..Row::default()
        });
        samples.push(&Row {
            t_s: 1.0,
            run: "b",
            temperature_c: Some(20.0),
            ..Row::default()
        });
        samples.push(&Row {
            t_s: 2.0,
            run: "a",
            ..Row::default()
        });
        assert_eq!(samples.get(Column::Temperature, 0), None);
        assert_eq!(samples.get(Column::Temperature, 1), Some(20.0));
        assert_eq!(samples.column(Column::Temperature).len(), 3);
        assert!(!samples.has(Column::Reference(0)));
        assert_eq!((samples.run(2), samples.run_number(2)), ("a", 0));
    }
}
