//! Equation (3) fitted twice to the same samples: row by row in f32 as on the device, and at once in f64.

use super::channel::Channel;
use super::observe::Sample;
use anyhow::{Result, anyhow, bail, ensure};
use courier_sensor::equations::{OWN_ORDERS, own_functions};
use courier_sensor::frame::SEGMENTS;
use courier_sensor::geometry::Geometry;
use courier_sensor::lsq::{Estimator, packed_len};
use courier_sensor::model::{Basis, TermTable};
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

/// Columns of one segment: orders 1, 2, 4 and 6.
const PER_SEGMENT: usize = 2 * OWN_ORDERS.len();
/// Unknowns with four segments: the merged offset and eight each.
pub const UNKNOWNS_MAX: usize = 1 + SEGMENTS * PER_SEGMENT;
/// Rows wanted for each unknown before a fit means anything. Derived from the degrees of freedom: with two the fit takes half of
/// the noise for its own, with fewer most of it.
const ROWS_PER_UNKNOWN: usize = 2;
/// Singular values below this share of the largest are not determined. Derived from 16 digits: seven of a direction as weak as
/// that are left.
const BATCH_RANK_TOLERANCE: f64 = 1.0e-9;

/// One equation `row * k = rhs`, in the firmware's f32.
struct Equation {
    row: [f32; UNKNOWNS_MAX],
    rhs_m: f32,
}

/// Where the phases of an f64 row come from.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Phase {
    /// The unmodified outputs, as equation (3) says.
    Output,
    /// The reference: what equation (3)'s orders could reach if the true position were known beforehand.
    Reference,
}

/// Builds the equations of one channel.
#[derive(Debug)]
pub struct Problem {
    channel: Channel,
    geometry: Geometry,
    pitch_m: f64,
    terms: TermTable,
}

/// Coefficients of equation (3): offset first, then eight of each segment that enters, metres.
#[derive(Clone, Debug)]
pub struct Fit {
    /// Values.
    pub coefficients_m: Vec<f64>,
    /// Largest over smallest singular value of the rows.
    pub condition_number: f64,
}

impl Problem {
    /// One channel of a recording of this geometry.
    pub fn new(channel: Channel, geometry: Geometry, pitch_m: f64) -> Self {
        Self {
            channel,
            geometry,
            pitch_m,
            terms: TermTable::equation_3(),
        }
    }

    /// Unknowns: the offset and eight of each segment that enters.
    pub fn unknowns(&self) -> usize {
        1 + PER_SEGMENT * self.segments().count()
    }

    fn segments(&self) -> impl Iterator<Item = (usize, f64)> {
        self.channel
            .signs()
            .into_iter()
            .enumerate()
            .filter(|(_, sign)| *sign != 0.0)
    }

    /// The firmware's row: its own harmonics of the phases that it measured.
    fn equation(&self, sample: &Sample) -> Equation {
        let basis = Basis::new(&self.geometry, &sample.observation);
        let mut row = [0.0; UNKNOWNS_MAX];
        row[0] = 1.0;
        for (place, (segment, sign)) in self.segments().enumerate() {
            let columns = &mut row[1 + place * PER_SEGMENT..1 + (place + 1) * PER_SEGMENT];
            basis.regressors(&self.terms, segment, columns);
            columns.iter_mut().for_each(|value| *value *= sign as f32);
        }
        Equation {
            row,
            rhs_m: -self.channel.raw_m(sample) as f32,
        }
    }

    /// The same row in f64, from the recording's own numbers.
    pub(super) fn row_f64(&self, sample: &Sample, phase: Phase) -> Vec<f64> {
        let mut row = vec![1.0];
        for (segment, sign) in self.segments() {
            let output_m = sample.unmodified_m[segment];
            let place_m = match phase {
                Phase::Output => output_m,
                Phase::Reference => sample.reference_m[segment].unwrap_or(output_m),
            };
            let phase_rad = TAU * place_m / self.pitch_m;
            let functions = own_functions(phase_rad.sin_cos().into());
            row.extend(functions.as_flattened().iter().map(|f| sign * f));
        }
        row
    }

