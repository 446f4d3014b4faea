//! `stray_field`: an external field or the drive's own shifts both channels of a pair, by place or with a logged quantity.
//!
//! A magnet, a bar of steel or a current near the platen adds to what the sense coils pick up: an offset of the sine and one of the
//! cosine, of another size in every channel. A source that stands beside the platen changes with the place; the drive's current
//! changes with what the drive does, and is seen where it is logged (a column `aux_…`).

// --- plant side: from ideal to real signals ---

use crate::plant::{Geometry, Instant, PlantEffect, SEGMENTS, Scene, SegmentPoint, Signal};
use crate::random::{ChaCha8Rng, normal, uniform};
use crate::shape::root_mean_square;

/// Sources beside the platen.
const SOURCES: usize = 2;
/// Half of the square over which the size is stated, m. A definition: what a survey goes over.
const RANGE_M: f64 = 30.0e-3;
/// Distance of a source from the sensor's plane, m. A prior: a courier is some 30 mm high, and what is much farther away than the
/// range makes a mean alone.
const DISTANCE_M: [f64; 2] = [40.0e-3, 80.0e-3];

/// A source: where it stands over the platen, and how far from the sensor's plane.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Source {
    place_m: [f64; 2],
    distance_m: f64,
}

impl Source {
    fn draw(rng: &mut ChaCha8Rng) -> Self {
        let mut along = || uniform(rng, -2.0 * RANGE_M, 2.0 * RANGE_M);
        let place_m = [along(), along()];
        let distance_m = uniform(rng, DISTANCE_M[0], DISTANCE_M[1]);
        Self { place_m, distance_m }
    }

    /// Field of a dipole that points at the platen, over its strongest.
    fn field(&self, place_m: [f64; 2]) -> f64 {
        let [x, y] = [0, 1].map(|d| (place_m[d] - self.place_m[d]) / self.distance_m);
        let away = 1.0 + x * x + y * y;
        (2.0 - x * x - y * y) / (2.0 * away.powf(2.5))
    }
}

/// Plant side. Size: rms of the displacement over the own phase and the places within ±30 mm, pooled over the segments, about the
/// offsets' means there: those are a pair's own, which equation (3) holds.
#[derive(Clone, Debug, PartialEq)]
pub struct StrayField {
    sources: [Source; SOURCES],
    /// What each source does to the sine and the cosine of each segment, of the amplitude.
    pulls: [[[f64; SOURCES]; 2]; SEGMENTS],
    /// Mean of each source's field.
    means: [f64; SOURCES],
}

impl StrayField {
    /// Sources beside the platen or over it; every channel picks them up by its own share.
    pub fn draw(scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        let sources = [(); SOURCES].map(|()| Source::draw(rng));
        let pulls = [(); SEGMENTS].map(|()| [(); 2].map(|()| [(); SOURCES].map(|()| normal(rng))));
        let means = sources.map(|source| {
            let all = places().map(|place_m| source.field(place_m));
            all.sum::<f64>() / places().count() as f64
        });
        let mut effect = Self { sources, pulls, means };
        let all: Vec<f64> = (0..SEGMENTS)
            .flat_map(|s| places().map(move |place_m| (s, place_m)))
            .flat_map(|(s, place_m)| effect.offsets(s, place_m))
            .collect();
        // An offset turns the pair by itself times the cosine of the phase, or the sine.
        let rms_rad = root_mean_square(&all);
        effect.scale(size_rms_m * scene.geometry.wavenumber() / rms_rad.max(1.0e-12));
        Box::new(effect)
    }

    /// Offsets of a segment's sine and cosine at a place of the platen, of the amplitude.
    fn offsets(&self, segment: usize, place_m: [f64; 2]) -> [f64; 2] {
        let fields: [f64; SOURCES] = core::array::from_fn(|j| self.sources[j].field(place_m) - self.means[j]);
        self.pulls[segment].map(|pulls| pulls.iter().zip(fields).map(|(pull, field)| pull * field).sum())
    }
}

