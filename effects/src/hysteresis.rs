//! `hysteresis`: the output depends on the direction of travel, not on the speed.
//!
//! Remanence of the teeth under the coils: the output trails by a fixed amount once the courier has moved some tens of
//! micrometres one way, and turns over gradually on reversal (the memory of Dahl 1968's friction model).

// --- plant side: from the true pose to a displacement ---

use crate::plant::{Instant, PlantEffect, SEGMENTS, Scene, SegmentPoint};
use crate::random::{ChaCha8Rng, log_uniform};
use crate::shape::segment_offsets;

/// Plant side. Size: rms over the segments of the displacement after long travel one way.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct Hysteresis {
    /// Each segment's displacement after long travel in the positive direction, metres.
    pub saturated_m: [f64; SEGMENTS],
    /// Travel over which it turns over, metres.
    pub turnover_m: f64,
    memory: [f64; SEGMENTS],
    last_m: Option<[f64; SEGMENTS]>,
}

impl Hysteresis {
    /// Turnover within 3 to 40 um.
    pub fn draw(_scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        Box::new(Self {
            saturated_m: segment_offsets(rng, size_rms_m),
            turnover_m: log_uniform(rng, 3.0e-6, 40.0e-6),
            memory: [0.0; SEGMENTS],
            last_m: None,
        })
    }
}

impl PlantEffect for Hysteresis {
    fn scale(&mut self, factor: f64) {
        self.saturated_m = self.saturated_m.map(|b| b * factor);
    }

    fn displacement_m(&mut self, _at: &Instant, points: &[SegmentPoint; SEGMENTS]) -> [f64; SEGMENTS] {
        let now_m = points.map(|point| point.own_m);
        let last_m = self.last_m.replace(now_m).unwrap_or(now_m);
        core::array::from_fn(|s| {
            let travel_m = now_m[s] - last_m[s];
            let towards = travel_m.signum();
            self.memory[s] = towards + (self.memory[s] - towards) * (-travel_m.abs() / self.turnover_m).exp();
            self.saturated_m[s] * self.memory[s]
        })
    }
}

// --- sensor side: direction of travel ---

/// What a sensor can know of it: shares nothing with the plant side above.
pub mod sensor_side {
    use crate::identity::{Factor, Identity, Wave};
    use crate::sensor::{Covariates, Regressor, BasisInputs, TURNOVERS};

    /// How it turns over, and the lengths of travel over which it does.
    const TURNED: [&str; TURNOVERS] = [
        "over within 4 um",
        "over within 12 um",
        "over within 40 um",
        "over within 120 um",
        "evenly over 3 um",
        "evenly over 6 um",
        "evenly over 12 um",
        "evenly over 24 um",
        "evenly over 48 um",
        "evenly over 96 um",
    ];

    /// What a segment brought along: another recording has another.
    pub const BEFORE: &str = "way before";

    /// Prior size of what the direction alone does, m: 4 to 7 µm in one report of a stage.
    const DIRECTION_SIZE_M: f64 = 4.0e-6;
    /// The same of the direction from which a still pose was approached.
    const APPROACH_SIZE_M: f64 = 3.0e-6;
    /// The effect itself where it is remanence: what the direction alone does is the same of no travel to turn over in.
    const MEMORY_SIZE_M: f64 = 2.0e-6;

    /// States whose strength may change over a tooth: one that turns over soon, one late.
    const WAVES: [usize; 2] = [6, 8];
    /// How much more of it there is at one place of a tooth than at another: it completes the effect.
    /// A prior: less than the effect itself, and more than the noise.
    const WAVES_SIZE_M: f64 = 0.4e-6;

    /// State that a slow courier may feel less of.
    const SOFTENED: usize = 5;
    /// Speeds below which a slow courier may feel less of it, m/s. A prior: from a creep of 3 mm/s to the fly-bys' 50 mm/s, in
    /// steps of four.
    const SOFT_M_S: [f64; 3] = [3.0e-3, 12.0e-3, 50.0e-3];
    /// Share that is missing at a speed: all of it at rest, 0.7 of it at the speed named.
    fn softened(speed_m_s: f64, below_m_s: f64) -> f64 {
        below_m_s / speed_m_s.hypot(below_m_s)
    }

    /// What a segment still has in its memory of the way that it came by to a stretch, of which nothing is recorded.
    pub fn brought_along(segment: usize, stretch: usize) -> Regressor {
        let name = match stretch {
            0 => format!("{BEFORE} the recording, segment {}", segment + 1),
            _ => format!("{BEFORE} stretch {}, segment {}", stretch + 1, segment + 1),
        };
        Regressor::reading(name, "m", MEMORY_SIZE_M, segment, move |m| {
            if m.stretch == stretch { m.before[segment] } else { 0.0 }
        })
        .identified(Identity::BroughtAlong)
    }

