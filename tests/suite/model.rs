//! Error model: regressors against their definition in f64, and the model's own book-keeping.

use courier_sensor::frame::{Coordinate, SEGMENTS};
use courier_sensor::geometry::Geometry;
use courier_sensor::model::{
    Basis, ErrorModel, MAX_TERMS, Multiplier, Observation, Term, TermError, TermTable,
};
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

fn table_of_everything() -> TermTable {
    let mut table = TermTable::equation_9();
    for term in [
        Term::own(16),
        Term::lateral(2),
        Term::lateral(4).with_theta(1),
        Term {
            own_order: 3,
            lateral_order: -4,
            theta_power: 2,
            multiplier: Multiplier::None,
        },
        Term::own(0).with(Multiplier::Speed),
        Term::own(2).with(Multiplier::Temperature),
        Term::own(0).with_theta(1).with(Multiplier::Direction),
    ] {
        table.push(term).unwrap();
    }
    table
}

/// Random poses within ±1.5°, segments apart by up to a tenth of a pitch more than the angle says.
fn observation(rng: &mut ChaCha8Rng) -> Observation {
    let (x, y) = (rng.random_range(-20.0..20.0), rng.random_range(-20.0..20.0));
    let half = rng.random_range(-0.12..0.12);
    let p: [f64; 4] =
        [x + half, y + half, x - half, y - half].map(|p: f64| p + rng.random_range(-0.05..0.05));
    Observation {
        unmodified: p.map(|p| Coordinate {
            teeth: p.round() as i32,
            fraction_turns: (p - p.round()) as f32,
        }),
        speed_m_s: [0.5, -0.3, 0.49, -0.31],
        direction: [1.0, -1.0, 0.25, 0.0],
        temperature_delta_k: 3.5,
    }
}

/// `[sine, cosine]` of one term by docs/design.md in f64.
fn exact(term: &Term, seen: &Observation, i: usize) -> [f64; 2] {
    let g = Geometry::PAPER;
    let pitch = f64::from(g.pitch_m);
    let p = seen
        .unmodified
        .map(|c| f64::from(c.teeth) + f64::from(c.fraction_turns));
    let theta = 0.5 * (p[0] - p[2] + p[1] - p[3]) * pitch / f64::from(g.span_m);
    let shift = f64::from(g.lateral_m) * theta / pitch;
    let (x, y) = (0.5 * (p[0] + p[2]), 0.5 * (p[1] + p[3]));
    let lateral = [y - shift, x + shift, y + shift, x - shift][i];
    let angle = TAU * (f64::from(term.own_order) * p[i] + f64::from(term.lateral_order) * lateral);
    let factor = theta.powi(i32::from(term.theta_power))
        * f64::from(match term.multiplier {
            Multiplier::None => 1.0,
            Multiplier::Speed => seen.speed_m_s[i],
            Multiplier::Temperature => seen.temperature_delta_k,
            Multiplier::Direction => seen.direction[i],
        });
    [factor * angle.sin(), factor * angle.cos()]
}

/// Quoted in the documentation: 1e-5 relative to the multiplier, at order 16 (3e-6 at the orders of equations 3 and 9).
#[test]
fn regressors_are_their_definition() {
    let mut rng = ChaCha8Rng::seed_from_u64(11);
    let table = table_of_everything();
    let (mut worst, mut worst_low) = (0.0_f64, 0.0_f64);
    for _ in 0..5000 {
        let seen = observation(&mut rng);
        let basis = Basis::new(&Geometry::PAPER, &seen);
        for i in 0..SEGMENTS {
            let mut columns = [0.0; 48];
            assert_eq!(
                basis.regressors(&table, i, &mut columns),
                table.column_count()
            );
            for (column, value) in table.columns().zip(columns) {
                let term = table.iter().nth(column.term).unwrap();
                let error = (f64::from(value) - exact(term, &seen, i)[column.part as usize]).abs();
                worst = worst.max(error);
                if term.own_order <= 6 && term.multiplier == Multiplier::None {
                    worst_low = worst_low.max(error);
                }
            }
        }
    }
    assert!(worst < 1e-5 && worst_low < 3e-6, "{worst:e} {worst_low:e}");
}

#[test]
fn error_is_the_sum_of_coefficients_times_regressors() {
    let mut rng = ChaCha8Rng::seed_from_u64(5);
    let table = table_of_everything();
    let mut model = ErrorModel::zero(table.clone());
    model.constants_m = [1e-6; 4];
    let k: Vec<f32> = (0..table.column_count())
        .map(|_| rng.random_range(-1e-5..1e-5))
        .collect();
    model.set_columns(2, &k);
    let mut back = vec![0.0; k.len()];
    assert_eq!(model.read_columns(2, &mut back), k.len());
    assert_eq!(back, k);
    let basis = Basis::new(&Geometry::PAPER, &observation(&mut rng));
    let mut columns = vec![0.0; k.len()];
    basis.regressors(&table, 2, &mut columns);
    let sum: f32 = columns.iter().zip(&k).map(|(c, k)| c * k).sum();
    assert!((model.error_m(&basis, 2) - 1e-6 - sum).abs() < 1e-11);
    assert_eq!(model.error_m(&basis, 1), 1e-6);
}

#[test]
fn a_short_buffer_takes_what_fits() {
    let table = TermTable::equation_9();
    let basis = Basis::new(&Geometry::PAPER, &Observation::default());
    let mut three = [9.0; 3];
    assert_eq!(basis.regressors(&table, 0, &mut three), 3);
    assert_eq!(three, [0.0, 1.0, 0.0]);
}

#[test]
fn columns_follow_the_table() {
    assert_eq!(TermTable::equation_3().column_count(), 8);
    assert_eq!(TermTable::equation_9().column_count(), 10);
    let mut table = TermTable::default();
    table.push(Term::own(0).with_theta(1)).unwrap();
    assert_eq!(table.column_count(), 1);
    assert_eq!(table.columns().count(), 1);
}

#[test]
fn impossible_tables_are_refused_with_their_row() {
    let refuse = |term: Term| TermTable::new(&[Term::own(1), term]).unwrap_err();
    assert_eq!(refuse(Term::own(17)), (1, TermError::OwnOrder(17)));
    assert_eq!(refuse(Term::lateral(5)), (1, TermError::LateralOrder(5)));
    assert_eq!(refuse(Term::lateral(-1)), (1, TermError::Mirrored(-1)));
    assert_eq!(
        refuse(Term::own(2).with_theta(4)),
        (1, TermError::ThetaPower(4))
    );
    assert_eq!(refuse(Term::own(0)), (1, TermError::Constant));
    assert_eq!(refuse(Term::own(1)), (1, TermError::Duplicate(0)));
    let many: Vec<_> = (0..25)
        .map(|k| Term::own(k % 16).with_theta(k / 16 + 1))
        .collect();
    assert_eq!(
        TermTable::new(&many).unwrap_err(),
        (MAX_TERMS, TermError::TooMany)
    );
}

#[test]
fn a_model_survives_its_wire() {
    let mut model = ErrorModel::zero(table_of_everything());
    model.coefficients[3][2] = [1.5e-6, -2.5e-6];
    let mut buffer = [0; 1024];
    let bytes = postcard::to_slice(&model, &mut buffer).unwrap();
    assert_eq!(postcard::from_bytes::<ErrorModel>(bytes).unwrap(), model);
}
