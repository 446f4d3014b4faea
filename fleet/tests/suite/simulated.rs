//! A courier of the make at rest under its beacon, pose after pose.

use courier_sensor::frame::SEGMENTS;
use effects::axis_skew::AxisSkew;
use effects::motion::Pose;
use effects::plant::{Geometry, Instant, PlantEffect, SegmentPoint};
use fleet::{Member, Platen};
use hal_sim::coordination::{origin_under, pose_under};
use hal_sim::courier::Courier;
use hal_sim::presets::of_the_make;
use hal_sim::spec::CourierSpec;
use rand_chacha::ChaCha8Rng;
use rand_chacha::rand_core::SeedableRng;
use rand_distr::{Distribution, Uniform};
use std::f64::consts::TAU;
use tooth_map::{Rulings, Setup, TeethPose};

/// Samples of a standstill, and the angle either way.
const SAMPLES: u32 = 16;
const TURN_RAD: f64 = 0.026;

/// A recording of a courier over a platen: poses within so many pitches of the beacon, in the count that begins where the courier was switched
/// on.
pub fn member(courier: u64, platen: u64, seed: u64, poses: usize, reach_pitches: f64) -> Member {
    of_spec(
        of_the_make(Some(courier), Some(platen)),
        [courier, platen, seed],
        poses,
        [[-reach_pitches, reach_pitches]; 2],
    )
}

/// The same along a strip of the platen about a place so many pitches along x from the beacon, which is seen from ten centimetres away. The courier is a
/// small one: a wider strip would have more nodes than a recording may.
pub fn along_a_strip(
    [courier, platen, seed]: [u64; 3],
    poses: usize,
    about_pitches: f64,
) -> Member {
    let mut spec = of_the_make(Some(courier), Some(platen));
    let smaller_m = spec.nominal.span_m - STRIP_SPAN_M;
    for geometry in [&mut spec.geometry, &mut spec.nominal] {
        geometry.span_m -= smaller_m;
        geometry.lever_m[0] -= STRIP_ARM_SHORTER_M;
        geometry.tan_full_scale = 2.0;
    }
    let [along, across] = STRIP_PITCHES;
    let along = [about_pitches - along, about_pitches + along];
    of_spec(
        spec,
        [courier, platen, seed],
        poses,
        [along, [-across, across]],
    )
}

/// Spans of the couriers of a strip.
const STRIP_SPAN_M: f64 = 4.0e-3;
/// How much shorter their lever arms are: turns about a beacon widen a strip.
const STRIP_ARM_SHORTER_M: f64 = 60.0e-3;
/// How far their poses reach from its middle along x and y.
const STRIP_PITCHES: [f64; 2] = [42.0, 0.3];

/// The same of another make: its segments read a quarter more of the teeth along their direction.
pub fn wider(courier: u64, platen: u64, seed: u64, poses: usize, reach_pitches: f64) -> Member {
    let mut spec = of_the_make(Some(courier), Some(platen));
    let teeth = spec.effects.remove(TEETH);
    spec.effects.insert(TEETH, Box::new(Wider { teeth }));
    of_spec(
        spec,
        [courier, platen, seed],
        poses,
        [[-reach_pitches, reach_pitches]; 2],
    )
}

/// The same over a platen whose rulings are not two equal ones at right angles.
pub fn ruled(
    ruling: AxisSkew,
    [courier, platen, seed]: [u64; 3],
    poses: usize,
    reach_pitches: f64,
) -> Member {
    let mut spec = of_the_make(Some(courier), Some(platen));
    spec.effects.push(Box::new(ruling));
    of_spec(
        spec,
        [courier, platen, seed],
        poses,
        [[-reach_pitches, reach_pitches]; 2],
    )
}

/// The make's displaced teeth among its effects.
const TEETH: usize = 2;

/// Teeth as they are read at three places, the outer ones a pitch aside: of a window of six teeth, whose spread is 1.13 pitches, it makes one of
/// 1.40, a quarter more.
struct Wider {
    teeth: Box<dyn PlantEffect>,
}

impl PlantEffect for Wider {
    fn scale(&mut self, factor: f64) {
        self.teeth.scale(factor);
    }

    fn displacement_m(
        &mut self,
        at: &Instant,
        points: &[SegmentPoint; SEGMENTS],
    ) -> [f64; SEGMENTS] {
        let mut mean_m = [0.0; SEGMENTS];
        for pitches in [-1.0, 0.0, 1.0] {
            let aside_m = pitches * at.geometry.pitch_m;
            let moved = points.map(|point| SegmentPoint {
                own_m: point.own_m + aside_m,
                ..point
            });
            let read_m = self.teeth.displacement_m(at, &moved);
            mean_m
                .iter_mut()
                .zip(read_m)
                .for_each(|(sum, m)| *sum += m / 3.0);
        }
        mean_m
    }
}

