//! The tooth map in the interrupt: against its definition in f64, at its edges, and what is refused.
use courier_sensor::frame::{RawFrame, SEGMENTS, Status};
use courier_sensor::geometry::Geometry;
use courier_sensor::settings::{Limits, Settings};
use courier_sensor::step::{StepConfig, StepState, isr_step_mapped, step};
use courier_sensor::teeth::*;
use rand::{RngExt, SeedableRng};
use rand_chacha::ChaCha8Rng;
use std::f64::consts::TAU;

const PITCH: f64 = 1.016e-3;
const SPAN: f64 = 9.7e-3;
const LATERAL: f64 = 3.0e-3;
const NODES: [u8; 2] = [8, 18];

fn header() -> MapHeader {
    let grid = Grid {
        first_teeth: [-4, -9],
        nodes: NODES,
    };
    let mut waves = heapless::Vec::new();
    for (index, (own_order, lateral_order)) in [(0, 2), (1, 1), (1, -1), (2, 1), (2, -1)]
        .into_iter()
        .enumerate()
    {
        let size =
            |segment: usize, part: usize| 1.0e-6 * (1 + index + 2 * segment + 3 * part) as f32;
        waves
            .push(Wave {
                own_order,
                lateral_order,
                coefficients_m: std::array::from_fn(|s| [size(s, 0), -size(s, 1)]),
            })
            .unwrap();
    }
    let mut trusted = heapless::Vec::new();
    trusted.resize(9, u32::MAX).unwrap();
    MapHeader {
        grids: [grid; 2],
        waves,
        trusted,
    }
}

fn filled(header: &MapHeader, seed: u64) -> (ToothMap, Vec<i16>) {
    let mut rng = ChaCha8Rng::seed_from_u64(seed);
    let nodes: Vec<i16> = (0..header.nodes())
        .map(|_| rng.random_range(-8000..=8000))
        .collect();
    let mut map = ToothMap::new();
    map.begin(header, &Geometry::PAPER).unwrap();
    nodes.chunks(100).for_each(|part| map.extend(part).unwrap());
    map.complete().unwrap();
    (map, nodes)
}

fn config() -> StepConfig {
    let limits = Limits {
        frozen_samples: 0,
        ..Limits::default()
    };
    StepConfig::build(&Settings {
        limits,
        ..Settings::default()
    })
    .unwrap()
}

/// Counts of a pose near zero, turns of each segment.
fn raw(turns: [f64; SEGMENTS]) -> RawFrame {
    RawFrame {
        quadrature_counts: turns
            .map(|t| [(TAU * t).sin(), (TAU * t).cos()].map(|v| (20_000.0 * v).round() as i16)),
        ..RawFrame::default()
    }
}

/// Where the segments are, metres: lateral arguments of equation (9), and places across.
fn across(p: &[f64; SEGMENTS]) -> ([f64; SEGMENTS], [f64; SEGMENTS]) {
    let sign = [-1.0, 1.0, 1.0, -1.0];
    let theta = (p[0] - p[2] + p[1] - p[3]) / (2.0 * SPAN);
    let middle = [(p[0] + p[2]) / 2.0, (p[1] + p[3]) / 2.0];
    let lateral = std::array::from_fn(|i| middle[1 - i % 2] + sign[i] * LATERAL * theta);
    let places = std::array::from_fn(|i: usize| lateral[i] + sign[i] * SPAN / 2.0);
    (lateral, places)
}

/// The fields' definition, in f64: Cox and de Boor's recursion instead of the closed cubic.
fn fields_m(header: &MapHeader, nodes: &[i16], p: &[f64; SEGMENTS]) -> [f64; SEGMENTS] {
    fn bspline(degree: i32, x: f64) -> f64 {
        if degree == 0 {
            return if (0.0..1.0).contains(&x) { 1.0 } else { 0.0 };
        }
        let d = f64::from(degree);
        x / d * bspline(degree - 1, x) + (d + 1.0 - x) / d * bspline(degree - 1, x - 1.0)
    }
    let (_, aside) = across(p);
    std::array::from_fn(|i| {
        let place = [p[i] / PITCH, aside[i] / PITCH];
        let grid = &header.grids[i % 2];
        let mut sum = 0.0;
        for a in 0..NODES[0] {
            for b in 0..NODES[1] {
                let at = usize::from(a) * usize::from(NODES[1])
                    + usize::from(b)
                    + (i % 2) * grid.count();
                let weight = |k: usize, n: u8| {
                    bspline(
                        3,
                        place[k] - f64::from(grid.first_teeth[k]) - f64::from(n) + 2.0,
                    )
                };
                sum += 1.0e-9 * f64::from(nodes[at]) * weight(0, a) * weight(1, b);
            }
        }
        sum
    })
}

fn waves_m(header: &MapHeader, p: &[f64; SEGMENTS]) -> [f64; SEGMENTS] {
    let (lateral, _) = across(p);
    std::array::from_fn(|i| {
        let wave = |wave: &Wave| {
            let phase = TAU / PITCH
                * (f64::from(wave.own_order) * p[i] + f64::from(wave.lateral_order) * lateral[i]);
            let [s, c] = wave.coefficients_m[i].map(f64::from);
            s * phase.sin() + c * phase.cos()
        };
        header.waves.iter().map(wave).sum()
    })
}

