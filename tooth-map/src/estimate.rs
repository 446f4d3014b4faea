//! The whole estimation: plain fit, fit with waves and fields, judgement by held-out poses, and what a board is given.

use super::anchor::Anchor;
use super::constraint::linear;
use super::fit::{Fit, Problem};
use super::lattice::{self, FIELD};
use super::model::places;
use super::patch::{Patch, crop};
use super::pose::{Noise, Setup, TeethPose};
use super::predict;
use super::unknowns::{NODE_M, Unknowns, WAVES};
use anyhow::{Result, anyhow, ensure};
use courier_sensor::equations::{OWN_ORDERS, theta};
use courier_sensor::frame::SEGMENTS;
use courier_sensor::model::{ErrorModel, TermTable};
use courier_sensor::teeth::{Grid, MAX_NODES, MapHeader, Wave};
use nalgebra::Vector3;
use serde::{Deserialize, Serialize};

/// One pose in so many is held out. Derived from a thousand poses: 166 of them with three rows each tell an rms to 3 %.
const HELD_OUT: usize = 6;
/// A map stays if held-out poses gain more than this many standard errors of the gain. Derived from the normal tail: by chance
/// one useless map in 44 would stay, were its expected gain zero; it is negative.
const SIGNIFICANT: f64 = 2.0;
/// Fewest poses for a map.
/// Derived from what is held out: 40 poses with three rows each tell an rms to 6 %.
const FEWEST: usize = 240;
/// Most nodes that are estimated, of which a board takes [`MAX_NODES`].
const MOST_NODES: usize = 2 * MAX_NODES;
/// Least rms angle. By definition as for the firmware's joint calibration (0.1°).
const LEAST_TURN_RAD: f64 = 1.75e-3;
/// A cell is trusted where its middle is known to this share of the fields' deviation before the data, 1 um. Derived from the
/// variances: three quarters of what is known is then told by the data.
const TRUSTED_SHARE: f64 = 0.5;
/// Times that the noise is measured and the fit repeated. A bound on the work: the noise that the last fit showed is told as it
/// is.
const REWEIGHTINGS: usize = 2;
/// Noise to begin with: bad teeth, and a diode not yet known.
pub const FIRST_NOISE: Noise = Noise {
    segment_m: 2.0e-6,
    displacement_m: 3.0e-6,
};
/// What the estimation rests on and how good it is.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize)]
pub struct Evidence {
    /// Poses fitted.
    pub poses: usize,
    /// Poses held out.
    pub held_out_poses: usize,
    /// Unknowns.
    pub unknowns: usize,
    /// Held-out g_p, g_x, g_y without waves and fields, metres rms.
    pub before_m: [f64; 3],
    /// With them.
    pub after_m: [f64; 3],
    /// Gain of the held-out poses over its standard error.
    pub significance: f64,
    /// Noise of a segment that the poses show, metres.
    pub segment_noise_m: f64,
    /// Noise of a displacement, metres.
    pub displacement_noise_m: f64,
    /// Largest predicted deviation of a trusted cell's middle, metres: x's field, y's.
    pub worst_deviation_m: [f64; 2],
    /// Predicted rms deviation of a position, less its mean, on the way along x and along y through the middle of the poses, metres.
    #[serde(default)]
    pub way_deviation_m: [f64; 2],
    /// Predicted rms deviations of the angles by segments 1 and 3, by 2 and 4, less their means, on these two ways, rad.
    #[serde(default)]
    pub way_angle_deviation_rad: [[f64; 2]; 2],
}

/// What a board is given, and on what grounds.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Mapped {
    /// Equations (3) and (9) as fitted with the map: in force together with it.
    pub model: ErrorModel,
    /// Lattices (tooth counts of the recording), waves, trusted cells.
    pub header: MapHeader,
    /// Nodes, nanometres: x's field, then y's; across runs fastest.
    pub nodes_nm: Vec<i16>,
    /// Predicted deviation of each cell's middle, metres, numbered as its first node; none outside and where nothing was visited.
    pub deviations_m: Vec<Option<f64>>,
    /// Where it lies: by this a board that was restarted is given its places.
    pub anchor: Anchor,
    /// On what it rests.
    pub evidence: Evidence,
}

