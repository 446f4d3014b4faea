//! How well a fit knows what it found, by its own covariance: the field at places, a position on the way through them.

use super::fit::{Fit, Problem};
use super::lattice;
use super::model::{Derivatives, outputs, places};
use super::pose::{Setup, TeethPose};
use super::unknowns::Unknowns;

/// Places looked at on a way: two a pitch on one of 16 mm. Derived from the sampling theorem: two to a period of the lowest
/// order.
const WAY_PLACES: usize = 32;
/// A way begins and ends where so many of the poses lie farther out.
const RIM_SHARE: f64 = 0.1;

/// Predicted rms deviations, less their means, on a straight way through the middle of the poses.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WayDeviation {
    /// Of the position along it, metres.
    pub position_m: f64,
    /// Of the angles by segments 1 and 3, by 2 and 4, rad.
    pub angles_rad: [f64; 2],
}

/// On the way along a direction. Means are gauge; what is left is a scale and a bend above all, which the poses tell weakly.
pub fn of_way(problem: &Problem, fit: &Fit, direction: usize) -> WayDeviation {
    let places: Vec<_> = way(problem.poses, direction)
        .iter()
        .map(|pose| {
            let mut by = Derivatives::default();
            let (setup, unknowns) = (problem.setup, problem.unknowns);
            let out = outputs(setup, unknowns, &fit.values, pose, Some(&mut by));
            [0, 1, 2, 3].map(|segment| by.of_output(&out, segment))
        })
        .collect();
    let of_pair = |pair: usize, weights: [f64; 2]| {
        let functions = places.iter().map(|by| {
            let mut function = vec![0.0; problem.unknowns.count()];
            for (by, weight) in by.iter().skip(pair).step_by(2).zip(weights) {
                for (at, derivative) in by {
                    function[*at] += weight * derivative;
                }
            }
            function
        });
        rms_less_mean(fit, &functions.collect::<Vec<_>>())
    };
    let per_span = 1.0 / problem.setup.span_m;
    WayDeviation {
        position_m: of_pair(direction, [0.5, 0.5]),
        angles_rad: [0, 1].map(|pair| of_pair(pair, [per_span, -per_span])),
    }
}

/// Predicted rms deviation of linear functions of the unknowns, less their mean.
fn rms_less_mean(fit: &Fit, functions: &[Vec<f64>]) -> f64 {
    let count = functions.len() as f64;
    let unknowns = functions.first().map_or(0, Vec::len);
    let mean: Vec<f64> = (0..unknowns)
        .map(|i| functions.iter().map(|f| f[i]).sum::<f64>() / count)
        .collect();
    let variance = |function: &Vec<f64>| {
        let off = function.iter().zip(&mean).map(|(f, mean)| f - mean);
        let off: Vec<(usize, f64)> = off.enumerate().filter(|(_, f)| *f != 0.0).collect();
        fit.deviation(&off).powi(2)
    };
    (functions.iter().map(variance).sum::<f64>() / count).sqrt()
}

/// Poses on that way, at angle zero.
fn way(poses: &[TeethPose], direction: usize) -> Vec<TeethPose> {
    let position = |axis: usize, rank: f64| {
        let mut all: Vec<f64> = poses
            .iter()
            .map(|pose| 0.5 * (pose.outputs_m[axis] + pose.outputs_m[axis + 2]))
            .collect();
        all.sort_unstable_by(f64::total_cmp);
        all[(rank * (all.len() - 1) as f64) as usize]
    };
    let (from, to) = (
        position(direction, RIM_SHARE),
        position(direction, 1.0 - RIM_SHARE),
    );
    let aside = position(1 - direction, 0.5);
    (0..WAY_PLACES)
        .map(|k| {
            let along = from + (to - from) * k as f64 / (WAY_PLACES - 1) as f64;
            let mut outputs_m = [aside; 4];
            outputs_m[direction] = along;
            outputs_m[direction + 2] = along;
            TeethPose {
                outputs_m,
                deflection: [0.0; 2],
            }
        })
        .collect()
}

/// Predicted deviation at the middle of each visited cell, less what all of them have in common.
pub fn of_cells(problem: &Problem, fit: &Fit, direction: usize) -> Vec<Option<f64>> {
    let unknowns = problem.unknowns;
    let grid = &unknowns.grids[direction];
    let visited = visited(problem.setup, unknowns, problem.poses, direction);
    let middle = |cell: usize| lattice::middle(grid, cell).filter(|_| visited[cell]);
    let functions: Vec<_> = (0..grid.count())
        .map(|cell| middle(cell).and_then(|place| unknowns.field_at(direction, place)))
        .collect();
    let count = functions.iter().flatten().count().max(1) as f64;
    let common: Vec<(usize, f64)> = functions
        .iter()
        .flatten()
        .flatten()
        .map(|(i, w)| (*i, -w / count))
        .collect();
    functions
        .into_iter()
        .map(|function| {
            let mut function = function?;
            function.extend(&common);
            Some(fit.deviation(&function))
        })
        .collect()
}

/// Cells of a direction's field that a pose has visited.
fn visited(setup: &Setup, unknowns: &Unknowns, poses: &[TeethPose], direction: usize) -> Vec<bool> {
    let grid = &unknowns.grids[direction];
    let mut visited = vec![false; grid.count()];
    for pose in poses {
        let places = places(setup, &pose.outputs_m);
        for place in places.iter().skip(direction).step_by(2) {
            if let Some(cell) = lattice::cell(grid, *place) {
                visited[cell] = true;
            }
        }
    }
    visited
}
