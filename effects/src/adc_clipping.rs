//! `adc_clipping`: a quadrature channel saturates: its tops are cut off, or flattened by an amplifier that gives way before its rail.

// --- plant side: limits at the converter ---

use crate::plant::{Channels, Instant, PlantEffect, SEGMENTS, Scene};
use crate::random::{ChaCha8Rng, index, log_uniform, uniform};
use core::f64::consts::TAU;

/// Plant side. Size: rms of the displacement over the phase, pooled over the segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdcClipping {
    /// Of each segment: how deep its rails cut below and above, sine then cosine, of [`Self::depth`]. Zero: that end is whole.
    pub cuts: [[[f64; 2]; 2]; SEGMENTS],
    /// Rms pooled over the segments, radians of their phases.
    rms_rad: f64,
    /// Deepest cut, share of the amplitude: how far the lowest rail lies below the wave's top. Negative where a rail that is soft lies
    /// above it.
    pub depth: f64,
    /// Width of the knee, share of the amplitude; zero: rails are hard.
    pub knee: f64,
}

/// Deepest cut that is drawn, share of the amplitude. A prior: the deepest cut that is known takes 0.345 off (a level of 0.655,
/// ESS resolver), and twice that is drawn.
const DEEPEST: f64 = 0.7;
/// Highest rail that is soft, share of the amplitude above the top. Derived from the softest knee that is drawn, 0.12: from so
/// far above the top a rail takes 0.00003 of the amplitude, so that no smaller error is asked for.
const HIGHEST: f64 = 1.0;
/// Widths of knees, share of the amplitude. A prior: clamping diodes conduct e times as much for each 26 to 52 mV (kT/q times an
/// ideality of 1 to 2), which is 0.05 to 0.1 of the amplitude of a signal of 1 V from peak to peak, and somewhat more of a
/// smaller one.
const KNEES: [f64; 2] = [0.03, 0.12];
/// Share of the draws with a knee.
const SOFT: f64 = 0.3;

impl AdcClipping {
    /// One segment, two, or all: gain was set too high for them, or an offset pushes the wave against one of its rails.
    pub fn draw(scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let (first, second) = (index(rng, SEGMENTS), index(rng, SEGMENTS));
        let all = uniform(rng, 0.0, 1.0) < 0.25;
        let hit = |s: usize| all || s == first || s == second;
        let alike = uniform(rng, 0.0, 1.0) < 0.5;
        let cuts = core::array::from_fn(|s| match (hit(s), alike) {
            (false, _) => [[0.0; 2]; 2],
            (true, true) => [[1.0; 2]; 2],
            (true, false) => shifted(rng),
        });
        let rms_rad = size_rms_m * scene.geometry.wavenumber();
        let knee = if uniform(rng, 0.0, 1.0) < SOFT { log_uniform(rng, KNEES[0], KNEES[1]) } else { 0.0 };
        Box::new(Self { cuts, rms_rad, depth: depth_of(&cuts, rms_rad, knee), knee })
    }
}

/// How deep the rails of a pair cut whose sine and cosine are offset: one end first, the other less or not at all; of both channels or one.
fn shifted(rng: &mut ChaCha8Rng) -> [[f64; 2]; 2] {
    let only = index(rng, 4);
    core::array::from_fn(|channel| {
        let other_end = (uniform(rng, -0.5, 0.9)).max(0.0);
        let upper = index(rng, 2) == 1;
        match (only, upper) {
            (0 | 1, _) if only != channel => [0.0; 2],
            (_, true) => [other_end, 1.0],
            (_, false) => [1.0, other_end],
        }
    })
}

/// Depth at which such cuts make a phase error of an rms, radians, pooled over the segments.
fn depth_of(cuts: &[[[f64; 2]; 2]; SEGMENTS], rms_rad: f64, knee: f64) -> f64 {
    let (mut low, mut high) = (if knee > 0.0 { -HIGHEST } else { 0.0 }, DEEPEST);
    for _ in 0..40 {
        let depth = 0.5 * (low + high);
        let power: f64 = cuts.iter().map(|cuts| error_power(cuts, depth, knee)).sum();
        if power / SEGMENTS as f64 > rms_rad * rms_rad { high = depth } else { low = depth }
    }
    0.5 * (low + high)
}

