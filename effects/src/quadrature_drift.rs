//! `quadrature_drift`: offset, gain or phase of a pair wander with time.

// --- plant side: from ideal to real signals ---

use crate::plant::{Instant, PlantEffect, SEGMENTS, Scene, Signal};
use crate::random::{ChaCha8Rng, normal, uniform};
use crate::shape::{Wander, segment_sizes};

/// One pair's wandering flaws, in units of the pair's size.
struct Pair {
    /// Offset of sine, offset of cosine, gain mismatch, angle.
    weights: [f64; 4],
    wanders: [Wander; 4],
}

/// Plant side. Size: rms over the phase and the recording's duration, pooled over the segments.
pub struct QuadratureDrift {
    pairs: [Pair; SEGMENTS],
    /// Each pair's rms phase error, radians.
    sizes_rad: [f64; SEGMENTS],
}

impl QuadratureDrift {
    /// Offsets, gain or angle in random shares: what an amplifier's bias, its gain or its filter drift by.
    pub fn draw(scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let pairs = core::array::from_fn(|_| {
            let shares = [uniform(rng, 0.2, 1.0), uniform(rng, 0.0, 1.0), uniform(rng, 0.0, 0.6)];
            let raw = [shares[0] * normal(rng), shares[0] * normal(rng), 2.0 * shares[1] * normal(rng), shares[2] * normal(rng)];
            // First order: offset o: o cos or o sin; gain g: (g/2) sin 2 phi; angle a: (a/2)(1 - cos 2 phi).
            let [sine, cosine, gain, angle] = raw.map(|w| w * w);
            let rms = (0.5 * (sine + cosine) + gain / 8.0 + angle * 1.5 / 4.0).sqrt().max(1.0e-9);
            let wanders = core::array::from_fn(|_| Wander::draw(rng, scene.duration_s));
            Pair { weights: raw.map(|w| w / rms), wanders }
        });
        Box::new(Self { pairs, sizes_rad: segment_sizes(rng, size_rms_m * scene.geometry.wavenumber()) })
    }
}

impl PlantEffect for QuadratureDrift {
    fn scale(&mut self, factor: f64) {
        self.sizes_rad = self.sizes_rad.map(|size| size * factor);
    }

    fn signal(&mut self, at: &Instant, signals: &mut [Signal; SEGMENTS]) {
        for ((signal, pair), size) in signals.iter_mut().zip(&self.pairs).zip(self.sizes_rad) {
            let flaw = |i: usize| size * pair.weights[i] * pair.wanders[i].at(at.time_s);
            let (sine_offset, cosine_offset, gain, angle) = (flaw(0), flaw(1), flaw(2), flaw(3));
            signal.sine = (1.0 + 0.5 * gain) * (signal.sine * angle.cos() + signal.cosine * angle.sin()) + sine_offset;
            signal.cosine = (1.0 - 0.5 * gain) * signal.cosine + cosine_offset;
        }
    }
}

// --- sensor side: orders one and two of the own phase that wander with time, as the amplitude does ---

/// What a sensor can know of it: shares nothing with the plant side above.
pub mod sensor_side {
    pub use crate::basis::spline;
    use crate::sensor::{Covariates, Regressor, BasisInputs};
    use core::f64::consts::TAU;

    /// Knots over the recording: two a period of what changes within a tenth of it. Derived from the sampling theorem: twenty
    /// intervals, and three knots beyond the ends for the cubic spline.
    const KNOTS: usize = 23;
    /// Their distance, as a part of the recording. Derived from the knots, of which three lie beyond the ends.
    const STEP: f64 = 1.0 / (KNOTS - 3) as f64;

    /// Sensor side: offset (order 1), gain and phase (order 2 and a constant). Their course in time is what the amplitude shows
    /// of them; where only positions are known, any cubic spline.
    pub fn regressors(inputs: &BasisInputs) -> Vec<Regressor> {
        let mut list = Vec::new();
        for s in (0..4).filter(|s| inputs.segments[*s]) {
            if inputs.counts {
                if inputs.pair_wanders[s] {
                    by_amplitude(&mut list, s, inputs.pitch_m / TAU);
                }
            } else if inputs.travel_m[s] > 3.0 * inputs.pitch_m {
                by_time(&mut list, s);
            }
        }
        list
    }