/// Places over the square that the size is stated over.
fn places() -> impl Iterator<Item = [f64; 2]> {
    let at = |k: i32| RANGE_M * (f64::from(k) + 0.5) / 20.0;
    (-20..20).flat_map(move |i| (-20..20).map(move |j| [at(i), at(j)]))
}

/// Where a segment is on the platen.
fn place_m(geometry: &Geometry, segment: usize, point: &SegmentPoint) -> [f64; 2] {
    let across_m = point.across_m + geometry.across_offset_m(segment);
    // Segments 0 and 2 run along x, 1 and 3 along y.
    if segment % 2 == 0 { [point.own_m, across_m] } else { [across_m, point.own_m] }
}

impl PlantEffect for StrayField {
    fn scale(&mut self, factor: f64) {
        self.pulls.iter_mut().flatten().flatten().for_each(|pull| *pull *= factor);
    }

    fn signal(&mut self, at: &Instant, signals: &mut [Signal; SEGMENTS]) {
        let points = at.geometry.points(at.pose);
        for (s, signal) in signals.iter_mut().enumerate() {
            let [sine, cosine] = self.offsets(s, place_m(at.geometry, s, &points[s]));
            signal.sine += sine;
            signal.cosine += cosine;
        }
    }
}

/// Current of a driver that holds the courier, A, and what it adds in motion. A prior: to lower the current at rest is the usual
/// way to keep a motor cool.
const HOLD_A: f64 = 0.5;
/// See [`HOLD_A`].
const RUN_A: f64 = 0.7;
/// Speed at which half of that is added, m/s. A prior: below it nobody would say that it moves.
const RUN_M_S: f64 = 1.0e-3;
/// Courier's mass over the motor's force for an ampere, A s²/m. A prior: half a kilogram at 10 N/A.
const INERTIA_A_S2_PER_M: f64 = 0.05;
/// The same of the force by eddy currents, A s/m. A prior: 10 N s/m at 10 N/A.
const DRAG_A_S_PER_M: f64 = 1.0;
/// Half of the time over which a change of speed is an acceleration, s. A prior: a driver's own filter is some hundred hertz
/// wide.
const HALF_STEP_S: f64 = 1.0e-3;
/// What the driver's own measurement resolves, steps an ampere. A prior: ten bits over 5 A.
const STEPS_AN_AMPERE: f64 = 200.0;
/// Column that it is logged in.
const COLUMN: &str = "aux_motor_a";

/// Plant side, of the drive's own field: offsets in proportion to its current, which is logged. Size: rms of the displacement over the own
/// phase for a change of the current by one ampere, pooled over the segments.
#[derive(Clone, Debug, PartialEq)]
pub struct DriveField {
    /// What an ampere does to the sine and the cosine of each segment, of the amplitude.
    pulls: [[f64; 2]; SEGMENTS],
}

impl DriveField {
    /// Every channel picks the field up by its own share.
    pub fn draw(scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Self {
        let pulls = [(); SEGMENTS].map(|()| [(); 2].map(|()| normal(rng)));
        let rms_rad = root_mean_square(pulls.as_flattened());
        let mut effect = Self { pulls };
        effect.scale(size_rms_m * scene.geometry.wavenumber() / rms_rad.max(1.0e-12));
        effect
    }

    /// Current of the drive, A: held at rest, more in motion, and what mass and eddy currents ask for.
    fn current_a(at: &Instant) -> f64 {
        let velocity = |time_s: f64| {
            let v = at.motion.velocity(time_s);
            [v.x_m, v.y_m]
        };
        let length = |v: [f64; 2]| v[0].hypot(v[1]);
        let [before, now, after] = [-HALF_STEP_S, 0.0, HALF_STEP_S].map(|step| velocity(at.time_s + step));
        let acceleration = [0, 1].map(|d| 0.5 * (after[d] - before[d]) / HALF_STEP_S);
        let speed_m_s = length(now);
        HOLD_A + RUN_A * speed_m_s / (speed_m_s + RUN_M_S) + DRAG_A_S_PER_M * speed_m_s + INERTIA_A_S2_PER_M * length(acceleration)
    }
}

impl PlantEffect for DriveField {
    fn scale(&mut self, factor: f64) {
        self.pulls.iter_mut().flatten().for_each(|pull| *pull *= factor);
    }

