//! `tooth_variation`: single teeth of the platen are displaced.
//!
//! Each post of the platen is off by its own amount in x and in y; a segment reads the mean of the posts under it. Lines
//! may be displaced as a whole besides: that part is common to a pair and cancels in the parity.

// --- plant side: from the true pose to a displacement ---

use crate::plant::{Geometry, Instant, PlantEffect, SEGMENTS, Scene, SegmentPoint};
use crate::random::{ChaCha8Rng, normal, uniform};
use crate::shape::root_mean_square;

/// Teeth of the table in each direction; it repeats beyond (130 mm: no recording goes around it). Derived from the pitch: 128 of
/// 1.016 mm.
const TEETH: usize = 128;

/// One direction's displacements: `[tooth along][tooth across]`, and each line's own.
struct Field {
    posts_m: Vec<f64>,
    lines_m: Vec<f64>,
}

/// Plant side. Size: rms of a segment's reading over the platen, averaged as a segment averages.
pub struct ToothVariation {
    fields: [Field; 2],
    /// Half of the aperture along and across, pitches.
    half: [f64; 2],
}

impl ToothVariation {
    /// Posts independent of each other; an aperture of five to seven teeth either way; lines carry up to a third of the power.
    pub fn draw(scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let half = [uniform(rng, 2.5, 3.5), uniform(rng, 2.5, 3.5)];
        let line_share = uniform(rng, 0.0, 0.33);
        Box::new(Self::new(&scene.geometry, rng, half, [1.0 - line_share, line_share], size_rms_m))
    }

    /// A stated aperture (half lengths along and across, pitches) and shares of power of single posts and whole lines,
    /// which sum to one.
    pub fn new(geometry: &Geometry, rng: &mut ChaCha8Rng, half: [f64; 2], shares: [f64; 2], size_rms_m: f64) -> Self {
        let mut field = || Field {
            posts_m: (0..TEETH * TEETH).map(|_| normal(rng)).collect(),
            lines_m: (0..TEETH).map(|_| normal(rng)).collect(),
        };
        let mut effect = Self { fields: [field(), field()], half };
        for part in 0..2 {
            let rms = effect.rms(geometry, part);
            let factor = size_rms_m * shares[part].sqrt() / rms;
            for field in &mut effect.fields {
                let values = if part == 0 { &mut field.posts_m } else { &mut field.lines_m };
                values.iter_mut().for_each(|v| *v *= factor);
            }
        }
        effect
    }

    /// Rms over the platen of the posts' (0) or the lines' (1) part.
    fn rms(&self, geometry: &Geometry, part: usize) -> f64 {
        let pitch_m = geometry.pitch_m;
        let place = |i: usize, step: f64| (i as f64 * step).fract() * TEETH as f64 * pitch_m;
        let value = |i: usize| self.parts_m(i % 2, place(i, 0.618_034), place(i, 0.754_878), pitch_m)[part];
        root_mean_square(&(0..8000).map(value).collect::<Vec<_>>())
    }

    /// The posts' and the lines' part of a reading, metres.
    fn parts_m(&self, direction: usize, own_m: f64, across_m: f64, pitch_m: f64) -> [f64; 2] {
        let field = &self.fields[direction];
        let (along, across) = (Window::new(own_m / pitch_m, self.half[0]), Window::new(across_m / pitch_m, self.half[1]));
        let (mut posts, mut lines) = (0.0, 0.0);
        for (tooth, weight) in along.teeth() {
            let row = &field.posts_m[tooth * TEETH..][..TEETH];
            posts += weight * across.teeth().map(|(t, w)| w * row[t]).sum::<f64>();
            lines += weight * field.lines_m[tooth];
        }
        [posts / (along.sum * across.sum), lines / along.sum]
    }

    /// A segment's reading of the field at a place, metres.
    #[must_use]
    pub fn at_m(&self, geometry: &Geometry, segment: usize, point: &SegmentPoint) -> f64 {
        let across_m = point.across_m + geometry.across_offset_m(segment);
        let [posts, lines] = self.parts_m(segment % 2, point.own_m, across_m, geometry.pitch_m);
        posts + lines
    }
}

/// Weights of the teeth under an aperture: smooth to its edges, as fringing fields are.
struct Window {
    first: i64,
    weights: [f64; 8],
    count: usize,
    sum: f64,
}

