//! Sampling instants without a sample: the tooth count holds over as many as it can, and says so where it cannot.

use super::{PITCH_M, at, calibrated, raw};
use courier_sensor::frame::{Frame, RawFrame, SEGMENTS, Status};
use courier_sensor::settings::{Limits, Settings};
use courier_sensor::step::{StepConfig, StepState, step};

const SLIPS: Status = Status::SLIP_1
    .union(Status::SLIP_2)
    .union(Status::SLIP_3)
    .union(Status::SLIP_4);
const RATE_HZ: f64 = 20_000.0;

/// Counts that stand still are no fault here.
fn noiseless() -> Settings {
    let mut settings = calibrated();
    settings.limits.frozen_samples = 0;
    settings
}

/// A courier along x at one speed: its place and its frames are those of the instant, whether it was sampled or not.
struct Courier {
    config: StepConfig,
    state: StepState,
    turns_per_instant: f64,
    instant: u32,
}

impl Courier {
    /// Under way for long enough that the filtered speed is the speed: 400 instants are 25 time constants.
    fn at(speed_m_s: f64) -> Self {
        let mut courier = Self {
            config: StepConfig::build(&noiseless()).unwrap(),
            state: StepState::new(),
            turns_per_instant: speed_m_s / RATE_HZ / PITCH_M,
            instant: u32::MAX,
        };
        (0..400).for_each(|_| _ = courier.sample(0, Status::empty()));
        courier
    }

    /// The sample after so many missed instants, as the sampler makes it.
    fn sample(&mut self, missed: u32, fault: Status) -> Frame {
        self.instant = self.instant.wrapping_add(missed).wrapping_add(1);
        let x = f64::from(self.instant) * self.turns_per_instant;
        let mut now = RawFrame {
            fault,
            ..raw(at(x, 0.0, 0.0))
        };
        now.fault.set(Status::OVERRUN, missed > 0);
        self.state.skip(missed);
        step(&self.config, &mut self.state, &now)
    }

    /// Whole and parts of a turn that a frame's x is off from the courier's.
    fn off_turns(&self, frame: &Frame) -> f64 {
        let x = f64::from(self.instant) * self.turns_per_instant;
        frame.pose.x.metres(PITCH_M as f32) / PITCH_M - x
    }
}

#[test]
fn the_number_of_a_frame_is_its_instants() {
    let mut courier = Courier::at(0.0);
    for missed in [0, 1, 0, 32, 33, 0, 1_000_000, 0] {
        let frame = courier.sample(missed, Status::empty());
        assert_eq!(frame.sequence, courier.instant);
    }
}

#[test]
fn teeth_are_counted_over_missed_instants() {
    for speed_m_s in [0.0, 0.1, 0.5, -1.0, 1.5] {
        for missed in [1, 2, 7, 31, 32] {
            let mut courier = Courier::at(speed_m_s);
            let frame = courier.sample(missed, Status::empty());
            assert_eq!(frame.status, Status::OVERRUN, "{speed_m_s} m/s, {missed}");
            let off = courier.off_turns(&frame);
            assert!(off.abs() < 1e-3, "{speed_m_s} m/s, {missed}: {off}");
            let next = courier.sample(0, Status::empty());
            assert_eq!(next.status, Status::empty(), "an overrun is of one frame");
        }
    }
}

#[test]
fn too_many_missed_instants_are_a_slip_whatever_the_phases_say() {
    let most = u32::from(Limits::default().gap_samples);
    // A halt of 10 ms, one of minutes, and the shortest that is too long; the courier stands, so that no phase tells.
    for missed in [most + 1, 200, 5_000_000, u32::MAX - 1000] {
        let mut courier = Courier::at(0.0);
        let frame = courier.sample(missed, Status::empty());
        assert_eq!(frame.status, SLIPS | Status::OVERRUN, "{missed}");
        for _ in 0..100 {
            let later = courier.sample(0, Status::empty());
            assert_eq!(later.status, SLIPS | Status::OVERRUN, "both stay");
        }
        courier.state.clear_slips();
        assert_eq!(courier.sample(0, Status::empty()).status, Status::empty());
        assert_eq!(courier.sample(1, Status::empty()).status, Status::OVERRUN);
        let later = courier.sample(0, Status::empty());
        assert_eq!(later.status, Status::empty(), "latched no longer");
    }
}

#[test]
fn an_acceleration_over_the_longest_bridge_costs_no_tooth() {
    // 100 m/s², twenty times what a courier does; the filtered speed lags behind by then.
    let place = |instant: u32| 0.5 * 100.0 * (f64::from(instant) / RATE_HZ).powi(2) / PITCH_M;
    for missed in 0..=u32::from(Limits::default().gap_samples) {
        let config = StepConfig::build(&calibrated()).unwrap();
        let mut state = StepState::new();
        let mut frame = Frame::default();
        for instant in 0..400 {
            frame = step(&config, &mut state, &raw(at(place(instant), 0.0, 0.0)));
        }
        assert_eq!(frame.status, Status::empty());
        state.skip(missed);
        let x = place(400 + missed);
        frame = step(&config, &mut state, &raw(at(x, 0.0, 0.0)));
        let off = frame.pose.x.metres(PITCH_M as f32) / PITCH_M - x;
        assert!(off.abs() < 1e-3, "{missed}: {off}");
    }
}

#[test]
fn failed_conversions_and_missed_instants_add_up() {
    // BUSY is silent: the interrupt is called by hand at every fourth instant, without counts.
    let silent = Status::CONVERTER_TIMEOUT;
    let mut courier = Courier::at(0.5);
    for call in 1..=8 {
        let frame = courier.sample(3, silent);
        assert_eq!(frame.status, silent | Status::OVERRUN, "call {call}");
    }
    // 32 instants later BUSY is back, and no tooth is lost: at 0.5 m/s they are 0.79 of one.
    let mut back = courier.state.clone();
    std::mem::swap(&mut back, &mut courier.state);
    let frame = courier.sample(0, Status::empty());
    assert_eq!(frame.status, Status::empty());
    assert!(courier.off_turns(&frame).abs() < 1e-3);
    // It is not back: the ninth call is the 36th instant.
    courier.instant -= 1;
    courier.state = back;
    let frame = courier.sample(3, silent);
    assert_eq!(frame.status, silent | Status::OVERRUN | SLIPS);
    let frame = courier.sample(0, Status::empty());
    assert_eq!(frame.status, Status::OVERRUN | SLIPS);
    assert_eq!(frame.segments.len(), SEGMENTS);
}

#[test]
fn instants_missed_before_the_first_sample_are_no_slip() {
    let config = StepConfig::build(&calibrated()).unwrap();
    let mut state = StepState::new();
    state.skip(1000);
    let frame = step(&config, &mut state, &raw([0.1; SEGMENTS]));
    assert_eq!((frame.status, frame.sequence), (Status::empty(), 1000));
}
