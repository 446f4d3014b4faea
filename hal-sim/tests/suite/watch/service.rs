//! Hours of service without any change of a segment: nothing is to be told.

use super::bench::{Calibrated, Service};
use super::traffic::Work;
use core::f64::consts::TAU;
use effects::plant::{Instant, PlantEffect, SEGMENTS, SegmentPoint};
use effects::thermal_drift::ThermalDrift;
use hal_sim::presets;
use hal_sim::spec::CourierSpec;

/// Two segments that hum by up to half a micrometre, and swell: what a machine beside them does.
pub struct Hum {
    pub amplitude_m: f64,
}

/// Where a robot's structure rings (Bendat and Piersol 2010 call 20 to 200 Hz usual), and a swelling of ten minutes.
const HUM_HZ: f64 = 37.0;
const SWELL_HZ: f64 = 1.0 / 600.0;

impl PlantEffect for Hum {
    fn scale(&mut self, factor: f64) {
        self.amplitude_m *= factor;
    }

    fn displacement_m(&mut self, at: &Instant, _: &[SegmentPoint; SEGMENTS]) -> [f64; SEGMENTS] {
        let wave = |hz: f64| (TAU * (hz * at.time_s).fract()).sin();
        let hum_m = self.amplitude_m * wave(HUM_HZ) * wave(SWELL_HZ);
        [0.0, hum_m, -0.3 * hum_m, 0.0]
    }
}

/// A courier in a hall: mounts that drift by micrometres as the day goes, 3 K either way beside its own warmth, and a hum.
fn in_a_hall(mut spec: CourierSpec) -> CourierSpec {
    spec.temperature.swing_k = 3.0;
    spec.temperature.swing_period_s = 86_400.0;
    spec.effects.push(Box::new(ThermalDrift {
        offset_m_per_k: [1.0e-6, -0.7e-6, 0.4e-6, 0.8e-6],
        curvature_per_k: 0.02,
        growth_per_k: 11.5e-6,
    }));
    spec.effects.push(Box::new(Hum {
        amplitude_m: 0.5e-6,
    }));
    spec
}

fn couriers() -> [Calibrated; 2] {
    [
        Calibrated::new(|| in_a_hall(presets::ideal(5)), 5),
        Calibrated::new(|| in_a_hall(presets::paper_on_platen(5)), 6),
    ]
}

/// False alarms in so many hours of a courier, whose work changes every half an hour, and the largest evidence for one.
fn false_alarms(service: &mut Service, hours: u32) -> (u32, f32) {
    let (mut alarms, mut was_told, mut most) = (0, false, 0.0_f32);
    for half_hour in 1..=2 * hours {
        service.run_watched(1800.0 * f64::from(half_hour), |watch| {
            alarms += u32::from(watch.has_told() && !was_told);
            was_told = watch.has_told();
            most = most.max(watch.evidence());
            false
        });
        service.traffic.change_work();
    }
    (alarms, most)
}

fn in_all(hours_each: u32) -> u32 {
    let mut all = 0;
    for (courier, seed) in couriers().iter().zip(1..) {
        let mut service = courier.serve(vec![], Work::ORDINARY, seed);
        let (alarms, most) = false_alarms(&mut service, hours_each);
        let windows = service.verdict().windows;
        println!(
            "{hours_each} hours, {windows} windows: {alarms} false alarms, evidence up to {most:.2} of one"
        );
        all += alarms;
    }
    all
}

#[test]
fn twenty_hours_of_traffic_warmth_and_vibrations_raise_no_alarm() {
    assert_eq!(in_all(10), 0);
}

#[test]
#[ignore = "nightly: 1,000 hours of service, five minutes of processor time"]
fn a_thousand_hours_of_traffic_warmth_and_vibrations_raise_one_alarm_at_most() {
    assert!(in_all(500) <= 1);
}

#[test]
fn a_watch_that_believes_too_little_raises_false_alarms() {
    // The same service, with windows that count at once and a test that tells at the first sign.
    let [_, courier] = couriers();
    let mut service = courier.serve(vec![], Work::ORDINARY, 2);
    service.configure(|config| {
        config.apart = 1.0;
        config.score = 1.0;
    });
    assert!(service.run_watched(3600.0, |watch| watch.has_told()));
}