impl Window {
    fn new(centre: f64, half: f64) -> Self {
        let first = (centre - half).ceil() as i64;
        let last = (centre + half).floor() as i64;
        let mut window = Self { first, weights: [0.0; 8], count: 0, sum: 0.0 };
        for (weight, tooth) in window.weights.iter_mut().zip(first..=last) {
            let u = (tooth as f64 - centre) / half;
            *weight = (1.0 - u * u).powi(2);
            window.count += 1;
            window.sum += *weight;
        }
        window
    }

    fn teeth(&self) -> impl Iterator<Item = (usize, f64)> {
        let weights = self.weights[..self.count].iter().zip(self.first..);
        weights.map(|(&weight, tooth)| (tooth.rem_euclid(TEETH as i64) as usize, weight))
    }
}

impl PlantEffect for ToothVariation {
    fn scale(&mut self, factor: f64) {
        for field in &mut self.fields {
            field.posts_m.iter_mut().chain(&mut field.lines_m).for_each(|d| *d *= factor);
        }
    }

    fn displacement_m(&mut self, at: &Instant, points: &[SegmentPoint; SEGMENTS]) -> [f64; SEGMENTS] {
        core::array::from_fn(|s| self.at_m(at.geometry, s, &points[s]))
    }
}

// --- sensor side: a field over the platen ---

/// What a sensor can know of it: shares nothing with the plant side above.
pub mod sensor_side {
    use crate::over::{Over, Seat};
    use crate::sensor::{Covariates, Regressor, BasisInputs};
    use crate::tooth_regressors::tooth_regressors;
    use tooth_field::values::{between, innovations};
    use tooth_field::{Kernel, Lattice, MeshKernel};

    /// Prior size of the field, rms m: 1.9 µm have been measured on the paper's platen over seven teeth (section 4), and half as
    /// much again may lie over a wider one.
    const SIZE_M: f64 = 3.0e-6;
    /// The same where a sensor reads one pole pair of a ring at a time, of a pole pair. A prior: rings are magnetised pole by pole, to some
    /// percent of a pole.
    const OF_ONE_TOOTH: f64 = 0.01;

    /// How far a reading averages, and the prior size of its field, m rms.
    fn aperture(inputs: &BasisInputs) -> (MeshKernel, f64) {
        let kernel = inputs.forms.field_kernel(inputs.knot_step_m / inputs.pitch_m);
        if inputs.forms.single_teeth.is_some() {
            (kernel, OF_ONE_TOOTH * inputs.pitch_m)
        } else {
            (kernel, SIZE_M)
        }
    }

    /// Most values along one side of a rectangle. A bound on the work: of a longer side, half a metre of teeth, no more are asked
    /// for.
    const LONGEST: usize = 512;

    /// A segment's field by its values on a rectangle of the mesh, `from` one corner `to` the other.
    fn by_value(inputs: &BasisInputs, s: usize, from: [i32; 2], to: [i32; 2], list: &mut Vec<Regressor>) {
        let step_m = inputs.knot_step_m;
        let (kernel, size_m) = aperture(inputs);
        let [along, across] = [0, 1].map(|d| {
            let count = to[d].saturating_sub(from[d]).saturating_add(1);
            innovations(&kernel, usize::try_from(count).unwrap_or(0).min(LONGEST))
        });
        for (i, along) in along.iter().enumerate() {
            for (j, across) in across.iter().enumerate() {
                let (i, j) = (from[0] + i as i32, from[1] + j as i32);
                let (along, across) = (along.clone(), across.clone());
                let value = move |m: &Covariates| {
                    let place = |d: usize| m.place_m[s][d] / step_m - f64::from(from[d]);
                    between(&along, place(0)) * between(&across, place(1))
                };
                let name = format!("value {i} along, {j} across, segment {}", s + 1);
                list.push(Regressor::reading(name, "m", size_m, s, value).of_deviation(size_m));
            }
        }
    }