/// A channel between its rails, of an amplitude of 1.
fn cut(value: f64, cuts: &[f64; 2], depth: f64, knee: f64) -> f64 {
    let rail = |share: f64| if share > 0.0 { 1.0 - share * depth } else { f64::INFINITY };
    if knee == 0.0 {
        return value.clamp(-rail(cuts[0]), rail(cuts[1]));
    }
    let rail = rail(cuts[usize::from(value > 0.0)]);
    if rail.is_infinite() { value } else { value.signum() * limited(value.abs(), rail, knee) }
}

/// What diodes let through that clamp a value near a rail: their current grows by e over a knee, until it takes all that is more.
fn limited(value: f64, rail: f64, knee: f64) -> f64 {
    let taken = |value: f64| knee * ((value - rail) / knee).exp().ln_1p();
    value - taken(value) + taken(0.0)
}

/// Mean square of the phase error of a pair between its rails.
fn error_power(cuts: &[[f64; 2]; 2], depth: f64, knee: f64) -> f64 {
    if *cuts == [[0.0; 2]; 2] {
        return 0.0;
    }
    let steps = 2000;
    let power = (0..steps).map(|i| {
        let phase = TAU * ((f64::from(i) + 0.5) / f64::from(steps) - 0.5);
        let (sine, cosine) = phase.sin_cos();
        (cut(sine, &cuts[0], depth, knee).atan2(cut(cosine, &cuts[1], depth, knee)) - phase).powi(2)
    });
    power.sum::<f64>() / f64::from(steps)
}

impl PlantEffect for AdcClipping {
    fn scale(&mut self, factor: f64) {
        self.rms_rad *= factor;
        self.depth = depth_of(&self.cuts, self.rms_rad, self.knee);
    }

    fn analog(&mut self, _at: &Instant, channels: &mut Channels) {
        let amplitude = channels.amplitude_counts;
        for (pair, cuts) in channels.quadrature.iter_mut().zip(&self.cuts) {
            for (value, cuts) in pair.iter_mut().zip(cuts) {
                *value = amplitude * cut(*value / amplitude, cuts, self.depth, self.knee);
            }
        }
    }
}

// --- sensor side: the phase of a clipped circle ---

/// What a sensor can know of it: shares nothing with the plant side above.
pub mod sensor_side {
    use core::f64::consts::{PI, TAU};
    use courier_signal::equations::OWN_ORDERS;
    use crate::rails::{Clip, KNEE, RAILS};
    pub use crate::rails::{Parts, parts, phase_error, saturated};
    use crate::sensor::{Covariates, Regressor, BasisInputs};

    /// Lower and upper rail of sine and cosine, then offsets, gain of the sine less one, quadrature angle and knee: of an amplitude of 1.
    const PARTS: [&str; 9] = [
        "sine's lower rail",
        "sine's upper rail",
        "cosine's lower rail",
        "cosine's upper rail",
        "sine offset",
        "cosine offset",
        "gain",
        "quadrature angle",
        "knee",
    ];
    /// What the figure of a soft clip leaves uncertain of each of [`PARTS`]: a rail and its knee do nearly the same, offsets and the
    /// other flaws of a pair are some hundredths.
    const UNCERTAIN: [f64; 9] = [0.005, 0.005, 0.005, 0.005, 0.003, 0.003, 0.003, 0.003, 0.02];
    /// And of the whole.
    const WHOLE: f64 = 0.03;

    /// The same pair with nothing cut.
    fn open(p: &Parts) -> Parts {
        core::array::from_fn(|j| match j {
            _ if j >= RAILS => p[j],
            _ if j % 2 == 0 => -Clip::OPEN,
            _ => Clip::OPEN,
        })
    }

    /// Parts that matter: a rail that nothing reaches does not, nor a knee of rails that are hard.
    fn acting(p: &Parts) -> impl Iterator<Item = usize> {
        let p = *p;
        (0..p.len()).filter(move |j| match *j {
            KNEE => soft(&p),
            j => j >= RAILS || p[j].abs() < Clip::OPEN,
        })
    }

    fn soft(p: &Parts) -> bool {
        p[KNEE] >= Clip::HARD
    }