    fn signal(&mut self, at: &Instant, signals: &mut [Signal; SEGMENTS]) {
        // What the usual current of a motion does is a pair's own, which equation (3) holds: in motion a sensor is calibrated.
        let more_a = Self::current_a(at) - HOLD_A - RUN_A;
        for (signal, [sine, cosine]) in signals.iter_mut().zip(self.pulls) {
            signal.sine += sine * more_a;
            signal.cosine += cosine * more_a;
        }
    }

    fn logged(&self, at: &Instant) -> Option<(&'static str, f64)> {
        Some((COLUMN, (Self::current_a(at) * STEPS_AN_AMPERE).round() / STEPS_AN_AMPERE))
    }
}

// --- sensor side: order one of the own phase that changes with the place, or with a logged column ---

/// What a sensor can know of it: shares nothing with the plant side above.
pub mod sensor_side {
    use crate::basis::legendre;
    use crate::identity::{Factor, Identity, Part, Wave};
    use crate::sensor::{MOST_LOGGED, Covariates, Regressor, BasisInputs};
    use core::f64::consts::TAU;

    /// Prior deviation of an offset's change, of the amplitude: offsets of 0.3 to 0.5 % are usual (ESS resolver), and 6 % has been seen
    /// in one axis (lib_sincos_enc). 1 % makes 1.6 µm at a pitch of 1 mm.
    const SHARE: f64 = 0.01;
    /// Highest degree of its course over the places. As was measured on 2,000 drawn sources, five leave 0.7 % of the field over
    /// ±30 mm in the median, and 2.6 % or less of 95 in 100; three leave 6 % and 14 %.
    const DEGREE: usize = 5;
    /// Half ranges from the middle beyond which a course is not carried on: segments sit to either side of the sensor's centre,
    /// of which the range is. A prior: a polynomial of fifth degree says nothing farther out.
    const BEYOND: f64 = 1.5;
    /// Each degree has this share of the one before: a source's field falls off over its distance, which is more than half of the
    /// range. As was measured on 2,000 drawn sources: the rms of their coefficients falls by 0.66 from degree to degree.
    const FALL: f64 = 0.6;

    /// Sensor side: for each segment whose counts show it, offsets of sine and cosine that are smooth functions of the segment's place;
    /// and for each logged column offsets in proportion to it.
    pub fn regressors(inputs: &BasisInputs) -> Vec<Regressor> {
        let mut list = Vec::new();
        let metres = inputs.pitch_m / TAU;
        for s in (0..4).filter(|s| inputs.segments[*s]) {
            for (k, column) in inputs.logged.iter().enumerate().take(MOST_LOGGED) {
                let told = format!("with {}", column.name);
                both(&mut list, s, (&told, metres, SHARE, Factor::Logged), move |m| m.logged[k]);
            }
            if !inputs.offsets_by_place[s] {
                continue;
            }
            for (along, across) in degrees() {
                let range = Range::of(inputs, s);
                let told = format!("over the place, degree {along} along, {across} across");
                let share = SHARE * FALL.powi((along + across) as i32 - 1);
                both(&mut list, s, (&told, metres, share, Factor::Place), move |m| {
                    let [a, b] = range.within(m.place_m[s]);
                    legendre(along, a) * legendre(across, b)
                });
            }
        }
        list
    }

    /// Degrees along and across whose sum is 1 to the highest: of degree zero equation (3) has an offset.
    fn degrees() -> impl Iterator<Item = (usize, usize)> {
        (1..=DEGREE).flat_map(|sum| (0..=sum).map(move |along| (along, sum - along)))
    }

    /// Middle and half range of a segment's places along and across.
    #[derive(Clone, Copy)]
    struct Range {
        middle_m: [f64; 2],
        half_m: [f64; 2],
    }

    impl Range {
        fn of(inputs: &BasisInputs, segment: usize) -> Self {
            let axes = [segment % 2, 1 - segment % 2];
            Self {
                middle_m: axes.map(|axis| inputs.middle_m[axis]),
                half_m: axes.map(|axis| 0.5 * inputs.travel_m[axis].max(inputs.pitch_m)),
            }
        }