fn of_spec(
    spec: CourierSpec,
    [courier, platen, seed]: [u64; 3],
    poses: usize,
    within_pitches: [[f64; 2]; 2],
) -> Member {
    let setup = setup(&spec);
    let pitch_m = spec.geometry.pitch_m;
    let home_teeth = home_teeth(&spec).map(f64::from);
    let origin_m = origin_under(&spec.geometry, spec.beacon_over.expect("a beacon"));
    let geometry = spec.geometry;
    let mut plant = Courier::new(spec, seed).expect("errors with an inverse");
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let within =
        within_pitches.map(|[low, high]| Uniform::new(low * pitch_m, high * pitch_m).unwrap());
    let turn = Uniform::new(-TURN_RAD, TURN_RAD).unwrap();
    let mut time_s = 0.0;
    let all: Vec<TeethPose> = (0..poses)
        .map(|_| {
            let offset_m = within.map(|within| within.sample(&mut rng));
            let pose = pose_under(&geometry, origin_m, offset_m, turn.sample(&mut rng));
            at_rest(&mut plant, pose, &mut time_s, pitch_m, home_teeth)
        })
        .collect();
    let platen = Platen {
        platen_id: format!("platen {platen}"),
        beacon_id: String::new(),
    };
    let name = format!("courier {courier} on {platen}, {seed}");
    Member::of_poses(&name, &format!("courier {courier}"), platen, setup, &all).unwrap()
}

/// The tooth along x and y from which a courier counts: all of its segments begin at the same.
pub fn home_teeth(spec: &CourierSpec) -> [i32; 2] {
    let home = spec.places.scatter_corner;
    [home.x_m, home.y_m].map(|m| (m / spec.geometry.pitch_m).round() as i32)
}

fn setup(spec: &CourierSpec) -> Setup {
    let (nominal, electronics) = (&spec.nominal, &spec.electronics);
    let by_average = 1.0 / f64::from(SAMPLES).sqrt();
    let segment = electronics.quadrature_noise_counts / electronics.amplitude_counts;
    let deflection = 2.0_f64.sqrt() * electronics.psd_noise_counts / electronics.psd_sum_counts;
    Setup {
        pitch_m: nominal.pitch_m,
        span_m: nominal.span_m,
        lateral_m: nominal.lateral_m,
        height_m: nominal.height_m,
        lever_m: nominal.lever_m,
        tan_full_scale: nominal.tan_full_scale,
        rulings: Rulings::default(),
        segment_noise_m: by_average * segment * nominal.pitch_m / TAU,
        displacement_noise_m: by_average * deflection * nominal.height_m * nominal.tan_full_scale,
    }
}

fn at_rest(
    plant: &mut Courier,
    pose: Pose,
    time_s: &mut f64,
    pitch_m: f64,
    home_teeth: [f64; 2],
) -> TeethPose {
    let share = 1.0 / f64::from(SAMPLES);
    let mut mean = TeethPose {
        outputs_m: [0.0; SEGMENTS],
        deflection: [0.0; 2],
    };
    for _ in 0..SAMPLES {
        *time_s += 1.0e-3;
        let sample = plant.counts_at(&pose, *time_s);
        for (s, teeth) in plant.teeth().into_iter().enumerate() {
            let [sine, cosine] = sample.quadrature[s].map(f64::from);
            let turns = f64::from(teeth) + sine.atan2(cosine) / TAU - home_teeth[s % 2];
            mean.outputs_m[s] += share * turns * pitch_m;
        }
        let [xp, xn, yp, yn] = sample.electrodes.map(f64::from);
        mean.deflection[0] += share * (xp - xn) / (xp + xn);
        mean.deflection[1] += share * (yp - yn) / (yp + yn);
    }
    mean
}

/// What the teeth of a platen add to a segment's reading in the middle of a cell, m: the plant's displacement, the other way round. A long wave of its
/// lines is there as well.
pub fn field_m(platen: u64, direction: usize, cell: [i32; 2]) -> f64 {
    let mut spec = of_the_make(None, Some(platen));
    let point = in_the_middle(&spec, direction, cell);
    let geometry = spec.geometry;
    let mut sum_m = 0.0;
    for effect in [0, TEETH] {
        let effect = &mut spec.effects[effect];
        let of_all = at_origin(&geometry, |at| {
            effect.displacement_m(at, &[point; SEGMENTS])
        });
        sum_m += of_all[direction];
    }
    -sum_m
}

/// The same of a platen's rulings.
pub fn ruling_m(ruling: &AxisSkew, direction: usize, cell: [i32; 2]) -> f64 {
    let spec = of_the_make(None, None);
    let point = in_the_middle(&spec, direction, cell);
    let mut points = [point; SEGMENTS];
    let mut ruling = *ruling;
    at_origin(&spec.geometry, |at| ruling.platen(at, &mut points));
    point.own_m - points[direction].own_m
}

/// Across is told from the sensor's centre: the segment of this direction that stands half a span aside.
fn in_the_middle(spec: &CourierSpec, direction: usize, cell: [i32; 2]) -> SegmentPoint {
    let geometry = spec.geometry;
    let place_m = cell.map(|tooth| (f64::from(tooth) + 0.5) * geometry.pitch_m);
    SegmentPoint {
        own_m: place_m[0],
        across_m: place_m[1] - geometry.across_offset_m(direction),
    }
}

fn at_origin<T>(geometry: &Geometry, of: impl FnOnce(&Instant) -> T) -> T {
    let pose = Pose::default();
    of(&Instant {
        time_s: 0.0,
        pose,
        temperature_delta_k: 0.0,
        motion: &pose,
        geometry,
    })
}