    /// A clip in words: which channel is cut at which of its ends, of that channel's own amplitude.
    fn told(p: &Parts, segment: usize) -> String {
        let amplitude = [1.0 + p[6], 1.0];
        let rails: Vec<String> = (0..RAILS)
            .filter(|j| p[*j].abs() < Clip::OPEN)
            .map(|j| format!("{} at {:+.3}", ["sine", "cosine"][j / 2], p[j] / amplitude[j / 2]))
            .collect();
        let kind = if soft(p) { format!("soft clip (knee {:.2})", p[KNEE]) } else { "clip".into() };
        format!("{kind} of the {} of amplitude, segment {}", rails.join(", "), segment + 1)
    }

    /// Points of the inverse's table. Derived from the straight lines between them: over a step of 0.003 rad a bend of one is
    /// missed by 1.2e-6 rad, 0.2 nm at the paper's pitch.
    const POINTS: usize = 2048;

    /// What must be added to a clipped phase: the inverse of `phase + phase_error(phase)`, tabulated over one turn.
    fn correction(p: &Parts) -> Vec<f64> {
        let seen: Vec<(f64, f64)> = (0..4 * POINTS)
            .map(|i| {
                let phase = TAU * i as f64 / (4 * POINTS) as f64 - PI;
                (phase + phase_error(phase, p), phase)
            })
            .collect();
        let mut at = 0;
        (0..POINTS)
            .map(|i| {
                let wanted = TAU * i as f64 / POINTS as f64 - PI;
                while at + 1 < seen.len() && seen[at + 1].0 < wanted {
                    at += 1;
                }
                let (a, b) = (seen[at], seen[(at + 1).min(seen.len() - 1)]);
                let part = if b.0 > a.0 {
                    ((wanted - a.0) / (b.0 - a.0)).clamp(0.0, 1.0)
                } else {
                    0.5
                };
                a.1 + part * (b.1 - a.1) - wanted
            })
            .collect()
    }

    /// A correction by phase with what it bends of the harmonics (rad) beneath it.
    fn bending(mut correction: Vec<f64>, harmonics: &[f64; 8]) -> Vec<f64> {
        let error = |phase: f64| -> f64 {
            let orders = OWN_ORDERS.map(f64::from).into_iter().zip(harmonics.chunks(2));
            orders.map(|(n, k)| k[0] * (n * phase).sin() + k[1] * (n * phase).cos()).sum()
        };
        for (i, off) in correction.iter_mut().enumerate() {
            let phase = TAU * i as f64 / POINTS as f64 - PI;
            *off += error(phase + *off) - error(phase);
        }
        correction
    }

    fn look_up(table: &[f64], phase: f64) -> f64 {
        let turns = phase / TAU + 0.5;
        let place = (turns - turns.floor()) * POINTS as f64;
        let cell = place as usize % POINTS;
        let part = place - place.floor();
        table[cell] * (1.0 - part) + table[(cell + 1) % POINTS] * part
    }

    /// Step of the derivatives by the levels.
    const STEP: f64 = 0.004;

    /// Rails and pair are told: shapes over the phase that is seen. What an offset, a gain or an angle does to a wave
    /// that is not cut is equation (3)'s; only what is beyond that is wanted.
    fn by_phase(list: &mut Vec<Regressor>, inputs: &BasisInputs, s: usize, clip: &Clip) {
        let metres = inputs.pitch_m / TAU;
        let p = parts(clip);
        let beneath = inputs.beneath[s].unwrap_or_default().map(|k| k / metres);
        let beyond = |p: &Parts| -> Vec<f64> {
            let plain = correction(&open(p));
            let cut = correction(p).iter().zip(&plain).map(|(cut, whole)| cut - whole).collect();
            bending(cut, &beneath)
        };
        let shape = beyond(&p);
        for j in acting(&p) {
            let mut more = p;
            more[j] += STEP;
            let table: Vec<f64> =
                beyond(&more).iter().zip(&shape).map(|(a, b)| (a - b) / STEP).collect();
            let name = format!("change of the {}, segment {}", PARTS[j], s + 1);
            let change = Regressor::reading(name, "of amplitude", 1.0e-6, s, move |m| {
                metres * look_up(&table, m.phase_without_wander_rad(s))
            });
            list.push(if soft(&p) { change.of_deviation(UNCERTAIN[j]) } else { change });
        }
        let whole = Regressor::reading(told(&p, s), "1", 10.0e-6, s, move |m| {
            metres * look_up(&shape, m.phase_without_wander_rad(s))
        });
        list.push(if soft(&p) { whole.expected(1.0, WHOLE) } else { whole });
    }

