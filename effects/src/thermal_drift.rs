//! `thermal_drift`: offsets and scale follow temperature.
//!
//! Each coil's mount and electronics drift by their own coefficient (5.6 um/K has been seen on an eddy-current probe); platen
//! and courier grow by 5 to 22 ppm/K.

// --- plant side: from the true pose to a displacement ---

use crate::plant::{Instant, PlantEffect, SEGMENTS, Scene, SegmentPoint};
use crate::random::{ChaCha8Rng, normal, uniform};
use crate::shape::segment_offsets;

/// Range of temperature at which the size is stated, kelvin: a warm-up. A definition: a board warms by a few kelvin when it is
/// switched on.
const RANGE_K: f64 = 4.0;

/// Plant side. Size: standard deviation of the segments' offsets over a temperature uniform within 0 to 4 K, pooled.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct ThermalDrift {
    /// Each segment's drift, m/K.
    pub offset_m_per_k: [f64; SEGMENTS],
    /// Curvature: the drift's coefficient changes by this share per kelvin.
    pub curvature_per_k: f64,
    /// Growth of the platen, 1/K.
    pub growth_per_k: f64,
}

impl ThermalDrift {
    /// Offsets normal, a mild curvature, growth in proportion: 5 to 22 ppm/K beside 2 um.
    pub fn draw(_scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let curvature_per_k = 0.02 * normal(rng);
        // Standard deviation of t + c t^2 over uniform 0..T: moments of a uniform variable.
        let (t, c) = (RANGE_K, curvature_per_k);
        let variance = t * t / 12.0 + c * t.powi(3) / 6.0 + c * c * t.powi(4) * 4.0 / 45.0;
        Box::new(Self {
            offset_m_per_k: segment_offsets(rng, size_rms_m / variance.sqrt()),
            curvature_per_k,
            growth_per_k: uniform(rng, 5.0e-6, 22.0e-6) * size_rms_m / 2.0e-6,
        })
    }
}

impl PlantEffect for ThermalDrift {
    fn scale(&mut self, factor: f64) {
        self.offset_m_per_k = self.offset_m_per_k.map(|c| c * factor);
        self.growth_per_k *= factor;
    }

    fn platen(&mut self, at: &Instant, points: &mut [SegmentPoint; SEGMENTS]) {
        // A grown ruling has fewer pitches to the same place.
        let shrink = 1.0 - self.growth_per_k * at.temperature_delta_k;
        for point in points {
            point.own_m *= shrink;
            point.across_m *= shrink;
        }
    }

    fn displacement_m(&mut self, at: &Instant, _points: &[SegmentPoint; SEGMENTS]) -> [f64; SEGMENTS] {
        let warm = at.temperature_delta_k * (1.0 + self.curvature_per_k * at.temperature_delta_k);
        self.offset_m_per_k.map(|c| c * warm)
    }
}

// --- sensor side: offsets and scales times temperature ---

/// What a sensor can know of it: shares nothing with the plant side above.
pub mod sensor_side {
    use crate::identity::{Factor, Identity, Wave};
    use crate::sensor::{LAGS_S, Regressor, BasisInputs};

    /// Prior of a scale's growth: aluminium, the most that a platen or a courier is made of (steel 11.5 ppm/K).
    const GROWTH_PER_K: f64 = 22.0e-6;

    /// How far off the mean temperature a ruling may be right, K. A prior: it was made in a laboratory at 20 °C, and the board
    /// may be warm.
    pub const RIGHT_WITHIN_K: f64 = 20.0;

    /// The bend of a drift over the temperatures that were measured. It is told from their middle, so that the linear part is the mean
    /// slope over them. It `goes_on` beyond their ends, or stays what it was there: then that part alone is carried on.
    fn bent(warmth_k: f64, [coldest, warmest]: [f64; 2], goes_on: bool) -> f64 {
        let middle = 0.5 * (coldest + warmest);
        let half = 0.5 * (warmest - coldest);
        let away = warmth_k - middle;
        let away = if half > 0.0 && !goes_on {
            away.clamp(-half, half)
        } else {
            away
        };
        away * away
    }

