//! No surprise for any input.

use super::raw;
use courier_sensor::frame::{Frame, RawFrame, Status};
use courier_sensor::model::{ErrorModel, Multiplier, Term, TermTable};
use courier_sensor::quadrature::PairCorrection;
use courier_sensor::settings::{Limits, Settings};
use courier_sensor::step::{StepConfig, StepState, step};
use proptest::prelude::*;

fn finite(frame: &Frame) -> bool {
    let pose = &frame.pose;
    let mut values = vec![
        pose.x.fraction_turns,
        pose.y.fraction_turns,
        pose.theta_x_rad,
        pose.theta_y_rad,
        pose.theta_rad,
        frame.parity_m,
        frame.tan_psi[0],
        frame.tan_psi[1],
        frame.raw.temperature_delta_k,
        frame.speed_m_s[0],
        frame.speed_m_s[1],
    ];
    for s in &frame.segments {
        let fractions = [s.unmodified.fraction_turns, s.calibrated.fraction_turns];
        values.extend(fractions.into_iter().chain([s.amplitude_counts]));
    }
    values.iter().all(|v| v.is_finite())
}

prop_compose! {
    fn any_raw()(quadrature_counts: [[i16; 2]; 4], electrode_counts: [i16; 4], temperature_delta_k: f32, fault: u32)
        -> RawFrame {
        let fault = Status::from_bits_truncate(fault & fault.rotate_left(7));
        RawFrame { quadrature_counts, electrode_counts, temperature_delta_k, fault }
    }
}

prop_compose! {
    fn any_term()(own_order in 0_u8..=16, lateral_order in -4_i8..=4, theta_power in 0_u8..=3, kind in 0_usize..4)
        -> Term {
        let kinds = [Multiplier::None, Multiplier::Speed, Multiplier::Temperature, Multiplier::Direction];
        Term { own_order, lateral_order, theta_power, multiplier: kinds[kind] }
    }
}

proptest! {
    #[test]
    fn no_input_gives_a_result_that_is_not_finite(
        raws in prop::collection::vec(any_raw(), 1..60),
        terms in prop::collection::vec(any_term(), 0..24),
        coefficients in prop::collection::vec(-1000.0_f32..1000.0, 192),
        gain in 0.1_f32..10.0,
        angle_rad in -1.0_f32..1.0,
        offset in -32768.0_f32..32768.0,
        scale in 0_i32..8,
    ) {
        let mut table = TermTable::default();
        for term in terms {
            let mut wider = table.clone();
            if wider.push(term).is_ok() && wider.validate().is_ok() {
                table = wider;
            }
        }
        let mut model = ErrorModel::zero(table);
        let slots = model.coefficients.iter_mut().flatten().flatten();
        slots.zip(coefficients).for_each(|(slot, k)| *slot = k * 10.0_f32.powi(-scale));
        let pair = PairCorrection { offset_counts: [offset, -offset], gain, angle_rad };
        let mut settings = Settings { model: Some(model), pairs: [pair; 4], ..Settings::default() };
        if StepConfig::build(&settings).is_err() {
            // Too large for the dense part: leave only what depends on more than phases.
            let model = settings.model.as_mut().unwrap();
            let terms: Vec<_> = model.terms.iter().copied().collect();
            for (term, rows) in terms.iter().zip(model.coefficients.iter_mut()) {
                if term.theta_power == 0 && term.multiplier == Multiplier::None {
                    *rows = Default::default();
                }
            }
        }
        let config = StepConfig::build(&settings).unwrap();
        let mut state = StepState::new();
        for raw in raws {
            let frame = step(&config, &mut state, &raw);
            prop_assert!(finite(&frame), "{frame:?}");
        }
    }
}

#[test]
fn counts_may_wrap() {
    let config = StepConfig::build(&Settings {
        limits: Limits::default(),
        ..Settings::default()
    })
    .unwrap();
    let mut state = StepState::new();
    step(&config, &mut state, &raw([0.4; 4]));
    state.set_teeth([i32::MAX, i32::MIN, i32::MIN, i32::MAX]);
    let frame = step(&config, &mut state, &raw([0.6; 4]));
    assert!(finite(&frame));
    assert_eq!(frame.segments[0].unmodified.teeth, i32::MIN);
}