    fn by_reference(list: &mut Vec<Regressor>, s: usize, clip: &Clip, found: [f64; 2], metres: f64) {
        let p = parts(clip);
        let [zero, delay_s] = found;
        let at = move |m: &Covariates| m.reference_phase[s] + zero - delay_s * m.speed_m_s[s] / metres;
        list.push(Regressor::reading(told(&p, s), "1", 20.0e-6, s, move |m| {
            -metres * phase_error(at(m), &p)
        }));
        for j in acting(&p) {
            let mut more = p;
            more[j] += STEP;
            let name = format!("change of the {}, segment {}", PARTS[j], s + 1);
            list.push(Regressor::reading(name, "of amplitude", 2.0e-6, s, move |m| {
                let phase = at(m);
                -metres * (phase_error(phase, &more) - phase_error(phase, &p)) / STEP
            }));
        }
    }

    /// Positions alone: the levels are not seen, so a few of them stand for all; sine and cosine clip at different phases.
    fn by_family(list: &mut Vec<Regressor>, s: usize, metres: f64) {
        for level in [0.71, 0.75, 0.79, 0.83, 0.86, 0.89, 0.92, 0.95, 0.98] {
            for channel in 0..2 {
                let mut p = open(&[0.0; 9]);
                (p[2 * channel], p[2 * channel + 1]) = (-level, level);
                let table = correction(&p);
                let name = format!(
                    "{} clipped at {level}, segment {}",
                    ["sine", "cosine"][channel],
                    s + 1
                );
                list.push(Regressor::reading(name, "1", 4.0e-6, s, move |m| {
                    metres * look_up(&table, m.raw_phase[s])
                }));
            }
        }
    }

    /// Sensor side: atan2 of clipped sine and cosine less the phase, with its derivatives by the levels.
    pub fn regressors(inputs: &BasisInputs) -> Vec<Regressor> {
        let mut list = Vec::new();
        let metres = inputs.pitch_m / TAU;
        for s in (0..4).filter(|s| inputs.segments[*s]) {
            match inputs.clip[s] {
                Some(clip) => match clip.zero_and_delay {
                    Some(found) => by_reference(&mut list, s, &clip, found, metres),
                    None => by_phase(&mut list, inputs, s, &clip),
                },
                None if !inputs.counts && inputs.lateral => by_family(&mut list, s, metres),
                None => {}
            }
        }
        list
    }
}

// --- what is known of it ---

use crate::effect::{Acts, Card, Confusable, Effect, Detection, ColumnOrder, Quantity};
use crate::sensor::{Regressor, BasisInputs};

/// The effect.
pub struct Definition;

/// Its card.
pub static CARD: Card = Card {
    name: "adc_clipping",
    summary: "a quadrature channel saturates",
    sizes: "10 µm for what a pair's counts show, 20 µm for what a reference shows: rails at 0.655 to 0.673 of the amplitude made 20.6 µm (ESS resolver)",
    telling_motion: "any motion over a few teeth with raw counts: the tops are seen to be flat, or the pair's circle to be bent in",
    detection: Detection::ByRails,
    order: ColumnOrder::First,
    follows: Quantity::OwnPhase,
    coordinate: "own tooth phase, orders 4, 8, 12, 16",
    acts: Acts::Electronics,
    confusable: &[
        Confusable { with: "extra_harmonics", parted_by: "a clip makes the orders 4, 8, 12 and 16: raw counts show whether the tops are flat" },
    ],
    ..Card::PLAIN
};

impl Effect for Definition {
    fn card(&self) -> &'static Card {
        &CARD
    }

    fn draw(&self, scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        AdcClipping::draw(scene, rng, size_rms_m)
    }

    fn shapes(&self, inputs: &BasisInputs) -> Vec<Regressor> {
        sensor_side::regressors(inputs)
    }
}
