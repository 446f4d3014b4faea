//! A candidate of the recalibration while working on the image: proposed, put in force, over a restart, and rolled back, all over the link.

use crate::rig::{Rig, marked};
use core::f64::consts::SQRT_2;
use courier_sensor::calibration::recalibration::{Order, State};
use courier_sensor::calibration::watch::Standing;
use courier_sensor::drivers::motion::Target;
use courier_sensor::event_log::entry::{Event, Read, decode};
use courier_sensor::link::message::{Action, BoardStatus, InForce, Refusal, Reply, Source};
use effects::random::{ChaCha8Rng, SeedableRng, uniform};
use hal_sim::ageing::{Course, OwnWave};
use hal_sim::presets;
use hal_sim::waveform::Waveform;

const SEED: u64 = 34;
/// When segment 2's order 2 changes, seconds, and by how much, metres rms. The reference is known by then, and a window has agreed with it.
const CHANGE_S: f64 = 80.0;
const SIZE_M: f64 = 1.0e-6;
/// A candidate is there by then: some ten windows after the change.
const PROPOSED_S: u32 = CHANGE_S as u32 + 120;

/// A board whose courier's very waveforms are in force and stored.
fn calibrated() -> Rig {
    let mut spec = presets::ideal(SEED);
    let waveforms = spec.waveforms.clone();
    spec.effects.push(Box::new(OwnWave {
        segment: 1,
        order: 2.0,
        amounts_m: [SQRT_2 * SIZE_M, 0.0],
        course: Course::step(CHANGE_S),
    }));
    let mut rig = Rig::around(spec, SEED);
    let mut calibration = marked(1);
    for (segment, waveform) in waveforms.iter().enumerate() {
        let Waveform::Equation3(k) = waveform else {
            panic!("equation (3) alone")
        };
        for (rows, pair) in calibration
            .model
            .coefficients
            .iter_mut()
            .zip(k[1..].as_chunks::<2>().0)
        {
            rows[segment] = pair.map(|k_m| k_m as f32);
        }
    }
    // What the noise of a reading leaves in the parity, and a tenth of it of the corrections.
    let quality = &mut calibration.quality;
    (quality.residual_after_m, quality.predicted_worst_m) = (0.4e-6, 0.04e-6);
    assert_eq!(rig.ask(Action::take_over(calibration)), Reply::Done);
    let commit = Action::Commit {
        lose_unknown: false,
    };
    assert!(matches!(rig.ask(commit), Reply::Place(_)));
    rig
}

/// Sends the courier from place to place until `seen` says so of the status; fails at a time, seconds.
fn work(rig: &mut Rig, until_s: u32, seen: impl Fn(&BoardStatus) -> bool) -> BoardStatus {
    let mut rng = ChaCha8Rng::seed_from_u64(SEED);
    loop {
        let status = rig.status();
        if seen(&status) {
            return status;
        }
        assert!(status.time.uptime_s < until_s, "{status:?}");
        if !status.moving {
            let mut within = |half: f64| uniform(&mut rng, -half, half) as f32;
            let order = Action::GoTo {
                target: Target {
                    x_m: within(0.02),
                    y_m: within(0.02),
                    theta_rad: within(8.727e-3),
                },
                speed_m_per_s: 0.5,
            };
            assert_eq!(rig.ask(order), Reply::Done);
        }
        rig.run(50);
    }
}

/// Segment 2's order 2 in force, metres: sine.
fn wave_m(rig: &mut Rig) -> f32 {
    let Reply::Calibration(calibration) = rig.ask(Action::Read(Source::InForce)) else {
        panic!("wanted the calibration in force")
    };
    calibration.model.coefficients[1][1][0]
}

fn slot(rig: &mut Rig) -> u8 {
    match rig.status().in_force {
        InForce::Stored(place) => place.slot,
        other => panic!("{other:?}"),
    }
}

#[test]
#[ignore = "nightly: three minutes of an emulated board at work"]
fn a_candidate_is_proposed_put_in_force_and_rolled_back_over_the_link() {
    let mut rig = calibrated();
    let (before_m, slot_before) = (wave_m(&mut rig), slot(&mut rig));
    work(&mut rig, CHANGE_S as u32, |status| {
        status.watch.standing == Standing::Healthy
    });
    let refused = rig.link.ask(Action::Recalibrate(Order::Accept));
    let refused = refused.expect_err("no candidate").to_string();
    assert!(
        refused.contains(&Refusal::NoCandidate.to_string()),
        "{refused}"
    );
    let proposed = |status: &BoardStatus| matches!(status.recalibration.state, State::Proposed(_));
    let status = work(&mut rig, PROPOSED_S, proposed);
    let candidate = status
        .recalibration
        .state
        .proposed()
        .expect("seen a moment ago");
    println!("at {} s: {}", status.time.uptime_s, status.recalibration);
    assert_eq!((candidate.segment, candidate.order), (1, 2));
    assert_eq!(wave_m(&mut rig), before_m, "a proposal changes nothing");
    assert!(
        matches!(rig.ask(Action::Recalibrate(Order::Accept)), Reply::Place(place) if place.slot == 1 - slot_before)
    );
    rig.run(50);
    let amended_m = wave_m(&mut rig);
    // An amplitude of 1.41 µm, of which a part at least is sure.
    assert!(
        (0.5e-6..2.0e-6).contains(&(before_m - amended_m)),
        "{before_m:e} {amended_m:e}"
    );
    rig.run(500);
    let Reply::KeptLog(page) = rig.ask(Action::KeptLog { skip: 0 }) else {
        panic!("wanted the log")
    };
    let told = |wanted: &dyn Fn(&Event) -> bool| {
        page.entries()
            .any(|entry| matches!(decode(entry), Some(Read::Known(_, event)) if wanted(&event)))
    };
    assert!(told(
        &|event| matches!(event, Event::Proposed(of) if (of.segment, of.order) == (1, 2))
    ));
    assert!(told(
        &|event| matches!(event, Event::Recalibrated(InForce::Stored(place)) if place.slot == 1 - slot_before)
    ));
    // It is stored, and the one before is one rollback away.
    rig.link.restart().expect("the board restarts");
    assert_eq!(wave_m(&mut rig), amended_m);
    assert!(matches!(rig.ask(Action::RollBack), Reply::Place(place) if place.slot == slot_before));
    rig.run(50);
    assert_eq!(wave_m(&mut rig), before_m);
    rig.assert_none_missed();
}
