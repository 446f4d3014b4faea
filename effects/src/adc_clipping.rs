//! `adc_clipping`: a quadrature channel saturates.

// --- plant side: limits at the converter ---

use crate::plant::{Channels, Instant, PlantEffect, SEGMENTS, Scene};
use crate::random::{ChaCha8Rng, index, uniform};
use core::f64::consts::TAU;

/// Plant side. Size: rms of the displacement over the phase, pooled over the segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AdcClipping {
    /// Which segments clip.
    pub hit: [bool; SEGMENTS],
    /// Rms of a clipping segment, radians of its phase.
    rms_rad: f64,
    /// Level, share of the amplitude.
    pub level: f64,
}

impl AdcClipping {
    /// One segment, two, or all: gain was set too high for them.
    pub fn draw(scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let (first, second) = (index(rng, SEGMENTS), index(rng, SEGMENTS));
        let all = uniform(rng, 0.0, 1.0) < 0.25;
        let hit: [bool; SEGMENTS] = core::array::from_fn(|s| all || s == first || s == second);
        let hits = hit.iter().filter(|h| **h).count() as f64;
        let rms_rad = size_rms_m * scene.geometry.wavenumber() * (SEGMENTS as f64 / hits).sqrt();
        Box::new(Self { hit, rms_rad, level: level_of(rms_rad) })
    }
}

/// Level, as a share of the amplitude, at which clipping makes a phase error of an rms, radians. At least 0.3.
fn level_of(rms_rad: f64) -> f64 {
    let (mut low, mut high) = (0.3, 1.0);
    for _ in 0..40 {
        let level = 0.5 * (low + high);
        if error_rad(level) > rms_rad { low = level } else { high = level }
    }
    0.5 * (low + high)
}

/// Rms phase error of both channels clipped at a level.
fn error_rad(level: f64) -> f64 {
    // A quarter turn repeats.
    let steps = 2000;
    let power = (0..steps).map(|i| {
        let phase = TAU / 4.0 * (f64::from(i) + 0.5) / f64::from(steps);
        (phase.sin().min(level).atan2(phase.cos().min(level)) - phase).powi(2)
    });
    (power.sum::<f64>() / f64::from(steps)).sqrt()
}

impl PlantEffect for AdcClipping {
    fn scale(&mut self, factor: f64) {
        self.rms_rad *= factor;
        self.level = level_of(self.rms_rad);
    }

    fn analog(&mut self, _at: &Instant, channels: &mut Channels) {
        let limit = self.level * channels.amplitude_counts;
        for (pair, _) in channels.quadrature.iter_mut().zip(self.hit).filter(|(_, hit)| *hit) {
            pair.iter_mut().for_each(|value| *value = value.clamp(-limit, limit));
        }
    }
}

// --- sensor side: the phase of a clipped circle ---

pub use sensor_side::ClipModel;

/// What a sensor can know of it: shares nothing with the plant side above.
pub mod sensor_side {
    use core::f64::consts::{PI, TAU};
    use crate::sensor::{Clip, Moment, Regressor, SensorEffect, Survey};

    /// Sensor side: atan2 of clipped sine and cosine less the phase, with its derivatives by the levels.
    pub struct ClipModel;

    /// Error of the phase, rad: `[sine level, cosine level, sine offset, cosine offset, gain less one, angle]`, of amplitude 1.
    pub fn phase_error(phase: f64, p: &[f64; 6]) -> f64 {
        let sine = ((1.0 + p[4]) * (phase + p[5]).sin() + p[2]).clamp(-p[0], p[0]);
        let cosine = (phase.cos() + p[3]).clamp(-p[1], p[1]);
        let error = sine.atan2(cosine) - phase;
        error - TAU * (error / TAU).round()
    }

    /// Points of the inverse's table.
    const POINTS: usize = 2048;

