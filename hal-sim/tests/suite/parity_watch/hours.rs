//! Hours of service without any change: nothing is to be told.

use super::bench::AtWork;
use crate::watch::bench::Calibrated;
use crate::watch::service::Hum;
use courier_sensor::calibration::watch::Standing;
use effects::thermal_drift::ThermalDrift;
use hal_sim::presets;
use hal_sim::spec::CourierSpec;

/// A courier in a hall: 3 K either way as the day goes, beside its own warmth, platen and courier growing with it, and a hum; no mount that
/// follows the temperature, since what does is a change.
fn in_a_hall(mut spec: CourierSpec) -> CourierSpec {
    spec.temperature.swing_k = 3.0;
    spec.temperature.swing_period_s = 86_400.0;
    spec.effects.push(Box::new(ThermalDrift {
        offset_m_per_k: [0.0; 4],
        curvature_per_k: 0.0,
        growth_per_k: 11.5e-6,
    }));
    spec.effects.push(Box::new(Hum {
        amplitude_m: 0.5e-6,
    }));
    spec
}

/// False alarms in so many hours of a courier, whose work changes every half an hour.
fn false_alarms(mut work: AtWork, hours: u32) -> u32 {
    let (mut alarms, mut was_told) = (0, false);
    for half_hour in 1..=2 * hours {
        work.run(1800.0 * f64::from(half_hour), |watch| {
            alarms += u32::from(watch.has_told() && !was_told);
            was_told = watch.has_told();
            false
        });
        work.traffic.change_work();
    }
    let verdict = work.watch.verdict();
    println!("{hours} hours: {alarms} false alarms; {verdict:?}");
    assert!(alarms > 0 || verdict.standing == Standing::Healthy);
    alarms
}

fn in_all(hours_each: u32, couriers: core::ops::Range<u64>) -> u32 {
    let alarms = couriers.map(|seed| {
        let ideal = Calibrated::new(move || in_a_hall(presets::ideal(5 + seed)), 5);
        let paper = Calibrated::new(move || in_a_hall(presets::paper_on_platen(5 + seed)), 6);
        let of = |calibrated| AtWork::new(calibrated, vec![], 10 + seed);
        false_alarms(of(ideal), hours_each) + false_alarms(of(paper), hours_each)
    });
    alarms.sum()
}

#[test]
fn twenty_hours_of_work_raise_no_alarm() {
    assert_eq!(in_all(10, 0..1), 0);
}

#[test]
#[ignore = "nightly: 1,000 hours of service of ten couriers"]
fn a_thousand_hours_of_work_raise_one_alarm_at_most() {
    assert!(in_all(100, 0..5) <= 1);
}