        /// Places about from -1 to 1: far beyond the range nothing goes on.
        fn within(&self, place_m: [f64; 2]) -> [f64; 2] {
            core::array::from_fn(|d| ((place_m[d] - self.middle_m[d]) / self.half_m[d]).clamp(-BEYOND, BEYOND))
        }
    }

    /// An offset of the sine and one of the cosine: what must be added to the reading.
    fn both(
        list: &mut Vec<Regressor>,
        segment: usize,
        (told, metres, share, factor): (&str, f64, f64, Factor),
        course: impl Fn(&Covariates) -> f64 + Send + Sync + Clone + 'static,
    ) {
        for (channel, part, sign) in [("sine", Part::Cosine, -1.0), ("cosine", Part::Sine, 1.0)] {
            let name = format!("offset of {channel} {told}, segment {}", segment + 1);
            let course = course.clone();
            // The sine of the angle by which offsets turn a pair is this of the phase that is measured, to every order. Equation (3)
            // holds of the pair without them, so that its slope is told with them: its bend makes less than a hundredth of a micrometre.
            let value = move |m: &Covariates| sign * metres * course(m) * m.calibration_gain[segment] * part.of(m.raw_phase[segment].sin_cos());
            let wave = Wave { segment, own_order: 1, lateral_order: 0, part, factor };
            let one = Regressor::reading(name, "of amplitude", share * metres, segment, value);
            list.push(one.of_deviation(share).identified(Identity::Wave(wave)));
        }
    }
}

// --- what is known of it ---

use crate::effect::{Card, Confusable, Effect, Need, Quantity, Recordings};
use crate::identity::{Factor, Identity};
use crate::sensor::{Regressor, BasisInputs};

/// The effect.
pub struct Definition;

/// Its card.
pub static CARD: Card = Card {
    name: "stray_field",
    summary: "an external field or the drive's own shifts both channels of a pair, by place or with a logged column",
    sizes: "1 % of the amplitude, 1.6 µm at a pitch of 1 mm: offsets of 0.3 to 0.5 % are usual (ESS resolver) and 6 % has been seen (lib_sincos_enc); a drive of 3 A made less than 0.28 µm (StepperServoCAN issue 21, scaled)",
    telling_motion: "fly-bys over the same places at different times, with raw counts; the drive's current logged beside them as a column aux_… tells the drive's own field",
    recordings: Recordings::Apart,
    needs: &[Need::CountsOrLogged],
    follows: Quantity::PlaceOnPlaten,
    coordinate: "place on the platen and own tooth phase",
    carries_over: "its amounts, over the places that were passed and for the same logged columns",
    confusable: &[
        Confusable { with: "gap_variation", parted_by: "both change the error with the place: a gap changes both channels alike and the amplitude at every phase, a field shifts them; raw counts tell" },
        Confusable { with: "quadrature_drift", parted_by: "on one way each place has its own time: the same places passed again at another time tell" },
        Confusable { with: "thermal_drift", parted_by: "pairs that warm change their offsets as well: the same places passed again at another temperature tell" },
    ],
    ..Card::PLAIN
};

impl Effect for Definition {
    fn card(&self) -> &'static Card {
        &CARD
    }

    fn draw(&self, scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Box<dyn PlantEffect> {
        StrayField::draw(scene, rng, size_rms_m)
    }

    fn draw_logged(&self, scene: &Scene, rng: &mut ChaCha8Rng, size_rms_m: f64) -> Option<Box<dyn PlantEffect>> {
        Some(Box::new(DriveField::draw(scene, rng, size_rms_m)))
    }

    fn shapes(&self, inputs: &BasisInputs) -> Vec<Regressor> {
        sensor_side::regressors(inputs)
    }

    fn coordinate(&self, amount: &Regressor) -> String {
        match amount.identity {
            Some(Identity::Wave(wave)) if wave.factor == Factor::Logged => "logged column and own tooth phase".into(),
            _ => CARD.coordinate.into(),
        }
    }
}
