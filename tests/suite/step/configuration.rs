//! What a configuration is built from, and what is refused by name.

use super::{at, raw};
use courier_sensor::model::{ErrorModel, TermTable};
use courier_sensor::range::OutOfRange;
use courier_sensor::settings::{ConfigError, Settings};
use courier_sensor::step::{StepConfig, StepState, isr_step, step};

#[test]
fn both_entries_give_the_same_bits() {
    let config = StepConfig::build(&Settings::default()).unwrap();
    let (mut a, mut b) = (StepState::new(), StepState::new());
    for k in 0..1000 {
        let raw = raw(at(0.07 * f64::from(k), 0.01, 0.1));
        *b.raw_mut() = raw;
        assert_eq!(step(&config, &mut a, &raw), *isr_step(&config, &mut b));
    }
}

#[test]
fn settings_that_cannot_work_are_refused_by_name() {
    let refuse = |change: &dyn Fn(&mut Settings)| {
        let mut settings = Settings::default();
        change(&mut settings);
        StepConfig::build(&settings).unwrap_err()
    };
    let named = |change: &dyn Fn(&mut Settings)| match refuse(change) {
        ConfigError::Range(OutOfRange { name, .. }) => name,
        other => panic!("{other:?}"),
    };
    assert_eq!(named(&|s| s.geometry.pitch_m = 1.016), "pitch_m");
    assert_eq!(named(&|s| s.geometry.span_m = f32::NAN), "span_m");
    assert_eq!(named(&|s| s.geometry.lever_m[1] = f32::INFINITY), "lever_m");
    assert_eq!(named(&|s| s.pairs[3].gain = 0.0), "gain");
    assert_eq!(named(&|s| s.rate_hz = 0.0), "rate_hz");
    assert_eq!(named(&|s| s.limits.slip_turns = 0.5), "slip_turns");
    assert_eq!(
        named(&|s| s.limits.beacon.sum_low_counts = 0),
        "beacon.sum_low_counts"
    );
    assert_eq!(
        refuse(&|s| s.limits.frozen_samples = 100),
        ConfigError::FrozenSamples(100)
    );
    let mut model = ErrorModel::zero(TermTable::equation_3());
    model.coefficients[2][1] = [4e-4, 2e-4];
    let error = refuse(&|s| s.model = Some(model.clone()));
    assert!(
        matches!(error, ConfigError::ModelSize { segment: 1, .. }),
        "{error:?}"
    );
    model.coefficients[2][1] = [f32::NAN, 0.0];
    let error = refuse(&|s| s.model = Some(model.clone()));
    assert_eq!(
        error.to_string(),
        "error model: segment 2: coefficient of term 2, found NaN, wanted -1000 to 1000"
    );
}
