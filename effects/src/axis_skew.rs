//! `axis_skew`: the platen's two rulings differ in pitch, or are not square.
//!
//! Both leave the parity alone (a pair shares them, but for an offset) and show against the coordination sensor or a reference. Lines that bend besides
//! show as an angle, and in the parity: a pair's segments cross them half a span to either side.

// --- plant side: where the segments are over the ruling ---

use crate::plant::{Instant, PlantEffect, SEGMENTS, Scene, SegmentPoint};
use crate::random::{ChaCha8Rng, normal};

/// Range at which the size is stated: +-5 mm in x and y. A definition: half of the ten pitches that the paper's self-calibration
/// goes over (3.1.2).
const RANGE_M: f64 = 5.0e-3;

/// Plant side. Size: rms of the displacement over +-5 mm, each segment's less its mean, pooled over the segments.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct AxisSkew {
    /// Angle between the y direction and the lines that segments 1 and 3 cross, radians.
    pub skew_rad: f64,
    /// Pitch of the lines that segments 2 and 4 cross is smaller by this share.
    pub pitch_difference: f64,
    /// Bow of the first lines, 1/m.
    pub bow_per_m: f64,
}

impl AxisSkew {
    /// Both, of random sign and share, and a slight bow of the lines.
    pub fn draw(_scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let (skew, pitch) = (normal(rng), normal(rng));
        let bow = 0.05 * skew / RANGE_M;
        // Rms over the square: mean squares of y and y^2 are R^2/3 and R^4/5; half of the segments see each part. Half a span aside the bow
        // has a slope besides, which makes half a percent of the size.
        let (r2, half) = (RANGE_M * RANGE_M, 0.5);
        let power = half * ((skew * skew + pitch * pitch) * r2 / 3.0 + bow * bow * r2 * r2 / 5.0);
        let unit = size_rms_m / power.sqrt().max(1.0e-12);
        Box::new(Self { skew_rad: skew * unit, pitch_difference: pitch * unit, bow_per_m: bow * unit })
    }
}

impl PlantEffect for AxisSkew {
    fn scale(&mut self, factor: f64) {
        self.skew_rad *= factor;
        self.pitch_difference *= factor;
        self.bow_per_m *= factor;
    }

    fn platen(&mut self, at: &Instant, points: &mut [SegmentPoint; SEGMENTS]) {
        for (s, point) in points.iter_mut().enumerate() {
            // A pair's segments cross the lines half a span to either side.
            let across_m = point.across_m + at.geometry.across_offset_m(s);
            let x_of_lines = |y_m: f64| y_m * (self.skew_rad + self.bow_per_m * y_m);
            // The other ruling's lines tell the place across.
            if s % 2 == 0 {
                point.own_m += x_of_lines(across_m);
                point.across_m += self.pitch_difference * point.across_m;
            } else {
                point.across_m += x_of_lines(point.own_m);
                point.own_m += self.pitch_difference * point.own_m;
            }
        }
    }
}

// --- sensor side: a difference of pitch and a skew of the two rulings ---

/// What a sensor can know of it: shares nothing with the plant side above.
pub mod sensor_side {
    use crate::basis::legendre;
    use crate::sensor::{Covariates, Regressor, BasisInputs};

    /// Size of a bow and of what completes it, m.
    /// A prior: less than the effect itself, and more than the noise.
    const WINDING_M: f64 = 0.4e-6;
    /// Highest order of a winding along the lines' own direction, and of a bow across it.
    const WINDING: [usize; 2] = [5, 3];
    /// Half ranges from the middle beyond which a winding is not carried on. A prior: farther out a polynomial says nothing, and
    /// that of order 5 is there 33 times what it is at the end.
    const BEYOND: f64 = 1.5;

    /// Sensor side: two amounts, and a bow of either's lines; a common scale is the beacon's height. Against a reference pitch and angle of either
    /// ruling show. Lines that were ruled askew may wind as well, by a tenth of that: smooth shapes over the range, no more
    /// than completes the effect, and asked for where it leaves a gap.
    pub fn regressors(inputs: &BasisInputs) -> Vec<Regressor> {
        if inputs.reference {
            return against_reference(inputs);
        }
        if !inputs.lateral || !inputs.segments.iter().all(|s| *s) {
            return Vec::new();
        }
        let mut list = vec![
            Regressor::readings("pitch of x over y", "1", 3.0e-6, |m, out| {
                for s in 0..4 {
                    let sign = if s % 2 == 0 { 0.5 } else { -0.5 };
                    out[s] += sign * m.place_m[s][0];
                }
            }),
            Regressor::readings("out of square", "rad", 3.0e-6, |m, out| {
                for s in [0, 2] {
                    out[s] += m.place_m[s][1];
                }
            }),
        ];
        list.extend((0..2).flat_map(|axis| bent(inputs, axis)));
        list
    }