    /// Row by row through the firmware's estimator.
    ///
    /// # Errors
    /// Too few rows, or rows that do not determine every unknown: the message has the limit and both numbers.
    pub fn incremental<'a>(
        &self,
        samples: impl ExactSizeIterator<Item = &'a Sample>,
    ) -> Result<Fit> {
        let unknowns = self.unknowns();
        self.enough(samples.len())?;
        let mut estimator =
            Box::new(Estimator::<UNKNOWNS_MAX, { packed_len(UNKNOWNS_MAX) }>::new(unknowns));
        for sample in samples {
            let Equation { row, rhs_m } = self.equation(sample);
            estimator
                .rows
                .enter(&row[..unknowns], rhs_m)
                .map_err(|error| anyhow!("{}: {error}", self.channel.name()))?;
        }
        let solution = estimator
            .solve()
            .map_err(|error| anyhow!("{}: {error}", self.channel.name()))?;
        ensure!(
            solution.rank == unknowns,
            "{}: the motion determines {} parameters, wanted {unknowns}: it has to cover the tooth phases of every segment",
            self.channel.name(),
            solution.rank
        );
        Ok(Fit {
            coefficients_m: solution.values[..unknowns]
                .iter()
                .map(|value| f64::from(*value))
                .collect(),
            condition_number: f64::from(solution.condition),
        })
    }

    /// All rows at once by a singular value decomposition in f64.
    ///
    /// # Errors
    /// Too few rows, or a decomposition that does not converge.
    pub fn batch<'a>(
        &self,
        samples: impl ExactSizeIterator<Item = &'a Sample>,
        phase: Phase,
    ) -> Result<Fit> {
        self.enough(samples.len())?;
        let unknowns = self.unknowns();
        let (mut rows, mut rhs_m) = (
            Vec::with_capacity(samples.len() * unknowns),
            Vec::with_capacity(samples.len()),
        );
        for sample in samples {
            rows.extend(self.row_f64(sample, phase));
            rhs_m.push(-self.channel.raw_m(sample));
        }
        // QR first: the decomposition is then of a small square matrix however many rows there are.
        let factor = DMatrix::from_row_iterator(rhs_m.len(), unknowns, rows).qr();
        let mut rhs_m = DVector::from_vec(rhs_m);
        factor.q_tr_mul(&mut rhs_m);
        let svd = factor.r().svd(true, true);
        let (largest, smallest) = (svd.singular_values.max(), svd.singular_values.min());
        match svd.solve(
            &rhs_m.rows(0, unknowns).into_owned(),
            BATCH_RANK_TOLERANCE * largest,
        ) {
            Ok(solution) => Ok(Fit {
                coefficients_m: solution.iter().copied().collect(),
                condition_number: largest / smallest,
            }),
            Err(why) => bail!("{}: batch solution: {why}", self.channel.name()),
        }
    }

    fn enough(&self, rows: usize) -> Result<()> {
        let wanted = ROWS_PER_UNKNOWN * self.unknowns();
        ensure!(
            rows >= wanted,
            "{}: found {rows} samples to fit that move, wanted {wanted} or more for {} parameters",
            self.channel.name(),
            self.unknowns()
        );
        Ok(())
    }

    /// What remains after the firmware's f32 model with these coefficients, metres.
    pub fn device_residual_m(&self, fit: &Fit, sample: &Sample) -> f64 {
        let equation = self.equation(sample);
        let correction_m = equation
            .row
            .iter()
            .zip(&fit.coefficients_m)
            .fold(0.0_f32, |sum, (column, coefficient)| {
                sum + column * *coefficient as f32
            });
        self.channel.raw_m(sample) + f64::from(correction_m)
    }

    /// What remains after the f64 model with these coefficients, metres.
    pub fn batch_residual_m(&self, fit: &Fit, sample: &Sample, phase: Phase) -> f64 {
        let correction_m: f64 = self
            .row_f64(sample, phase)
            .iter()
            .zip(&fit.coefficients_m)
            .map(|(a, b)| a * b)
            .sum();
        self.channel.raw_m(sample) + correction_m
    }

    /// Each segment's correction e at this sample by the fitted model, the offset aside, metres.
    pub fn corrections_m(&self, fit: &Fit, sample: &Sample) -> [f64; SEGMENTS] {
        let row = self.equation(sample).row;
        let mut corrections_m = [0.0; SEGMENTS];
        for (place, (segment, sign)) in self.segments().enumerate() {
            let columns = 1 + place * PER_SEGMENT..1 + (place + 1) * PER_SEGMENT;
            let products = row[columns.clone()]
                .iter()
                .zip(&fit.coefficients_m[columns]);
            corrections_m[segment] = products
                .map(|(column, value)| sign * f64::from(*column) * value)
                .sum();
        }
        corrections_m
    }
}