    /// Sensor side: displacements of single teeth (of groups of them, where the courier went far), each seen as far as a
    /// segment's aperture reaches. Each segment has a field at its own place. Over a wide range that would be too many
    /// unknowns: what the teeth under the four segments add to g_p, g_x and g_y hardly depends on the angle, so it is a
    /// field over the centre for each of these there.
    ///
    /// That the displacements are independent and the aperture is known makes the field smooth over some teeth beforehand:
    /// where it was passed once, its neighbours are told as well, and a wave of few teeth is no such field.
    ///
    /// Where the courier went over a few teeth only, the teeth at the edges of its aperture are many more than what can be told
    /// of them: there the unknowns are the field's values on a rectangle of the mesh, and the aperture gives their correlation.
    pub fn regressors(inputs: &BasisInputs) -> Vec<Regressor> {
        if let Some(teeth) = &inputs.teeth {
            return tooth_regressors(teeth, inputs.pitch_m, SIZE_M);
        }
        let mut list = Vec::new();
        let (step_m, pitch_m) = (inputs.knot_step_m, inputs.pitch_m);
        if step_m <= 0.0 {
            return list;
        }
        let (kernel, size_m) = aperture(inputs);
        let forms = inputs.forms;
        let lattice = Lattice { kernel, step_pitches: [kernel.step_pitches; 2] };
        // Independent displacements add up to the field's size.
        let deviation_m = size_m / lattice.deviation_by_nodes();
        let reach_m = kernel.half_pitches(0) * pitch_m;
        let seen = move |place_m: [f64; 2], node| lattice.weight(node, place_m.map(|p| p / pitch_m));
        for s in 0..4 {
            if inputs.field_by_value {
                if let (Some(from), Some(to)) = (inputs.knots[s].first(), inputs.knots[s].last()) {
                    by_value(inputs, s, *from, *to, &mut list);
                }
                continue;
            }
            for &node in &inputs.knots[s] {
                let [i, j] = node;
                let one = if inputs.reference || inputs.field_by_segment {
                    let name = format!("node {i} along, {j} across, segment {}", s + 1);
                    Regressor::reading(name, "m", size_m, s, move |m| seen(forms.field_place_m(m.place_m[s], pitch_m), node))
                } else {
                    let name = format!("node {i} along x, {j} along y, {}", ["g_p", "g_x", "g_y", ""][s]);
                    Regressor::channel(name, "m", size_m, s, move |m| seen(m.centre_m, node))
                };
                let seat = if inputs.reference || inputs.field_by_segment { Seat::Segment(s) } else { Seat::Centre };
                let over = Over::about(seat, node.map(|n| f64::from(n) * step_m), [reach_m; 2]);
                let one = one.of_deviation(deviation_m);
                // Of a row it is not told where it lies across, and a ring's come round again.
                let everywhere = forms.single_teeth.is_some();
                list.push(if everywhere { one } else { one.only_over(over) });
            }
        }
        list
    }
}

// --- what is known of it ---

use crate::effect::{Card, Confusable, Effect, Detection, Nature, ColumnOrder, Quantity, Recordings};
use crate::sensor::{Regressor, BasisInputs};

/// The effect.
pub struct Definition;

/// Its card.
pub static CARD: Card = Card {
    name: "tooth_variation",
    summary: "single teeth of the platen are displaced",
    sizes: "3 µm rms of a segment's reading: 1.9 µm of each tooth in the paper's section 4, and more on platens that were not chosen; a hundredth of a pole pair where a sensor reads one pole of a ring at a time",
    telling_motion: "dense poses over the same teeth, there and back, so that each place is passed several times",
    recordings: Recordings::Apart,
    detection: Detection::AsField,
    order: ColumnOrder::Last,
    follows: Quantity::PlaceOnPlaten,
    coordinate: "place on the platen",
    carries_over: "the teeth that were passed; of others nothing is known",
    nature: Nature::Flexible,
    rigid: true,
    confusable: &[
        Confusable { with: "lateral_dependence", parted_by: "both are patterns across the teeth: what comes back at other teeth is the segment's; poses over other teeth tell" },
        Confusable { with: "axis_skew", parted_by: "both go with the place: rulings askew are straight over the whole platen; fly-bys over a wide range tell" },
    ],
    ..Card::PLAIN
};

impl Effect for Definition {
    fn card(&self) -> &'static Card {
        &CARD
    }

    fn draw(&self, scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        ToothVariation::draw(scene, rng, size_rms_m)
    }

    fn shapes(&self, inputs: &BasisInputs) -> Vec<Regressor> {
        sensor_side::regressors(inputs)
    }
}