    /// How the lines of one ruling are no straight ones.
    fn bent(inputs: &BasisInputs, axis: usize) -> Vec<Regressor> {
        let mut list = vec![bend(inputs.middle_m[1 - axis], axis)];
        if inputs.lines_wind {
            list.extend(winding(inputs, axis));
        }
        list
    }

    /// Lines that bend: a pair's segments cross them half a span to either side, so that places across show as an angle.
    fn bend(middle_m: f64, axis: usize) -> Regressor {
        let name = format!("lines of {} bend", ["x", "y"][axis]);
        Regressor::readings(name, "1/m", WINDING_M, move |m, out| {
            for s in [axis, axis + 2] {
                out[s] += (m.place_m[s][1] - middle_m).powi(2);
            }
        })
    }

    /// Legendre polynomials of the lines' place, along their own direction and across it, over the range of the recording.
    fn winding(inputs: &BasisInputs, axis: usize) -> Vec<Regressor> {
        let label = ["x", "y"][axis];
        let middle_m = inputs.middle_m;
        let half_m = [axis, 1 - axis].map(|d| 0.5 * inputs.travel_m[d].max(inputs.pitch_m));
        let along = [axis, 1 - axis];
        let within = move |m: &Covariates, s: usize, direction: usize| {
            let off_m = m.place_m[s][direction] - middle_m[along[direction]];
            (off_m / half_m[direction]).clamp(-BEYOND, BEYOND)
        };
        let mut list = Vec::new();
        for (direction, of) in ["along", "across"].into_iter().enumerate() {
            for order in 2..=WINDING[direction] {
                let name = format!("lines of {label} wind, order {order} {of}");
                list.push(Regressor::readings(name, "m", WINDING_M, move |m, out| {
                    for s in [axis, axis + 2] {
                        out[s] += legendre(order, within(m, s, direction));
                    }
                }));
            }
        }
        let name = format!("lines of {label} spread");
        list.push(Regressor::readings(name, "m", WINDING_M, move |m, out| {
            for s in [axis, axis + 2] {
                out[s] += within(m, s, 0) * within(m, s, 1);
            }
        }));
        list
    }

    /// Travel from which a pitch is told, in pitches. Derived from the correlation of a slope with a wave of order 1, 0.78 over
    /// the number of periods: a quarter.
    const FAR_PITCHES: f64 = 3.0;

    /// The rulings that segments pass, each against the reference, which tells the pitch of either: none is taken up by a beacon's height.
    fn against_reference(inputs: &BasisInputs) -> Vec<Regressor> {
        let mut list = Vec::new();
        for (axis, label) in ["x", "y"].into_iter().enumerate() {
            let of_it: Vec<usize> = [axis, axis + 2]
                .into_iter()
                .filter(|s| inputs.segments[*s] && inputs.travel_m[*s] > FAR_PITCHES * inputs.pitch_m)
                .collect();
            let mut add = |name: String, unit, direction: usize| {
                let of_it = of_it.clone();
                if !of_it.is_empty() {
                    list.push(Regressor::readings(name, unit, 3.0e-6, move |m, out| {
                        for s in &of_it {
                            out[*s] += m.place_m[*s][direction];
                        }
                    }));
                }
            };
            add(format!("pitch of {label}"), "1", 0);
            if inputs.lateral {
                add(format!("lines of {label} turned"), "rad", 1);
                if !of_it.is_empty() {
                    list.extend(bent(inputs, axis));
                }
            }
        }
        list
    }
}

// --- what is known of it ---

use crate::effect::{Acts, Card, Confusable, Effect, Quantity, Recordings};
use crate::sensor::{Regressor, BasisInputs};

/// The effect.
pub struct Definition;

/// Its card.
pub static CARD: Card = Card {
    name: "axis_skew",
    summary: "the platen's two rulings differ in pitch, or are not square",
    sizes: "3 µm over the recording for either, 0.4 µm for a bow of either and for each shape of lines that wind: without data",
    telling_motion: "a known distance by an independent reference along both axes: only it tells the platen's pitch from the diode's gain",
    recordings: Recordings::Apart,
    follows: Quantity::PlaceOnPlaten,
    coordinate: "place on the platen",
    acts: Acts::Teeth,
    rigid: true,
    searched: Some(|inputs| inputs.lines_wind = true),
    confusable: &[
        Confusable { with: "psd_misalignment", parted_by: "a platen's pitch is a diode's gain: only a known distance by an independent reference along both axes tells them apart" },
        Confusable { with: "thermal_drift", parted_by: "a platen that grew has another pitch: recordings at two temperatures tell" },
    ],
    ..Card::PLAIN
};

impl Effect for Definition {
    fn card(&self) -> &'static Card {
        &CARD
    }

    fn draw(&self, scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        AxisSkew::draw(scene, rng, size_rms_m)
    }

    fn shapes(&self, inputs: &BasisInputs) -> Vec<Regressor> {
        sensor_side::regressors(inputs)
    }
}