    /// The angle by which the pair's wandering flaws turn it, as its amplitude shows them: an amount of 1. And which of the two
    /// channels the quadrature angle is in: an amount from -1, all in the cosine, to 1.
    fn by_amplitude(list: &mut Vec<Regressor>, s: usize, metres: f64) {
        let mut add = |part: &str, value: fn(&Covariates, usize) -> f64| {
            let name = format!("{part}, segment {}", s + 1);
            let regressor = Regressor::reading(name, "1", 3.0e-6, s, move |m| -metres * value(m, s));
            list.push(regressor.of_deviation(1.0));
        };
        add("wander as the amplitude shows it", |m, s| m.pair_turn_rad[s]);
        add("its quadrature angle in the sine and not in the cosine", |m, s| m.half_quadrature_angle_rad[s]);
    }

    /// A part of a pair, its prior size in metres, and its shape over the tooth phase.
    type Part = (&'static str, f64, fn(&Covariates, usize) -> f64);

    /// Each has a course.
    const PARTS: [Part; 5] = [
        ("offset of sine", 3.0e-6, |m, s| m.raw[s][1].1),
        ("offset of cosine", 3.0e-6, |m, s| m.raw[s][1].0),
        ("gain", 3.0e-6, |m, s| m.raw[s][2].0),
        ("angle of sine", 3.0e-6, |m, s| 0.5 + 0.5 * m.raw[s][2].1),
        ("angle of cosine", 1.5e-6, |m, s| 0.5 - 0.5 * m.raw[s][2].1),
    ];

    /// Without amplitudes: the same shapes times any slow function of time.
    fn by_time(list: &mut Vec<Regressor>, s: usize) {
        for knot in 0..KNOTS {
            let place = (knot as f64 - 1.0) * STEP;
            let during = [place - 2.0 * STEP, place + 2.0 * STEP];
            for (part, (label, size_m, shape)) in PARTS.into_iter().enumerate() {
                let name = format!("at {:.0} % of the time, {label}, segment {}", 100.0 * place, s + 1);
                let hat = move |m: &Covariates| spline(m.progress / STEP - (knot as f64 - 1.0));
                let value = move |m: &Covariates| hat(m) * shape(m, s);
                let regressor = Regressor::reading(name, "m", size_m, s, value);
                let course = PARTS.len() * s + part;
                list.push(regressor.within(during).of_deviation(size_m).knot_of(course));
            }
        }
    }
}

// --- what is known of it ---

use crate::effect::{Acts, Card, Transfer, Confusable, Effect, Nature, Quantity, Recordings};
use crate::sensor::{Regressor, BasisInputs};

/// The effect.
pub struct Definition;

/// Its card.
pub static CARD: Card = Card {
    name: "quadrature_drift",
    summary: "offset, gain or phase of a pair wander with time",
    sizes: "3 µm for each part of a pair: offsets of 0.3 to 0.5 % of the amplitude are usual (ESS resolver) and 6 % has been seen (lib_sincos_enc); 1 % makes 1.6 µm",
    telling_motion: "the same fly-by repeated over an hour at a constant temperature",
    recordings: Recordings::NowAndLater,
    follows: Quantity::Time,
    coordinate: "time and own tooth phase",
    acts: Acts::Electronics,
    transfer: Transfer::ItsOwnTime,
    carries_over: "nothing but what the other recording's own counts show: its course is another one",
    nature: Nature::Flexible,
    its_own: "its course",
    remark: "its course is another one on each recording; the pair's own counts show it by their amplitude, here and on others. \
Without them, and on the board, the wander stays",
    confusable: &[
        Confusable { with: "thermal_drift", parted_by: "a temperature that only rises is a clock: the same poses at two temperatures and again at the first tell" },
    ],
    ..Card::PLAIN
};

impl Effect for Definition {
    fn card(&self) -> &'static Card {
        &CARD
    }

    fn draw(&self, scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        QuadratureDrift::draw(scene, rng, size_rms_m)
    }

    fn shapes(&self, inputs: &BasisInputs) -> Vec<Regressor> {
        sensor_side::regressors(inputs)
    }
}
