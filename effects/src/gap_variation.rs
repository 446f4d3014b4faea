//! `gap_variation`: platen flatness or tilt changes amplitude, and the error with it.
//!
//! The signals fall as `exp(-2 pi gap / pitch)` and their harmonics faster, so the error's shape changes with the gap.

// --- plant side: from the true pose to signal level and displacement ---

use crate::plant::{Instant, PlantEffect, SEGMENTS, Scene, SegmentPoint, Signal};
use crate::random::{ChaCha8Rng, normal, uniform};
use crate::shape::{Periodic, Waves, segment_sizes};

/// Plant side. Size: rms of the displacement over the platen and the own phase, pooled over the segments.
pub struct GapVariation {
    /// Flatness, rms 1 over a large platen.
    flatness: Waves<2>,
    shapes: [Periodic; SEGMENTS],
    sizes_m: [f64; SEGMENTS],
    /// Rms of the gap's variation, metres.
    gap_m: f64,
}

/// Orders of the error that change with the gap, with relative weights.
const ORDERS: [(usize, f64); 4] = [(1, 1.0), (2, 0.8), (3, 0.25), (4, 0.3)];

impl GapVariation {
    /// Flatness with wavelengths of 15 to 90 mm; a gap three to eight times the error it causes.
    pub fn draw(_scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let shapes = core::array::from_fn(|_| {
            let weights = ORDERS.map(|(order, weight)| (order, weight * normal(rng).abs()));
            Periodic::draw(rng, &weights)
        });
        Box::new(Self {
            flatness: Waves::draw(rng, 12, 15.0e-3, 90.0e-3),
            shapes,
            sizes_m: segment_sizes(rng, size_rms_m),
            gap_m: size_rms_m * uniform(rng, 3.0, 8.0),
        })
    }

    /// Gap under a segment in units of its rms.
    fn gap(&self, at: &Instant, segment: usize, point: &SegmentPoint) -> f64 {
        let across_m = point.across_m + at.geometry.across_offset_m(segment);
        // Segments 0 and 2 run along x, 1 and 3 along y.
        self.flatness.at(if segment % 2 == 0 { [point.own_m, across_m] } else { [across_m, point.own_m] })
    }
}

impl PlantEffect for GapVariation {
    fn scale(&mut self, factor: f64) {
        self.sizes_m = self.sizes_m.map(|size| size * factor);
        self.gap_m *= factor;
    }

    fn displacement_m(&mut self, at: &Instant, points: &[SegmentPoint; SEGMENTS]) -> [f64; SEGMENTS] {
        core::array::from_fn(|s| {
            let shape = self.shapes[s].at(points[s].own_m / at.geometry.pitch_m);
            self.sizes_m[s] * self.gap(at, s, &points[s]) * shape
        })
    }

    fn signal(&mut self, at: &Instant, signals: &mut [Signal; SEGMENTS]) {
        let points = at.geometry.points(at.pose);
        for (s, signal) in signals.iter_mut().enumerate() {
            let level = (-at.geometry.wavenumber() * self.gap_m * self.gap(at, s, &points[s])).exp();
            signal.sine *= level;
            signal.cosine *= level;
        }
    }
}

// --- sensor side: the amplitude, and where it is not known the place, times harmonics ---

/// What a sensor can know of it: shares nothing with the plant side above.
pub mod sensor_side {
    use crate::identity::Factor;
    use crate::sensor::{Covariates, Regressor, BasisInputs};

    /// Prior size of the first order's change over the recording, m: a gap that varies by a tenth changes equation (3)'s
    /// 16 µm by that share.
    const SIZE_M: f64 = 2.0e-6;
    /// The same where only a place is known, over which the gap need not change evenly, m.
    const PLACE_SIZE_M: f64 = 1.5e-6;
    /// Orders of the own phase, and their prior size as a part of the first one's.
    const ORDERS: [(usize, f64); 6] = [(1, 1.0), (2, 1.0), (3, 0.5), (4, 0.5), (5, 0.2), (6, 0.3)];
    /// The first so many change with the square as well: what an offset does beside a smaller amplitude, and a third harmonic.
    const BENT: usize = 2;

    /// Those that equation (3) lacks at any gap: what an offset makes of its even orders, and the square of a third harmonic.
    const LACKED: [(usize, f64); 4] = [(3, 0.5), (5, 0.4), (7, 0.2), (8, 0.2)];