/// Estimates; `tick` is called after each pass.
///
/// # Errors
/// Too few poses, no rotation, an area larger than the board's memory, or held-out poses that do not want a map.
pub fn estimate(setup: &Setup, poses: &[TeethPose], tick: &mut dyn FnMut()) -> Result<Mapped> {
    let (fitted, held_out) = split(poses);
    ensure!(
        fitted.len() >= FEWEST,
        "the recording: found {} poses to fit, wanted {FEWEST} or more",
        fitted.len()
    );
    check_turn(setup, &fitted)?;
    let unknowns = Unknowns::new(lattices(setup, poses)?);
    let problem = Problem {
        setup,
        unknowns: &unknowns,
        poses: &fitted,
    };
    let mut fit = Fit::start(&problem, FIRST_NOISE);
    fit.improve(&problem, |i| unknowns.is_plain(i), tick)?;
    let mut plain = Fit::start(&problem, FIRST_NOISE);
    plain.values.clone_from(&fit.values);
    let spent = (unknowns.count() as f64 / (3.0 * fitted.len() as f64)).min(0.5);
    for _ in 0..=REWEIGHTINGS {
        fit.improve(&problem, |_| true, tick)?;
        fit.show_noise(&problem, spent);
    }
    fit.improve(&problem, |_| true, tick)?;
    let judged = Judged::of(setup, &unknowns, &held_out, [&plain, &fit]);
    let [before, after] = judged
        .rms_m
        .map(|g| g.map(|g| format!("{:.2}", 1.0e6 * g)).join(", "));
    ensure!(
        judged.significance > SIGNIFICANT,
        "the recording: held-out g_p, g_x, g_y went from {before} to {after} µm, a gain of {:.1} standard errors, wanted over {SIGNIFICANT}",
        judged.significance
    );
    Ok(result(&problem, &fit, &judged, held_out.len()))
}

/// Poses to fit, and one in so many that is held out.
#[must_use]
pub fn split(poses: &[TeethPose]) -> (Vec<TeethPose>, Vec<TeethPose>) {
    let part = |held: bool| {
        let chosen = poses
            .iter()
            .enumerate()
            .filter(move |(i, _)| (i % HELD_OUT == HELD_OUT - 1) == held);
        chosen.map(|(_, pose)| *pose).collect()
    };
    (part(false), part(true))
}

/// That poses turn.
///
/// # Errors
/// The rms of their angles is below what parts the fields from the coordination sensor's own errors.
pub fn check_turn(setup: &Setup, poses: &[TeethPose]) -> Result<()> {
    let angles = poses
        .iter()
        .map(|pose| theta(&pose.outputs_m, setup.span_m));
    let angles: Vec<f64> = angles.collect();
    let turn_rad = deviation(&angles);
    ensure!(
        turn_rad >= LEAST_TURN_RAD,
        "the recording: found a rotation of {:.3} mrad rms, wanted {:.2} or more: without it the fields and the coordination sensor's own errors are one",
        1.0e3 * turn_rad,
        1.0e3 * LEAST_TURN_RAD
    );
    Ok(())
}