    /// What must be added to a clipped phase: the inverse of `phase + phase_error(phase)`, tabulated over one turn.
    fn correction(p: &[f64; 6]) -> Vec<f64> {
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

    fn look_up(table: &[f64], phase: f64) -> f64 {
        let turns = phase / TAU + 0.5;
        let place = (turns - turns.floor()) * POINTS as f64;
        let cell = place as usize % POINTS;
        let part = place - place.floor();
        table[cell] * (1.0 - part) + table[(cell + 1) % POINTS] * part
    }

    /// What [`phase_error`] depends on.
    const PARTS: [&str; 6] =
        ["sine level", "cosine level", "sine offset", "cosine offset", "gain", "quadrature angle"];
    /// A pair that is not clipped.
    const OPEN: [f64; 6] = [3.0, 3.0, 0.0, 0.0, 0.0, 0.0];

    /// Step of the derivatives by the levels.
    const STEP: f64 = 0.004;

    impl ClipModel {
        fn by_phase(list: &mut Vec<Regressor>, s: usize, level: [f64; 2], metres: f64) {
            let p = [level[0], level[1], 0.0, 0.0, 0.0, 0.0];
            let shape = correction(&p);
            for (j, label) in PARTS.into_iter().enumerate() {
                let mut more = p;
                more[j] += STEP;
                // Beside the clip, an offset, a gain or an angle is equation (3)'s: only what it does to the clip is wanted.
                let mut open = OPEN;
                open[j] += STEP;
                let plain = correction(&open);
                let table: Vec<f64> = correction(&more)
                    .iter()
                    .zip(&shape)
                    .zip(&plain)
                    .map(|((a, b), c)| (a - b - c) / STEP)
                    .collect();
                let name = format!("change of the {label}, segment {}", s + 1);
                list.push(Regressor::reading(name, "of amplitude", 1.0e-6, s, move |m| {
                    metres * look_up(&table, m.raw_phase[s])
                }));
            }
            let name = format!(
                "clip at {:.3} and {:.3} of amplitude, segment {}",
                level[0],
                level[1],
                s + 1
            );
            list.push(Regressor::reading(name, "1", 10.0e-6, s, move |m| {
                metres * look_up(&shape, m.raw_phase[s])
            }));
        }

        fn by_reference(list: &mut Vec<Regressor>, s: usize, clip: Clip, pair: [f64; 4], metres: f64) {
            let p = [
                clip.level[0],
                clip.level[1],
                pair[0],
                pair[1],
                pair[2],
                pair[3],
            ];
            let name = format!(
                "clip at {:.3} and {:.3} of amplitude, segment {}",
                p[0],
                p[1],
                s + 1
            );
            let [zero, delay_s] = clip.zero_and_delay;
            let at = move |m: &Moment| m.reference_phase[s] + zero - delay_s * m.speed_m_s[s] / metres;
            list.push(Regressor::reading(name, "1", 20.0e-6, s, move |m| {
                -metres * phase_error(at(m), &p)
            }));
            for j in 0..6 {
                let mut more = p;
                more[j] += STEP;
                let label = PARTS[j];
                let name = format!("change of the {label}, segment {}", s + 1);
                list.push(Regressor::reading(
                    name,
                    "of amplitude",
                    2.0e-6,
                    s,
                    move |m| {
                        let phase = at(m);
                        -metres * (phase_error(phase, &more) - phase_error(phase, &p)) / STEP
                    },
                ));
            }
        }

        /// Positions alone: the levels are not seen, so a few of them stand for all; sine and cosine clip at different phases.
        fn by_family(list: &mut Vec<Regressor>, s: usize, metres: f64) {
            for level in [0.71, 0.75, 0.79, 0.83, 0.86, 0.89, 0.92, 0.95, 0.98] {
                for channel in 0..2 {
                    let mut p = OPEN;
                    p[channel] = level;
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
    }

    impl SensorEffect for ClipModel {
        fn name(&self) -> &'static str {
            "adc_clipping"
        }

        fn sentence(&self) -> &'static str {
            "a quadrature channel saturates: its tops are cut off"
        }

        fn telling_motion(&self) -> &'static str {
            "any motion over a few teeth with raw counts: the tops are seen to be flat"
        }

        fn regressors(&self, survey: &Survey) -> Vec<Regressor> {
            let mut list = Vec::new();
            let metres = survey.pitch_m / TAU;
            for s in (0..4).filter(|s| survey.segments[*s]) {
                match survey.clip[s] {
                    Some(clip) => match clip.pair {
                        Some(pair) => Self::by_reference(&mut list, s, clip, pair, metres),
                        None => Self::by_phase(&mut list, s, clip.level, metres),
                    },
                    None if !survey.counts && survey.lateral => Self::by_family(&mut list, s, metres),
                    None => {}
                }
            }
            list
        }
    }
}
