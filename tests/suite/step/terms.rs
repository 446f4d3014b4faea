//! The error model's terms against their definition in f64.

use super::{PITCH_M, at, raw, run};
use courier_sensor::frame::{Frame, RawFrame, SEGMENTS, Status};
use courier_sensor::geometry::Geometry;
use courier_sensor::model::{ErrorModel, Multiplier, Term, TermTable};
use courier_sensor::settings::Settings;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

/// Random coefficients of every row the table allows at once, against the definition in f64.
#[test]
fn every_term_is_its_definition() {
    let mut rng = ChaCha8Rng::seed_from_u64(3);
    let mut table = TermTable::equation_9();
    for term in [3, 5, 8, 12, 16].map(Term::own) {
        table.push(term).unwrap();
    }
    let crossed = Term {
        own_order: 1,
        lateral_order: -2,
        theta_power: 1,
        multiplier: Multiplier::None,
    };
    let more = [
        Term::lateral(2),
        Term::lateral(4).with_theta(1),
        Term::own(2).with_theta(3),
        Term::own(0).with_theta(2),
        Term::own(0).with(Multiplier::Speed),
        Term::own(1).with(Multiplier::Temperature),
        Term::own(0).with(Multiplier::Direction),
        Term {
            own_order: 2,
            lateral_order: 3,
            ..Term::default()
        },
        crossed,
    ];
    more.into_iter().for_each(|term| table.push(term).unwrap());
    let mut model = ErrorModel::zero(table.clone());
    model.constants_m = [1e-6, -2e-6, 3e-6, 0.5e-6];
    for (term, rows) in table.iter().zip(model.coefficients.iter_mut()) {
        let unit = match term.multiplier {
            Multiplier::Speed => 1e-5,
            Multiplier::Temperature => 1e-7,
            _ => 5e-6 * 30.0_f32.powi(i32::from(term.theta_power)),
        };
        rows.iter_mut()
            .flatten()
            .for_each(|k| *k = unit * rng.random_range(-1.0..1.0));
    }
    let settings = Settings {
        model: Some(model.clone()),
        ..Settings::default()
    };
    let mut x = 0.0;
    let raws: Vec<_> = (0..3000)
        .map(|k| {
            x += 0.06 * (f64::from(k) * 0.01).sin();
            let half = 0.12 * (f64::from(k) * 0.013).cos();
            RawFrame {
                temperature_delta_k: 0.01 * k as f32 - 10.0,
                ..raw(at(x, 0.3 - 0.6 * x, half))
            }
        })
        .collect();
    for frame in run(&settings, raws) {
        for i in 0..SEGMENTS {
            let segment = &frame.segments[i];
            let e = f64::from(segment.calibrated.fraction_turns)
                - f64::from(segment.unmodified.fraction_turns);
            let expected = exact_error_m(&model, &frame, i);
            assert!(
                (e * PITCH_M - expected).abs() < 0.5e-9,
                "{i}: {} {expected}",
                e * PITCH_M
            );
        }
        assert_eq!(frame.status, Status::empty());
    }
}

/// The definition in docs/design.md, in f64, from the frame's unmodified outputs.
fn exact_error_m(model: &ErrorModel, frame: &Frame, i: usize) -> f64 {
    let g = Geometry::PAPER;
    let p = frame
        .segments
        .map(|s| f64::from(s.unmodified.teeth) + f64::from(s.unmodified.fraction_turns));
    let theta = 0.5 * (p[0] - p[2] + p[1] - p[3]) * PITCH_M / f64::from(g.span_m);
    let (x, y) = (0.5 * (p[0] + p[2]), 0.5 * (p[1] + p[3]));
    let shift = f64::from(g.lateral_m) * theta / PITCH_M;
    let lateral = [y - shift, x + shift, y + shift, x - shift][i];
    let mut sum = f64::from(model.constants_m[i]);
    for (term, rows) in model.terms.iter().zip(&model.coefficients) {
        let angle =
            TAU * (f64::from(term.own_order) * p[i] + f64::from(term.lateral_order) * lateral);
        let factor = theta.powi(i32::from(term.theta_power))
            * f64::from(match term.multiplier {
                Multiplier::None => 1.0,
                Multiplier::Speed => frame.speed_m_s[i & 1],
                Multiplier::Temperature => frame.raw.temperature_delta_k,
                Multiplier::Direction => frame.direction[i & 1],
            });
        sum += factor * (f64::from(rows[i][0]) * angle.sin() + f64::from(rows[i][1]) * angle.cos());
    }
    sum
}
