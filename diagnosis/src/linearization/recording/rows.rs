//! The residual channels of a sample, their derivatives by the readings, and their noise.

use super::LinearizedRecording;
use courier_signal::equations::{Angle, PARITY_SIGN, by_outputs, parity};
use effects::sensor::{Action, CHANNELS, Covariates, READINGS, Regressor};

/// Most rows that a sample gives: g_p, g_x, g_y, or four segments against a reference. A definition: three or four.
pub const ROWS: usize = 4;
/// What a column may act by, and the target: [`SampleRows::white_sources`].
pub const SOURCES: usize = READINGS + CHANNELS + 1;
/// The last of them.
pub const TARGET: usize = SOURCES - 1;

/// The residual channels of one sample and how to whiten them.
#[derive(Clone, Copy, Debug)]
pub struct SampleRows {
    /// Rows in use.
    pub count: usize,
    /// Channel of each row.
    pub channel: [usize; ROWS],
    /// Residual of each row, m.
    pub residual_m: [f64; ROWS],
    /// Derivative of each row by the readings.
    pub by_reading: [[f64; READINGS]; ROWS],
    /// Lower triangle that makes the stated noise white with unit variance.
    pub whiten: [[f64; ROWS]; ROWS],
}

impl SampleRows {
    /// Whitens a vector over the rows.
    pub fn whitened(&self, value: &[f64; ROWS]) -> [f64; ROWS] {
        let mut out = [0.0; ROWS];
        for row in 0..self.count {
            out[row] = (0..=row).map(|k| self.whiten[row][k] * value[k]).sum();
        }
        out
    }

    /// The vector over the rows that [`Self::whitened`] gives this for.
    pub fn coloured(&self, white: &[f64; ROWS]) -> [f64; ROWS] {
        let mut out = [0.0; ROWS];
        for row in 0..self.count {
            let known: f64 = (0..row).map(|k| self.whiten[row][k] * out[k]).sum();
            out[row] = (white[row] - known) / self.whiten[row][row];
        }
        out
    }

    /// Derivative of each whitened row by the readings.
    pub fn white_by_reading(&self) -> [[f64; READINGS]; ROWS] {
        let mut out = [[0.0; READINGS]; ROWS];
        for (row, out) in out.iter_mut().enumerate().take(self.count) {
            for k in 0..=row {
                for (sum, slope) in out.iter_mut().zip(&self.by_reading[k]) {
                    *sum += self.whiten[row][k] * slope;
                }
            }
        }
        out
    }

    /// [`Self::response`], whitened; none where a regressor adds nothing. `by_reading` is that of [`Self::white_by_reading`].
    pub fn white_response(
        &self,
        by_reading: &[[f64; READINGS]; ROWS],
        regressor: &Regressor,
        covariates: &Covariates,
    ) -> Option<[f64; ROWS]> {
        if !regressor.action.is_on_readings() {
            let response = self.response(regressor, covariates);
            let any = response.iter().any(|r| *r != 0.0);
            return any.then(|| self.whitened(&response));
        }
        if !regressor.acts(covariates) {
            return None;
        }
        let mut out = [0.0; ROWS];
        let mut add = |reading: usize, value: f64| {
            for (out, slope) in out.iter_mut().zip(by_reading) {
                *out += slope[reading] * value;
            }
        };
        if let Action::Reading(reading, value) = &regressor.action {
            add(*reading, value(covariates));
        } else {
            let readings = regressor.action.on_readings(covariates);
            let acting = readings.into_iter().enumerate().filter(|r| r.1 != 0.0);
            acting.for_each(|(reading, value)| add(reading, value));
        }
        out.iter().any(|o| *o != 0.0).then_some(out)
    }

