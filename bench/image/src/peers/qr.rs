//! nalgebra's QR of a whole batch, per row; ours enters rows one by one.

use crate::counter::{Statistics, measure};
use cases::UNKNOWNS;
use cases::rows::Rows;
use core::hint::black_box;
use nalgebra::SMatrix;

/// Rows of the batch: twice the unknowns.
const ROWS: usize = 2 * UNKNOWNS;
/// As long as a batch takes, in rows of it.
pub fn run() {
    let mut rows = Rows::new(3, false);
    let mut batch = SMatrix::<f32, ROWS, UNKNOWNS>::zeros();
    for mut line in batch.row_iter_mut() {
        line.copy_from_slice(&rows.row().entries);
    }
    let mut statistics = Statistics::default();
    let (taken, factored) = measure(|| black_box(&batch).clone_owned().qr());
    black_box(factored);
    statistics.add(taken);
    statistics.print("nalgebra_qr_66x33");
}