/// Lattices of x's and y's field over all poses; calibration moves a place by some hundredths of a pitch.
///
/// # Errors
/// An area that is larger than can be estimated.
pub fn lattices(setup: &Setup, poses: &[TeethPose]) -> Result<[Grid; 2]> {
    /// Margin about all places, pitches: what a calibration may move them by, 0.03 for an error of 30 µm (paper, 3.1.2: 29.3 µm
    /// of parity).
    const MARGIN_PITCHES: f64 = 0.05;
    let mut bounds = [[[f64::INFINITY, f64::NEG_INFINITY]; 2]; 2];
    for pose in poses {
        for (i, place) in places(setup, &pose.outputs_m).into_iter().enumerate() {
            for (bound, p) in bounds[i % 2].iter_mut().zip(place) {
                *bound = [
                    bound[0].min(p - MARGIN_PITCHES),
                    bound[1].max(p + MARGIN_PITCHES),
                ];
            }
        }
    }
    let covering = |bound| {
        lattice::covering(bound).map_err(|far| {
            anyhow!(
                "the recording: found places that reach {far:.0} teeth, wanted at most {}: --within takes the middle; or pitch_m, \
                 span_m or lever arms of its recording.toml are not in metres",
                u8::MAX
            )
        })
    };
    let grids = [covering(bounds[0])?, covering(bounds[1])?];
    let nodes: usize = grids.iter().map(Grid::count).sum();
    ensure!(
        nodes <= MOST_NODES,
        "the recording: found an area of {nodes} nodes, wanted at most {MOST_NODES}, which takes minutes: --within takes the middle"
    );
    Ok(grids)
}

/// Standard deviation.
fn deviation(values: &[f64]) -> f64 {
    let count = values.len().max(1) as f64;
    let mean = values.iter().sum::<f64>() / count;
    (values.iter().map(|v| (v - mean).powi(2)).sum::<f64>() / count).sqrt()
}

struct Judged {
    rms_m: [[f64; 3]; 2],
    significance: f64,
}

impl Judged {
    /// Before and after, both whitened by the covariance of the fit after.
    fn of(setup: &Setup, unknowns: &Unknowns, poses: &[TeethPose], fits: [&Fit; 2]) -> Self {
        let mut squares = [[0.0; 3]; 2];
        let mut gains = Vec::with_capacity(poses.len());
        for pose in poses {
            let lines = fits.map(|fit| linear(setup, unknowns, &fit.values, pose));
            let whitening = lines[1].whitening(&fits[1].noise);
            let lengths = [0, 1].map(|k| (whitening * Vector3::from(lines[k].g_m)).norm_squared());
            gains.push(lengths[0] - lengths[1]);
            for (sums, line) in squares.iter_mut().zip(&lines) {
                sums.iter_mut()
                    .zip(line.g_m)
                    .for_each(|(sum, g)| *sum += g * g);
            }
        }
        let count = poses.len().max(1) as f64;
        let mean = gains.iter().sum::<f64>() / count;
        let error = deviation(&gains) / count.sqrt();
        Self {
            rms_m: squares.map(|s| s.map(|s| (s / count).sqrt())),
            significance: if error > 0.0 { mean / error } else { 0.0 },
        }
    }
}

fn result(problem: &Problem, fit: &Fit, judged: &Judged, held_out: usize) -> Mapped {
    let unknowns = problem.unknowns;
    let mut patches = [0, 1].map(|direction| patch(problem, fit, direction));
    crop(&mut patches, MAX_NODES);
    let cells = patches.iter().flat_map(|patch| &patch.trusted);
    let mut trusted = MapHeader::default().trusted;
    let _ = trusted.resize(cells.clone().count().div_ceil(32), 0);
    for (cell, _) in cells.enumerate().filter(|(_, trusted)| **trusted) {
        trusted[cell / 32] |= 1 << (cell % 32);
    }
    let worst = |patch: &Patch| {
        let cells = patch.deviations_m.iter().zip(&patch.trusted);
        let used = cells.filter_map(|(deviation, trusted)| deviation.filter(|_| *trusted));
        used.fold(0.0, f64::max)
    };
    let ways = [0, 1].map(|direction| predict::of_way(problem, fit, direction));
    let evidence = Evidence {
        poses: problem.poses.len(),
        held_out_poses: held_out,
        unknowns: unknowns.count(),
        before_m: judged.rms_m[0],
        after_m: judged.rms_m[1],
        significance: judged.significance,
        segment_noise_m: fit.noise.segment_m,
        displacement_noise_m: fit.noise.displacement_m,
        worst_deviation_m: patches.each_ref().map(worst),
        way_deviation_m: ways.map(|way| way.position_m),
        way_angle_deviation_rad: ways.map(|way| way.angles_rad),
    };
    Mapped {
        model: error_model(unknowns, &fit.values),
        header: MapHeader {
            grids: patches.each_ref().map(|patch| patch.grid),
            waves: waves(unknowns, &fit.values),
            trusted,
        },
        nodes_nm: patches.iter().flat_map(|p| p.nodes_nm.clone()).collect(),
        deviations_m: patches
            .iter()
            .flat_map(|p| p.deviations_m.clone())
            .collect(),
        anchor: anchor(problem.setup, unknowns, &fit.values),
        evidence,
    }
}