    /// What turns over within a tenth of a millimetre is, to a board, a direction.
    fn way(segment: usize) -> Identity {
        Identity::Wave(Wave::constant(segment, Factor::Way))
    }

    /// Sensor side: the direction while moving, and that of the approach while still.
    pub fn regressors(inputs: &BasisInputs) -> Vec<Regressor> {
        let mut list = Vec::new();
        let fades = inputs.forms.fades_at_rest;
        for s in (0..4).filter(|s| inputs.segments[*s]) {
            if inputs.moving {
                let name = format!("direction of travel, segment {}", s + 1);
                let one = Regressor::reading(name, "m", DIRECTION_SIZE_M, s, move |m| m.direction[s]);
                list.push(one.identified(way(s)));
            }
            for (k, travel) in TURNED.into_iter().enumerate() {
                let mut remembers = |when: &str, there: fn(&Covariates) -> bool| {
                    let name = format!("direction turned {travel}{when}, segment {}", s + 1);
                    let one = Regressor::reading(name, "m", MEMORY_SIZE_M, s, move |m| {
                        if there(m) { m.memory[s][k] } else { 0.0 }
                    });
                    list.push(one.identified(way(s)));
                };
                if inputs.forms.fades_at_rest {
                    remembers(", in motion", |m| m.underway);
                    remembers(", at rest", |m| !m.underway);
                } else {
                    remembers("", |_| true);
                }
            }
            for (k, travel) in TURNED.into_iter().enumerate().filter(|(k, _)| inputs.forms.memory_waves && WAVES.contains(k)) {
                let name = format!("direction turned {travel} times ");
                Regressor::free_harmonic(
                    inputs,
                    &mut list,
                    (s, 1),
                    (name.as_str(), "m", WAVES_SIZE_M, Factor::Way),
                    move |m| if fades && !m.underway { 0.0 } else { m.memory[s][k] },
                );
            }
            for below in SOFT_M_S.into_iter().filter(|_| inputs.forms.softens) {
                let name = format!("direction that is less below {:.0} mm/s, segment {}", 1.0e3 * below, s + 1);
                list.push(Regressor::reading(name, "m", MEMORY_SIZE_M, s, move |m| {
                    if m.underway { m.memory[s][SOFTENED] * softened(m.speed_m_s[s], below) } else { 0.0 }
                }));
            }
            list.push(brought_along(s, 0));
            let name = format!("direction of approach, segment {}", s + 1);
            list.push(Regressor::reading(name, "m", APPROACH_SIZE_M, s, move |m| {
                m.approach[s]
            }));
        }
        list
    }
}

// --- what is known of it ---

use crate::effect::{Card, Confusable, Effect, Form, Quantity};
use crate::sensor::{Regressor, BasisInputs};

/// The effect.
pub struct Definition;

/// Its card.
pub static CARD: Card = Card {
    name: "hysteresis",
    summary: "the output depends on the direction of travel, not on the speed",
    sizes: "4 µm for the direction (4 to 7 µm in one report of a stage, ESS), 2 µm for each length over which it turns over",
    telling_motion: "the same fly-by there and back at two speeds",
    follows: Quantity::Way,
    coordinate: "direction",
    carries_over: "its amounts; what a segment brought along from a way that is not recorded is fitted anew",
    remembers: true,
    forms: &[
        Form::new("a memory that is less at rest", |told| told.fades_at_rest = true),
        Form::new("a memory that changes over a tooth", |told| told.memory_waves = true),
        // A direction alone takes half of what only a fast courier feels.
        Form { far_from_it: true, ..Form::new("a slow courier feels less of it", |told| told.softens = true) },
        // At two speeds a delay and its square are a direction.
        Form {
            found_as: Some("velocity_lag"),
            ..Form::new("a slow courier feels less of it, and at rest there is less", |told| {
                told.fades_at_rest = true;
                told.softens = true;
            })
        },
    ],
    on_board: "the direction of travel; how it turns over is left",
    confusable: &[
        Confusable { with: "velocity_lag", parted_by: "at one speed a delay is a direction: the same fly-by there and back at two speeds tells" },
    ],
    ..Card::PLAIN
};

impl Effect for Definition {
    fn card(&self) -> &'static Card {
        &CARD
    }

    fn draw(&self, scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        Hysteresis::draw(scene, rng, size_rms_m)
    }

    fn shapes(&self, inputs: &BasisInputs) -> Vec<Regressor> {
        sensor_side::regressors(inputs)
    }

    fn brought_along(&self, segment: usize, stretch: usize) -> Option<Regressor> {
        Some(sensor_side::brought_along(segment, stretch))
    }
}