/// Fields and waves, and by how much the waves change where both have moved the outputs: a difference over a thousandth of that.
fn wanted_m(header: &MapHeader, nodes: &[i16], p: [f64; SEGMENTS]) -> [f64; SEGMENTS] {
    const SHARE: f64 = 1.0e-3;
    let (fields, waves) = (fields_m(header, nodes, &p), waves_m(header, &p));
    let at = |share: f64| {
        let moved = std::array::from_fn(|i| p[i] + share * (fields[i] + waves[i]));
        waves_m(header, &moved)
    };
    let (up, down) = (at(SHARE), at(-SHARE));
    std::array::from_fn(|i| fields[i] + waves[i] + (up[i] - down[i]) / (2.0 * SHARE))
}

#[test]
fn interrupt_adds_what_the_map_says() {
    let header = header();
    let (map, nodes) = filled(&header, 1);
    let config = config();
    let mut rng = ChaCha8Rng::seed_from_u64(2);
    let mut worst = 0.0f64;
    for _ in 0..200 {
        let turns: [f64; SEGMENTS] = std::array::from_fn(|_| rng.random_range(-0.45..0.45));
        let raw = raw(turns);
        let mut state = StepState::new();
        let plain = step(&config, &mut state, &raw);
        let mut state = StepState::new();
        *state.raw_mut() = raw;
        let mapped = *isr_step_mapped(&config, &mut state, &map);
        assert!(!mapped.status.contains(Status::OUTSIDE_MAP));
        let metres = |i: usize| plain.segments[i].calibrated.metres(PITCH as f32);
        let wanted = wanted_m(&header, &nodes, std::array::from_fn(metres));
        for (i, wanted) in wanted.into_iter().enumerate() {
            let added = mapped.segments[i]
                .calibrated
                .minus_turns(plain.segments[i].calibrated);
            worst = worst.max((f64::from(added) * PITCH - wanted).abs());
        }
        let p: [f64; SEGMENTS] =
            std::array::from_fn(|i| mapped.segments[i].calibrated.metres(PITCH as f32));
        assert!((mapped.pose.y.metres(PITCH as f32) - (p[1] + p[3]) / 2.0).abs() < 1.0e-9);
        assert!((f64::from(mapped.parity_m) - (p[0] - p[2] - p[1] + p[3])).abs() < 1.0e-9);
        assert!((f64::from(mapped.pose.theta_y_rad) - (p[1] - p[3]) / SPAN).abs() < 1.0e-7);
    }
    println!(
        "tooth map, f32 in the interrupt against f64: worst {:.3} nm",
        worst * 1e9
    );
    assert!(worst < 1.0e-9);
}

#[test]
fn outside_its_trusted_cells_nothing_is_added_and_the_frame_says_so() {
    let mut header = header();
    header.waves.clear();
    header.grids[1].first_teeth = [100, 100];
    let (map, _) = filled(&header, 3);
    let raw = raw([0.1, 0.2, 0.1, 0.2]);
    let config = config();
    let plain = step(&config, &mut StepState::new(), &raw);
    let run = |map: &ToothMap| {
        let mut state = StepState::new();
        *state.raw_mut() = raw;
        *isr_step_mapped(&config, &mut state, map)
    };
    let frame = run(&map);
    assert!(frame.status.contains(Status::OUTSIDE_MAP));
    assert_eq!(frame.segments[1].calibrated, plain.segments[1].calibrated);
    assert_ne!(frame.segments[0].calibrated, plain.segments[0].calibrated);
    header.trusted.iter_mut().for_each(|word| *word = 0);
    let (map, _) = filled(&header, 3);
    let frame = run(&map);
    assert_eq!(frame.segments[0].calibrated, plain.segments[0].calibrated);
    assert!(frame.status.contains(Status::OUTSIDE_MAP));
}

#[test]
fn maps_that_cannot_be_used_are_refused_by_name() {
    let refused = |change: &dyn Fn(&mut MapHeader)| {
        let mut header = header();
        change(&mut header);
        ToothMap::new()
            .begin(&header, &Geometry::PAPER)
            .unwrap_err()
            .to_string()
    };
    let text = refused(&|h| h.grids[0].nodes = [40, 40]);
    assert_eq!(text, "the map has 1744 nodes, wanted at most 800");
    let text = refused(&|h| h.grids[1].nodes = [3, 18]);
    assert_eq!(
        text,
        "a field of 3 by 18 nodes, wanted 4 or more either way"
    );
    let text = refused(&|h| h.waves[2].own_order = 3);
    assert!(text.starts_with("wave 2:"), "{text}");
    let text = refused(&|h| h.waves[1].coefficients_m[3][1] = f32::NAN);
    assert!(text.starts_with("wave 1:"), "{text}");
    let text = refused(&|h| h.trusted.truncate(8));
    assert_eq!(text, "8 words of trust bits, wanted 9");
    let (mut map, nodes) = filled(&header(), 1);
    assert_eq!(
        map.extend(&nodes[..1]),
        Err(MapError::Nodes {
            found: 289,
            wanted: 288
        })
    );
    map.begin(&header(), &Geometry::PAPER).unwrap();
    assert_eq!(
        map.complete(),
        Err(MapError::Nodes {
            found: 0,
            wanted: 288
        })
    );
}