fn anchor(setup: &Setup, unknowns: &Unknowns, values: &[f64]) -> Anchor {
    let at = unknowns.mounting();
    Anchor {
        beacon_m: [values[at + 3], values[at + 4]],
        height_m: values[at],
        lever_m: [values[at + 1], values[at + 2]],
        pitch_m: setup.pitch_m,
        tan_full_scale: setup.tan_full_scale,
    }
}

/// One direction's whole field, its mean over the visited cells taken off.
fn patch(problem: &Problem, fit: &Fit, direction: usize) -> Patch {
    let unknowns = problem.unknowns;
    let grid = unknowns.grids[direction];
    let deviations_m = predict::of_cells(problem, fit, direction);
    let mean_m = mean_field(unknowns, fit, direction, &deviations_m);
    let row = usize::from(grid.nodes[1]);
    let value = |node: usize| {
        let line = fit.values[unknowns.line(direction) + node / row];
        fit.values[unknowns.field(direction) + node] + line - mean_m
    };
    let limit_m = TRUSTED_SHARE * FIELD.deviation_by_nodes() * NODE_M;
    Patch {
        grid,
        // `as` saturates; 32 um is eight prior deviations.
        nodes_nm: (0..grid.count())
            .map(|node| (1.0e9 * value(node)).round() as i16)
            .collect(),
        trusted: deviations_m
            .iter()
            .map(|d| d.is_some_and(|d| d < limit_m))
            .collect(),
        deviations_m,
    }
}

/// Mean over the visited cells: gauge.
fn mean_field(unknowns: &Unknowns, fit: &Fit, direction: usize, known: &[Option<f64>]) -> f64 {
    let grid = &unknowns.grids[direction];
    let cells = (0..known.len()).filter(|cell| known[*cell].is_some());
    let places = cells.filter_map(|cell| lattice::middle(grid, cell));
    let fields = places.filter_map(|place| unknowns.field_at(direction, place));
    let values: Vec<f64> = fields
        .map(|f| f.iter().map(|(i, w)| w * fit.values[*i]).sum())
        .collect();
    values.iter().sum::<f64>() / values.len().max(1) as f64
}

fn error_model(unknowns: &Unknowns, values: &[f64]) -> ErrorModel {
    let mut model = ErrorModel::zero(TermTable::equation_9());
    let at = |i: usize| [values[i] as f32, values[i + 1] as f32];
    for segment in 0..SEGMENTS {
        let columns: Vec<f32> = (0..OWN_ORDERS.len())
            .flat_map(|order| at(unknowns.own(segment, order)))
            .collect();
        model.set_columns(segment, &columns);
    }
    let (parity, angle) = (
        0.25 * values[unknowns.parity()] as f32,
        0.25 * values[unknowns.angle()] as f32,
    );
    model.constants_m = [
        parity + angle,
        angle - parity,
        -parity - angle,
        parity - angle,
    ];
    model
}

fn waves(
    unknowns: &Unknowns,
    values: &[f64],
) -> heapless::Vec<Wave, { courier_sensor::teeth::MAX_WAVES }> {
    let wave = |(k, (own_order, lateral_order)): (usize, &(u8, i8))| Wave {
        own_order: *own_order,
        lateral_order: *lateral_order,
        coefficients_m: std::array::from_fn(|segment| {
            let at = unknowns.wave(segment, k);
            [values[at] as f32, values[at + 1] as f32]
        }),
    };
    WAVES.iter().enumerate().map(wave).collect()
}