    /// The vector over the whitened rows of each source that a column may act by: the readings, the channels, and the target (minus the
    /// residual) as the last one.
    pub fn white_sources(&self) -> [[f64; ROWS]; SOURCES] {
        let mut out = [[0.0; ROWS]; SOURCES];
        for (row, slopes) in self.white_by_reading().iter().enumerate() {
            for (out, slope) in out.iter_mut().zip(slopes) {
                out[row] = *slope;
            }
        }
        for row in 0..self.count {
            for below in row..self.count {
                out[READINGS + self.channel[row]][below] = self.whiten[below][row];
            }
        }
        out[TARGET] = self.whitened(&self.residual_m).map(|white| -white);
        out
    }

    /// What a unit amount of a regressor adds to the rows, m.
    pub fn response(&self, regressor: &Regressor, covariates: &Covariates) -> [f64; ROWS] {
        let mut out = [0.0; ROWS];
        if !regressor.acts(covariates) {
            return out;
        }
        let mut add = |reading: usize, value: f64| {
            for (out, slopes) in out.iter_mut().zip(&self.by_reading).take(self.count) {
                *out += slopes[reading] * value;
            }
        };
        match &regressor.action {
            Action::Reading(reading, value) => add(*reading, value(covariates)),
            Action::Readings(_) => {
                let readings = regressor.action.on_readings(covariates);
                let acting = readings.into_iter().enumerate().filter(|r| r.1 != 0.0);
                acting.for_each(|(reading, value)| add(reading, value));
            }
            Action::Channel(..) | Action::Channels(_) => {
                let channels = regressor.action.on_channels(covariates);
                for row in 0..self.count {
                    out[row] = channels[self.channel[row]];
                }
            }
        }
        out
    }
}

