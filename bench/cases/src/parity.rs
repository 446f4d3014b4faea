//! Digests that must be equal on the host and on the emulated Cortex-M4F.

use crate::digest::Digest;
use crate::inputs::Inputs;
use crate::rows::Rows;
use crate::setups::Setup;
use crate::{PACKED, UNKNOWNS};
use courier_sensor::frame::RawFrame;
use courier_sensor::lsq::Estimator;
use courier_sensor::step::{StepState, step};

/// Inputs of one check; as many for each setup of the signal path.
pub const INPUTS: u32 = 120_000;
/// Equations of one check.
pub const ROWS: u32 = 20_000;
/// A solution is taken after so many equations, and the factor forgotten.
const ROWS_PER_SOLUTION: u32 = 500;

/// Digest of the signal path over one setup's part of [`INPUTS`] generated frames.
pub fn signal(setup: Setup) -> u64 {
    let mut inputs = Inputs::new(setup as u64 + 1);
    let (config, mut state, mut digest) = (setup.config(), StepState::new(), Digest::default());
    for _ in 0..INPUTS / Setup::ALL.len() as u32 {
        let raw = inputs.frame();
        state.skip(inputs.missed());
        digest.frame(&step(&config, &mut state, &raw));
    }
    digest.value()
}

/// Digest of the signal path over given frames.
pub fn frames(setup: Setup, frames: impl Iterator<Item = RawFrame>) -> u64 {
    let (config, mut state, mut digest) = (setup.config(), StepState::new(), Digest::default());
    for raw in frames {
        digest.frame(&step(&config, &mut state, &raw));
    }
    digest.value()
}

/// Digest of factor, solution and covariance over [`ROWS`] equations, into an estimator of the caller's (it is large).
pub fn rows(estimator: &mut Estimator<UNKNOWNS, PACKED>) -> u64 {
    let (mut rows, mut digest) = (Rows::new(7, true), Digest::default());
    for n in 1..=ROWS {
        let row = rows.row();
        let entered = estimator.rows.enter(&row.entries, row.rhs);
        digest.float(entered.unwrap_or(f32::NAN));
        if n % ROWS_PER_SOLUTION == 0 {
            solution(estimator, &mut digest);
            estimator.reset(UNKNOWNS);
        }
    }
    digest.value()
}

fn solution(estimator: &mut Estimator<UNKNOWNS, PACKED>, digest: &mut Digest) {
    digest.word(u32::from(estimator.solve().is_ok()));
    let solution = estimator.solution();
    digest.floats(&solution.values);
    digest.floats(&solution.deviations);
    digest.floats(&[
        solution.condition,
        solution.condition_equilibrated,
        solution.noise,
    ]);
    digest.word(solution.rank as u32);
    for i in 0..UNKNOWNS {
        digest.float(estimator.covariance(i, UNKNOWNS - 1 - i));
    }
}
