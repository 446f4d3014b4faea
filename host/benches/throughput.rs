//! Host throughput of the signal path and of the estimator, beside nalgebra's QR of the same problem.
//!
//! `cargo xtask bench` runs it. The figures that count are the Cortex-M4F's, in the table after this one; these show what
//! replay, simulation and diagnosis have to spend.

use courier_sensor::frame::{Frame, RawFrame};
use courier_sensor::lsq::{Estimator, packed_len};
use courier_sensor::model::{Basis, ErrorModel, Observation, TermTable};
use courier_sensor::settings::Settings;
use courier_sensor::step::{StepConfig, StepState, step};
use divan::Bencher;
use divan::counter::ItemsCount;
use nalgebra::{DMatrix, DVector};
use std::f64::consts::TAU;

fn main() {
    divan::main();
}

/// Unknowns of equation (3) with merged offsets: 1 + 4 * 8.
const UNKNOWNS: usize = 33;
/// Poses of the paper's calibration.
const POSES: usize = 1000;
/// Samples of motion.
const SAMPLES: usize = 20_000;

/// A second at 20 kHz and 50 mm/s, both axes.
fn frames() -> Vec<RawFrame> {
    let pair = |turns: f64| {
        let (sine, cosine) = (TAU * turns).sin_cos();
        [(25_000.0 * sine) as i16, (25_000.0 * cosine) as i16]
    };
    (0..SAMPLES)
        .map(|index| {
            let turns = index as f64 * 2.46e-3;
            RawFrame {
                quadrature_counts: [
                    pair(turns),
                    pair(0.7 * turns),
                    pair(turns + 0.04),
                    pair(0.7 * turns - 0.02),
                ],
                electrode_counts: [9000, 11_000, 10_500, 9500],
                ..RawFrame::default()
            }
        })
        .collect()
}

fn config(terms: TermTable) -> StepConfig {
    let mut model = ErrorModel::zero(terms);
    let coefficients = [
        2.0e-6, -1.0e-6, 3.0e-6, 1.5e-6, -0.5e-6, 0.8e-6, 0.2e-6, -0.1e-6, 1.0e-6, 1.0e-6,
    ];
    for segment in 0..4 {
        model.set_columns(segment, &coefficients);
    }
    StepConfig::build(&Settings {
        model: Some(model),
        ..Settings::default()
    })
    .expect("coefficients of micrometres")
}

#[divan::bench(args = ["equation (3)", "equation (9)"])]
fn step_one_second(bencher: Bencher, terms: &str) {
    let config = config(if terms == "equation (3)" {
        TermTable::equation_3()
    } else {
        TermTable::equation_9()
    });
    let frames = frames();
    bencher.counter(ItemsCount::new(SAMPLES)).bench_local(|| {
        let mut state = StepState::new();
        frames.iter().fold(Frame::default(), |_, raw| {
            step(&config, &mut state, divan::black_box(raw))
        })
    });
}

/// Rows of g_p over scattered poses, from the firmware's own harmonics, and right-hand sides.
fn rows() -> Vec<([f32; UNKNOWNS], f32)> {
    let settings = Settings::default();
    let config = StepConfig::build(&settings).expect("defaults");
    let terms = TermTable::equation_3();
    let weyl = |index: usize, step: f64| (index as f64 * step).fract();
    (0..POSES)
        .map(|index| {
            let turns: [f64; 4] = std::array::from_fn(|segment| {
                weyl(index, [0.754_877, 0.569_840, 0.430_159, 0.293_893][segment])
            });
            let quadrature_counts = turns.map(|turns| {
                let (sine, cosine) = (TAU * turns).sin_cos();
                [(25_000.0 * sine) as i16, (25_000.0 * cosine) as i16]
            });
            let frame = step(
                &config,
                &mut StepState::new(),
                &RawFrame {
                    quadrature_counts,
                    ..RawFrame::default()
                },
            );
            let basis = Basis::new(&settings.geometry, &Observation::from(&frame));
            let mut row = [1.0_f32; UNKNOWNS];
            for (segment, columns) in row[1..].chunks_mut(8).enumerate() {
                basis.regressors(&terms, segment, columns);
            }
            (row, 1.0e-5 * weyl(index, 0.618_034) as f32)
        })
        .collect()
}

/// What the device does: a thousand rows, one at a time, then the solution with rank and covariance.
#[divan::bench]
fn givens_1000_rows_of_33_f32(bencher: Bencher) {
    let rows = rows();
    let mut estimator = Box::new(Estimator::<UNKNOWNS, { packed_len(UNKNOWNS) }>::new(
        UNKNOWNS,
    ));
    bencher.counter(ItemsCount::new(POSES)).bench_local(|| {
        estimator.reset(UNKNOWNS);
        for (row, rhs) in &rows {
            estimator
                .rows
                .enter(divan::black_box(row), *rhs)
                .expect("finite rows");
        }
        estimator.rows.residual_norm()
    });
}

#[divan::bench]
fn givens_solve_33_f32(bencher: Bencher) {
    let mut estimator = Box::new(Estimator::<UNKNOWNS, { packed_len(UNKNOWNS) }>::new(
        UNKNOWNS,
    ));
    for (row, rhs) in &rows() {
        estimator.rows.enter(row, *rhs).expect("finite rows");
    }
    bencher.bench_local(|| estimator.solve().map(|solution| solution.rank));
}

/// The same problem by nalgebra, all rows at once (Householder), in f32 and f64.
#[divan::bench(types = [f32, f64])]
fn nalgebra_qr_1000_rows_of_33<T: nalgebra::RealField + From<f32>>(bencher: Bencher) {
    let rows = rows();
    let matrix = DMatrix::<T>::from_row_iterator(
        POSES,
        UNKNOWNS,
        rows.iter().flat_map(|(row, _)| row.map(T::from)),
    );
    let rhs = DVector::<T>::from_iterator(POSES, rows.iter().map(|(_, rhs)| T::from(*rhs)));
    bencher.counter(ItemsCount::new(POSES)).bench_local(|| {
        let factor = divan::black_box(&matrix).clone().qr();
        let mut rhs = rhs.clone();
        factor.q_tr_mul(&mut rhs);
        factor
            .r()
            .solve_upper_triangular(&rhs.rows(0, UNKNOWNS).into_owned())
    });
}