impl LinearizedRecording<'_> {
    /// Which of g_p, g_x and g_y a sample gives.
    pub fn channels(&self, i: usize) -> [bool; 3] {
        let whole = !self.scope.reference
            && (0..4).all(|s| self.calibrated_m[s].get(i).is_some_and(|p| p.is_finite()));
        let seen = whole && self.scope.beacon && self.observations.sees_beacon(i);
        [whole, seen, seen]
    }

    /// Rows of a sample; none where a reading is missing.
    pub fn rows(&self, i: usize) -> SampleRows {
        let mut rows = SampleRows {
            count: 0,
            channel: [0; ROWS],
            residual_m: [0.0; ROWS],
            by_reading: [[0.0; READINGS]; ROWS],
            whiten: [[0.0; ROWS]; ROWS],
        };
        if self.scope.reference {
            self.reference_rows(i, &mut rows);
        } else {
            self.constraint_rows(i, &mut rows);
        }
        if !self.aligned_in_time {
            self.take_back(i, &mut rows);
        }
        self.fill_whitener(i, &mut rows);
        rows
    }

    /// True if the rows are whitened by the stated noise, and not by one that was measured.
    pub fn is_by_stated_noise(&self) -> bool {
        self.noise == [1.0; READINGS]
    }

    /// Logarithm of the determinant of the whitening, over all rows in use: what the density of whitened residuals is multiplied with for
    /// that of the residuals themselves, m⁻¹ a row.
    pub fn log_whitening(&self) -> f64 {
        let in_use = (0..self.len()).filter(|i| self.mask[*i]);
        let of_sample = |i: usize| {
            let rows = self.rows(i);
            (0..rows.count).map(|k| rows.whiten[k][k].ln()).sum::<f64>()
        };
        in_use.map(of_sample).sum()
    }

    /// Takes the alignment of late segments back, to first order: that they are late is for an effect to explain.
    fn take_back(&self, i: usize, rows: &mut SampleRows) {
        for (segment, late) in self.observations.late.iter().enumerate() {
            let ahead_m = late.as_ref().map(|late| late.ahead_m[i]);
            if let Some(ahead_m) = ahead_m.filter(|m| m.is_finite()) {
                for row in 0..rows.count {
                    rows.residual_m[row] -= rows.by_reading[row][segment] * ahead_m;
                }
            }
        }
    }

    fn reference_rows(&self, i: usize, rows: &mut SampleRows) {
        for segment in (0..4).filter(|s| self.scope.segments[*s]) {
            let residual =
                self.calibrated_m[segment][i] - self.observations.reference_m(segment, i);
            if residual.is_finite() {
                rows.channel[rows.count] = 3 + segment;
                rows.residual_m[rows.count] = residual;
                rows.by_reading[rows.count][segment] = 1.0;
                rows.count += 1;
            }
        }
    }

    fn constraint_rows(&self, i: usize, rows: &mut SampleRows) {
        if !(0..4).all(|s| self.calibrated_m[s].get(i).is_some_and(|p| p.is_finite())) {
            return;
        }
        let p: [f64; 4] = std::array::from_fn(|s| self.calibrated_m[s][i]);
        rows.count = 1;
        rows.residual_m[0] = parity(&p) + self.baseline.parity_offset_m;
        rows.by_reading[0][..4].copy_from_slice(&PARITY_SIGN.map(f64::from));
        if !self.scope.beacon || !self.observations.sees_beacon(i) {
            return;
        }
        let theta = self.theta_rad(i);
        let tan = [0, 1].map(|axis| self.observations.tan_psi[axis][i]);
        let (g, by_theta) = self.baseline.beacon_residual(self.centre_m(i), theta, tan);
        let angle = Angle::of_rad(theta);
        let h = self.baseline.height_m;
        let by_tan = [angle.turn([h, 0.0]), angle.turn([0.0, h])];
        let by_outputs = by_outputs(by_theta, self.observations.span_m);
        for axis in 0..2 {
            let row = 1 + axis;
            rows.channel[row] = row;
            rows.residual_m[row] = g[axis];
            rows.by_reading[row][..4].copy_from_slice(&by_outputs[row]);
            rows.by_reading[row][4..].copy_from_slice(&by_tan.map(|by| by[axis]));
        }
        rows.count = 3;
    }

    /// Inverse Cholesky factor of the rows' covariance.
    fn fill_whitener(&self, i: usize, rows: &mut SampleRows) {
        let variance = self.reading_variance(i);
        let m = rows.count;
        let mut lower = [[0.0; ROWS]; ROWS];
        for a in 0..m {
            for b in 0..=a {
                let covariance: f64 = (0..READINGS)
                    .map(|r| rows.by_reading[a][r] * variance[r] * rows.by_reading[b][r])
                    .sum();
                let known: f64 = (0..b).map(|k| lower[a][k] * lower[b][k]).sum();
                let rest: f64 = covariance - known;
                lower[a][b] = if a == b {
                    rest.max(1e-24).sqrt()
                } else {
                    rest / lower[b][b]
                };
            }
        }
        for column in 0..m {
            for row in column..m {
                let unit = if row == column { 1.0 } else { 0.0 };
                let known: f64 = (column..row)
                    .map(|k| lower[row][k] * rows.whiten[k][column])
                    .sum();
                rows.whiten[row][column] = (unit - known) / lower[row][row];
            }
        }
    }

    /// Variance of the calibrated readings by the noise that the rows are whitened by.
    pub fn reading_variance(&self, i: usize) -> [f64; READINGS] {
        let stated = self.stated_variance(i);
        std::array::from_fn(|r| self.noise[r].powi(2) * stated[r])
    }

    /// The same by the stated noise.
    pub fn stated_variance(&self, i: usize) -> [f64; READINGS] {
        std::array::from_fn(|r| {
            if r < 4 {
                let noise = self.observations.position_noise_m[r].get(i);
                let gain = self.gain[r].get(i).copied().unwrap_or(1.0);
                (noise.copied().unwrap_or(0.0) * gain).powi(2)
            } else {
                let noise = self.observations.tan_psi_noise[r - 4].get(i);
                let noise = noise.copied().filter(|n| n.is_finite());
                noise.unwrap_or(0.0).powi(2)
            }
        })
    }
}