    /// Sensor side: low orders of the own phase that grow with the logarithm of the amplitude, as far as the place explains it:
    /// what changes the amplitude within a tooth, or with time at one place, is no gap.
    pub fn regressors(inputs: &BasisInputs) -> Vec<Regressor> {
        let mut list = Vec::new();
        for s in (0..4).filter(|s| inputs.segments[*s]) {
            // The amplitude tells a gap; a place does not, and what grows with it alike on a whole tooth is a pitch, not a gap.
            let by_amplitude = inputs.counts && inputs.amplitude_by_place[s];
            if inputs.gap_told {
                for (order, part) in LACKED {
                    Regressor::harmonic(&mut list, s, order, ("normal amplitude, ", "m", part * SIZE_M), |_| 1.0);
                }
            }
            let mut family = |(label, unit, size_m, kind): (&str, _, f64, Factor), orders: &[(usize, f64)], factor: fn(&Covariates, usize) -> f64| {
                if by_amplitude {
                    let name = format!("{label}offset, segment {}", s + 1);
                    list.push(Regressor::reading(name, unit, size_m, s, move |m| {
                        factor(m, s)
                    }));
                }
                for (order, part) in orders {
                    let size_m = part * size_m;
                    Regressor::harmonic(&mut list, s, *order, (label, unit, size_m, kind), move |m| {
                        factor(m, s)
                    });
                }
            };
            if by_amplitude {
                family(("amplitude times ", "m", SIZE_M, Factor::Amplitude), &ORDERS, |m, s| m.ln_amplitude[s]);
                // The error is a smooth function of the gap, and straight over small changes of it only. Of the higher orders the
                // bend is below a hundredth of a micrometre: freely fitted it stands for what equation (3) lacks, and another
                // recording shows it.
                family(("square of amplitude times ", "m", 0.1 * SIZE_M, Factor::Other), &ORDERS[..BENT], |m, s| m.ln_amplitude[s].powi(2));
            } else if !inputs.counts && inputs.travel_m[s] > 3.0 * inputs.pitch_m {
                family(("place along times ", "1", PLACE_SIZE_M, Factor::Place), &ORDERS, |m, s| m.from_middle_m[s % 2]);
                family(("place across times ", "1", PLACE_SIZE_M, Factor::Place), &ORDERS, |m, s| m.from_middle_m[1 - s % 2]);
            }
        }
        list
    }
}

// --- what is known of it ---

use crate::effect::{Card, Confusable, Effect, Subsumption, KnownBy, Quantity, Recordings};
use crate::identity::{Factor, Identity};
use crate::sensor::{Regressor, BasisInputs};

/// The effect.
pub struct Definition;

/// Its card.
pub static CARD: Card = Card {
    name: "gap_variation",
    summary: "platen flatness or tilt changes amplitude, and the error with it",
    sizes: "2 µm for the first order's change over the recording: a gap that varies by a tenth changes equation (3)'s 16 µm by that share; 1.5 µm where only a place is known",
    telling_motion: "fly-bys over the whole platen with raw counts, so that the amplitude is seen beside the error",
    recordings: Recordings::Apart,
    follows: Quantity::Amplitude,
    coordinate: "signal amplitude",
    carries_over: "its amounts, within the amplitudes that were seen",
    by_amplitude: true,
    // An offset makes further orders of equation (3)'s, and a gap shows the offset.
    subsumes: &[Subsumption { other: "extra_harmonics", tell: &[|inputs| inputs.gap_told = true], known_by: KnownBy::MixedHarmonics }],
    confusable: &[
        Confusable { with: "extra_harmonics", parted_by: "an offset makes further orders of equation (3)'s: fly-bys over the platen with raw counts show whether they change with the amplitude" },
        Confusable { with: "angle_dependence", parted_by: "a gap that tilts goes with the angle: raw counts show whether the amplitude changes with it" },
    ],
    ..Card::PLAIN
};

impl Effect for Definition {
    fn card(&self) -> &'static Card {
        &CARD
    }

    fn draw(&self, scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        GapVariation::draw(scene, rng, size_rms_m)
    }

    fn shapes(&self, inputs: &BasisInputs) -> Vec<Regressor> {
        sensor_side::regressors(inputs)
    }

    fn coordinate(&self, amount: &Regressor) -> String {
        match amount.identity {
            Some(Identity::Wave(wave)) if wave.factor == Factor::Place => "place on the platen and own tooth phase".into(),
            _ => CARD.coordinate.into(),
        }
    }
}