    /// Orders by which a pair that warms shifts its segment: those of its offsets, and of its gain and angle. Derived from the
    /// pair's phase: an offset makes order 1, gain and angle make (g/2) sin 2φ and (ψ/2)(1 - cos 2φ).
    const PAIR_ORDERS: [usize; 2] = [1, 2];
    /// Prior size of each: it completes the drift.
    const PAIR_SIZE_M: f64 = 1.0e-6;
    /// The same where the counts show that the pair wanders. A prior: offsets of 0.3 to 0.5 % of the amplitude are usual (ESS
    /// resolver) and 6 % has been seen (lib_sincos_enc), where 1 % makes 1.6 µm.
    const WANDER_SIZE_M: f64 = 3.0e-6;

    /// Prior of what a mount's drift is behind the board's: as much as the drift itself (5.6 um/K has been seen).
    const DRIFT_M_PER_K: f64 = 3.0e-6;

    /// A long lag and a bend over time are alike where a recording warms once: it is told where a gap is left without.
    fn lags_s(inputs: &BasisInputs) -> &'static [f64] {
        let [quick @ .., _] = &LAGS_S;
        if inputs.forms.warms_slowly {
            &LAGS_S
        } else {
            quick
        }
    }

    /// Sensor side: each segment's offset, the scale of both axes, and the coordination sensor's offset and gain; of a pair that wanders, as
    /// its counts show, its own offsets, gain and angle.
    pub fn regressors(inputs: &BasisInputs) -> Vec<Regressor> {
        let mut list = Vec::new();
        let (range, goes_on) = (inputs.warmths_k, inputs.bend_goes_on);
        let lags_s = lags_s(inputs);
        for s in (0..4).filter(|s| inputs.segments[*s]) {
            let name = format!("offset, segment {}", s + 1);
            let offset = Regressor::reading(name, "m/K", 4.0e-6, s, |m| m.warmth_k);
            list.push(offset.identified(Identity::Wave(Wave::constant(s, Factor::Warmth))));
            let name = format!("offset, second order, segment {}", s + 1);
            list.push(Regressor::reading(name, "m/K²", 0.7e-6, s, move |m| {
                bent(m.warmth_k, range, goes_on)
            }));
            for (lag, seconds) in lags_s.iter().enumerate() {
                let name = format!("offset, {seconds} s behind, segment {}", s + 1);
                let behind = Regressor::reading(name, "m/K", 0.7e-6, s, move |m| m.behind_k[lag]);
                list.push(behind.of_deviation(DRIFT_M_PER_K));
            }
            let wanders = inputs.counts && inputs.pair_wanders[s];
            let size_m = if wanders { WANDER_SIZE_M } else { PAIR_SIZE_M };
            for order in PAIR_ORDERS.into_iter().filter(|_| wanders || inputs.forms.pairs_warm) {
                let label = ("warmth times ", "m/K", size_m, Factor::Warmth);
                Regressor::free_harmonic(inputs, &mut list, (s, order), label, |m| m.warmth_k);
            }
        }
        for axis in 0..2 {
            let label = ["x", "y"][axis];
            // From the middle of the places: where the tooth counts have their zero is arbitrary, and growth about another
            // place differs by an offset, which is there already.
            let grown = Regressor::readings(
                format!("scale of {label}"),
                "1/K",
                4.0e-6,
                move |m, out| {
                    for s in [axis, axis + 2] {
                        out[s] += m.warmth_k * m.from_middle_m[axis];
                    }
                },
            );
            list.push(grown.of_deviation(GROWTH_PER_K).identified(Identity::Growth { axis }));
            if inputs.growth_told {
                let name = format!("scale of {label} at the mean temperature");
                let there = Regressor::readings(name, "1", 4.0e-6, move |m, out| {
                    for s in [axis, axis + 2] {
                        out[s] += m.from_middle_m[axis];
                    }
                });
                let there = there.of_deviation(GROWTH_PER_K * RIGHT_WITHIN_K);
                list.push(there.identified(Identity::GrowthAtMean { axis }));
            }
            if inputs.beacon {
                let name = format!("coordination sensor's offset {label}");
                list.push(Regressor::reading(name, "1/K", 2.0e-6, 4 + axis, |m| {
                    m.warmth_k
                }));
                for (lag, seconds) in lags_s.iter().enumerate() {
                    let name =
                        format!("coordination sensor's offset {label}, {seconds} s behind");
                    let behind = Regressor::reading(name, "1/K", 0.35e-6, 4 + axis, move |m| {
                        m.behind_k[lag]
                    });
                    list.push(behind.of_deviation(DRIFT_M_PER_K / 0.1));
                }
                let name = format!("coordination sensor's gain {label}");
                list.push(Regressor::reading(
                    name,
                    "1/K",
                    2.0e-6,
                    4 + axis,
                    move |m| m.warmth_k * m.tan_psi[axis],
                ));
            }
        }
        list
    }

    #[cfg(test)]
    mod tests {
        use super::*;

        #[test]
        fn beyond_the_measured_temperatures_the_bend_stands_and_its_mean_slope_is_none() {
            let range = [-1.0, 3.0];
            assert_eq!(bent(-1.0, range, false), bent(3.0, range, false));
            assert_eq!(bent(1.0, range, false), 0.0);
            assert_eq!(bent(-9.0, range, false), bent(-1.0, range, false));
            assert_eq!(bent(9.0, range, false), bent(3.0, range, false));
            assert_eq!(bent(9.0, range, true), 64.0);
            // A model that was written without a range.
            assert_eq!(bent(2.0, [0.0; 2], false), 4.0);
        }
    }
}

