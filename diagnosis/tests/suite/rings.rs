//! A ring of pole pairs before one sensor that reads one of them at a time: each pole is off by its own amount.

use crate::shared::{of_one_segment, shared};
use diagnosis::{Diagnosis, Options, Verdict, diagnose};
use recording::{Electronics, Recording, Row, Samples};
use specimens::rig::Dice;

/// Pole pairs of the ring.
const PAIRS: usize = 25;
/// A pole pair, as it is written, m.
const PITCH_M: f64 = 1.0e-3;
/// Amplitude of a channel, counts.
const AMPLITUDE: f64 = 3600.0;
/// Noise of a channel, counts rms.
const NOISE: f64 = 12.0;
/// Samples of a turn.
const OF_TURN: usize = 1300;

/// A ring: where each of its poles stands, and how strong it is.
pub struct Ring {
    poles: Vec<(f64, f64)>,
}

impl Ring {
    /// Poles that are off by `off` of a pole pair and stronger or weaker by `stronger`, both rms.
    pub fn draw(seed: u64, off: f64, stronger: f64) -> Self {
        let mut dice = Dice(seed);
        let one = |k: usize| {
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            let place = 0.5 * k as f64 + off * dice.normal();
            (place, sign * (1.0 + stronger * dice.normal()))
        };
        Self {
            poles: (0..2 * PAIRS).map(one).collect(),
        }
    }

    /// Field over a place, in pole pairs: each pole's falls off with the distance, as that of a charge half a pole below does.
    fn field(&self, at: f64) -> f64 {
        let turn = PAIRS as f64;
        let of_pole = |(place, strength): &(f64, f64)| {
            let away = (at - place + 0.5 * turn).rem_euclid(turn) - 0.5 * turn;
            strength * (1.0 + (away / 0.25).powi(2)).powf(-1.5)
        };
        self.poles.iter().map(of_pole).sum()
    }
}

/// A recording of so many turns beside a reference that goes on, or begins anew with each turn.
pub fn recorded(ring: &Ring, seed: u64, turns: f64, wrapped: bool) -> Recording {
    let mut dice = Dice(seed);
    let mut samples = Samples::default();
    let peak = (0..1000)
        .map(|k| ring.field(0.025 * f64::from(k)).abs())
        .fold(0.0, f64::max);
    let mut before = None;
    let mut teeth = 0;
    for k in 0..(turns * OF_TURN as f64) as usize {
        let place = 0.31 + (k as f64 + 0.5) * PAIRS as f64 / OF_TURN as f64;
        let counts = [place, place + 0.25]
            .map(|at| (AMPLITUDE * ring.field(at) / peak + NOISE * dice.normal()).round());
        let [cosine, minus_sine] = counts;
        let phase = (-minus_sine).atan2(cosine) / std::f64::consts::TAU;
        teeth += before.map_or(0, |before: f64| (before - phase).round() as i32);
        before = Some(phase);
        let turn = if wrapped {
            (place / PAIRS as f64).floor()
        } else {
            0.0
        };
        samples.push(&Row {
            t_s: k as f64 * 1.0e-3 + turn,
            run: &format!("turn_{}", place as usize / PAIRS),
            quadrature_counts: [Some([-minus_sine, cosine]), None, None, None],
            teeth: [Some(teeth - (turn * PAIRS as f64) as i32), None, None, None],
            reference: [Some(PITCH_M * (place - turn * PAIRS as f64)), None, None],
            ..Row::default()
        });
    }
    let electronics = Electronics {
        adc_bits: Some(16),
        amplitude_counts: Some(AMPLITUDE),
        quadrature_noise_counts: Some(NOISE),
        ..Electronics::default()
    };
    of_one_segment(PITCH_M, electronics, samples)
}

fn of(recording: &Recording) -> Diagnosis {
    diagnose(recording, "ring", &Options::default())
}

fn names(answer: &Diagnosis) -> Vec<&str> {
    answer.effects.iter().map(|e| e.name.as_str()).collect()
}

/// Named, and what is left of the gap is a third or less.
pub fn named(answer: &Diagnosis) {
    assert_eq!(answer.verdict, Verdict::Named, "{:?}", answer.place);
    assert_eq!(names(answer), ["tooth_variation"]);
    let [before, after] = [
        answer.held_out.whitened_before,
        answer.held_out.whitened_after,
    ];
    assert!(before > 5.0 && after < before / 3.0, "{before} to {after}");
}

#[test]
fn poles_that_come_round_again_are_named() {
    let ring = Ring::draw(1, 0.01, 0.03);
    named(&of(&recorded(&ring, 1, 3.4, false)));
}

#[test]
fn poles_whose_place_begins_anew_with_each_turn_are_named() {
    let ring = Ring::draw(2, 0.01, 0.03);
    named(&of(&recorded(&ring, 2, 3.4, true)));
}

/// Each pole is passed once: nothing tells what is the poles', and what goes with the time.
#[test]
fn of_one_turn_no_pole_is_named() {
    let ring = Ring::draw(3, 0.01, 0.03);
    let answer = of(&recorded(&ring, 3, 0.95, false));
    assert!(
        !names(&answer).contains(&"tooth_variation"),
        "{:?}",
        names(&answer)
    );
}

/// The field of a pole is no sine, and has orders that equation (3) leaves out: these are the same of every pole.
#[test]
fn poles_that_are_alike_are_no_field() {
    let ring = Ring::draw(4, 0.0, 0.0);
    let answer = of(&recorded(&ring, 4, 3.4, false));
    assert!(
        !names(&answer).contains(&"tooth_variation"),
        "{:?}",
        names(&answer)
    );
    assert!(answer.held_out.whitened_after < 1.1, "{:?}", names(&answer));
}

/// What is asked of real rings, m rms held out.
const WANTED_M: f64 = 7.0e-6;

#[test]
fn real_rings_are_named() {
    for name in [
        "magnetic-ring-1",
        "magnetic-ring-1-wrapped",
        "magnetic-ring-2",
        "magnetic-ring-3",
        "magnetic-ring-3-wrapped",
    ] {
        let Some(recording) = shared(name) else {
            return;
        };
        let answer = of(&recording);
        let left = &answer.held_out.channels[0];
        println!(
            "{name}: {:?} {:?}, {:.2} -> {:.2} µm",
            answer.verdict,
            names(&answer),
            1e6 * left.before_rms_m,
            1e6 * left.after_rms_m
        );
        assert_eq!(answer.verdict, Verdict::Named, "{name}");
        assert!(names(&answer).contains(&"tooth_variation"), "{name}");
        assert!(left.after_rms_m <= WANTED_M, "{name}: {}", left.after_rms_m);
    }
}
