//! What the check looks at: outputs of the segments, electrodes and poses in columns, and the groups of rows that share a zero.

use crate::quadrature::Reading;
use recording::{Column, Coordination, Recording};

/// At most so many rows are looked at; of more, every second, third and so on. A bound on the work: 4,000 rows tell an rms to 1.1
/// %.
const MOST_ROWS: usize = 4_000;
/// A row is an outlier beyond so many times the median size of the residual. Derived from the normal distribution: the median
/// size is 0.6745 of a deviation, so that it is four of them, by chance one row in 19,000.
const OUTLIER_RATIO: f64 = 6.0;
/// Outliers are at most one row in so many; more are no disturbances but the motion itself. A prior: bursts take 2 % of the time
/// at the most (`effects/src/outlier_bursts.rs`), and so half again.
const OUTLIERS_OF: usize = 20;
/// Light below this share of the brightest row's is that of no beacon.
const DARK_SHARE: f64 = 0.2;

/// Columns of a recording in SI, NaN where not measured.
#[derive(Clone, Debug)]
pub(crate) struct Readings {
    /// Stated tooth pitch, m.
    pub pitch_m: f64,
    /// Stated distance of a pair's segments, m.
    pub span_m: Option<f64>,
    /// Stated geometry of the coordination sensor.
    pub coordination: Option<Coordination>,
    /// True of segments whose output was logged as a position.
    pub logged: [bool; 4],
    /// Time, s.
    pub time_s: Vec<f64>,
    /// Unmodified outputs, m; empty for a segment that was not recorded.
    pub position_m: [Vec<f64>; 4],
    /// Electrodes x+, x-, y+, y-, counts; NaN without a beacon.
    pub electrodes: [Vec<f64>; 4],
    /// Commanded x, y (m) and theta (rad).
    pub commanded: [Vec<f64>; 3],
    /// Reference x, y (m) and theta (rad).
    pub reference: [Vec<f64>; 3],
    /// Number of the group of rows within which zeros do not change: a run, cut where a counter slips.
    pub group: Vec<usize>,
}

impl Readings {
    /// From a recording whose quadrature channels are read in the way of `reading`.
    pub fn new(recording: &Recording, reading: Reading) -> Self {
        let samples = &recording.samples;
        let stride = samples.len().div_ceil(MOST_ROWS).max(1);
        let rows: Vec<usize> = (0..samples.len()).step_by(stride).collect();
        let pitch_m = recording.meta.geometry.pitch_m;
        let take = |column: Column| -> Vec<f64> {
            match samples.column(column) {
                [] => Vec::new(),
                values => rows.iter().map(|&i| values[i]).collect(),
            }
        };
        let position_m = [0, 1, 2, 3].map(|segment| -> Vec<f64> {
            if !samples.has_segment(segment) {
                return Vec::new();
            }
            let value = |&i: &usize| reading.output_m(samples, segment, i, pitch_m);
            rows.iter().map(value).collect()
        });
        let logged = [0, 1, 2, 3].map(|s| samples.has_segment(s) && !samples.has(Column::Sine(s)));
        let mut readings = Self {
            pitch_m,
            span_m: recording.meta.geometry.span_m,
            coordination: recording.meta.coordination,
            logged,
            time_s: take(Column::Time),
            position_m,
            electrodes: [0, 1, 2, 3].map(|k| take(Column::Electrode(k))),
            commanded: [0, 1, 2].map(|k| take(Column::Commanded(k))),
            reference: [0, 1, 2].map(|k| take(Column::Reference(k))),
            group: rows.iter().map(|&i| samples.run_number(i)).collect(),
        };
        readings.darken();
        readings.group = readings.cut_at_slips();
        readings
    }

    /// Number of rows.
    pub fn len(&self) -> usize {
        self.time_s.len()
    }

    /// True if the segment was recorded.
    pub fn has(&self, segment: usize) -> bool {
        !self.position_m[segment].is_empty()
    }

    /// Rows with every one of these columns.
    pub fn rows_with(&self, columns: &[&Vec<f64>]) -> Vec<usize> {
        let whole = |i: &usize| columns.iter().all(|c| c.is_empty() || c[*i].is_finite());
        (0..self.len()).filter(whole).collect()
    }

    /// Sets the electrodes of rows without a beacon to NaN.
    fn darken(&mut self) {
        if self.electrodes.iter().any(Vec::is_empty) {
            self.electrodes = Default::default();
            return;
        }
        let light = |i: usize| self.electrodes.iter().map(|e| e[i]).sum::<f64>();
        let brightest = (0..self.len()).map(light).fold(0.0, f64::max);
        let dark: Vec<usize> = (0..self.len())
            .filter(|&i| !(light(i) > DARK_SHARE * brightest))
            .collect();
        for electrode in &mut self.electrodes {
            dark.iter().for_each(|&i| electrode[i] = f64::NAN);
        }
    }

    /// Takes out rows in which the parity of a wiring is far outside its own scatter: disturbances of some milliseconds.
    pub fn without_outliers(mut self, residual_m: &[(usize, f64)]) -> Self {
        let mut sizes: Vec<f64> = residual_m.iter().map(|r| r.1.abs()).collect();
        if sizes.is_empty() {
            return self;
        }
        let middle = sizes.len() / 2;
        let (_, median, _) = sizes.select_nth_unstable_by(middle, f64::total_cmp);
        let limit = OUTLIER_RATIO * *median;
        let far: Vec<usize> = residual_m
            .iter()
            .filter(|r| r.1.abs() > limit)
            .map(|r| r.0)
            .collect();
        if far.len() * OUTLIERS_OF < residual_m.len() {
            for position in self.position_m.iter_mut().filter(|p| !p.is_empty()) {
                far.iter().for_each(|&i| position[i] = f64::NAN);
            }
        }
        self
    }
}