// --- what is known of it ---

use crate::effect::{Card, Confusable, Effect, Form, Subsumption, KnownBy, Need, Quantity, Recordings, Cost};
use crate::sensor::{Regressor, BasisInputs};

/// The effect.
pub struct Definition;

/// Its card.
pub static CARD: Card = Card {
    name: "thermal_drift",
    summary: "offsets and scale follow temperature",
    sizes: "4 µm for an offset over the recording's temperatures (5.6 µm/K of an eddy-current probe, Klipper pull 7358), 22 ppm/K for growth (aluminium; steel 11.5)",
    telling_motion: "the same poses at two temperatures, and again at the first",
    recordings: Recordings::ColdAndWarm,
    needs: &[Need::Temperature],
    follows: Quantity::Temperature,
    coordinate: "temperature",
    carries_over: "its amounts; its bend beyond the temperatures that were measured only where the recording shows that it goes on",
    forms: &[
        Form { cost: Cost::Few, ..Form::new("mounts that follow the temperature slowly", |told| told.warms_slowly = true) },
        Form::new("offsets, gain and angle of the pairs follow it as well", |told| told.pairs_warm = true),
        // A pair that warms wanders.
        Form {
            completed_by: Some("quadrature_drift"),
            cost: Cost::OneForTwo,
            ..Form::new("offsets, gain and angle of the pairs follow it, and no clock", |told| told.pairs_warm = true)
        },
    ],
    // A ruling that grows with temperature is right at one that need not be the mean: at the mean it has another pitch, and is not
    // skewed for that.
    subsumes: &[Subsumption { other: "axis_skew", tell: &[|inputs| inputs.growth_told = true], known_by: KnownBy::Growth { within_k: sensor_side::RIGHT_WITHIN_K } }],
    on_board: "offsets, and the pairs' own change with temperature",
    confusable: &[
        Confusable { with: "quadrature_drift", parted_by: "a temperature that only rises is a clock: the same poses at two temperatures and again at the first tell" },
        Confusable { with: "axis_skew", parted_by: "a platen that grew has another pitch: recordings at two temperatures tell" },
    ],
    ..Card::PLAIN
};

impl Effect for Definition {
    fn card(&self) -> &'static Card {
        &CARD
    }

    fn draw(&self, scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        ThermalDrift::draw(scene, rng, size_rms_m)
    }

    fn shapes(&self, inputs: &BasisInputs) -> Vec<Regressor> {
        sensor_side::regressors(inputs)
    }
}
