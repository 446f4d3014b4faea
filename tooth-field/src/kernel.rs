//! Kernels: how much each node of a lattice weighs in a segment's reading.

use serde::{Deserialize, Serialize};

/// Weights of nodes in a reading: a product of one function along the segment's direction (0) and one across it (1), both of which
/// are even and end at a bound.
pub trait Kernel {
    /// Where the weights end, pitches.
    fn half_pitches(&self, direction: usize) -> f64;

    /// Weight of a node so many pitches away.
    fn weight(&self, direction: usize, away_pitches: f64) -> f64;

    /// Sum of the squared weights of nodes so many pitches apart, as it is on average over the places between them: by the midpoint
    /// rule.
    fn squares(&self, direction: usize, step_pitches: f64) -> f64 {
        /// Of the midpoint rule. Derived from its error for the smoothest and the steepest edge, whose squares are exact to a
        /// thousandth then.
        const INTERVALS: i32 = 40;
        let width = self.half_pitches(direction) / f64::from(INTERVALS);
        let at = |k: i32| self.weight(direction, (f64::from(k) + 0.5) * width);
        let half: f64 = (0..INTERVALS).map(|k| at(k).powi(2)).sum();
        2.0 * width * half / step_pitches
    }
}

/// Uniform cubic B-spline with knots a unit apart, centred at zero (de Boor 2001).
#[must_use]
pub fn cubic_b_spline(x: f64) -> f64 {
    let x = x.abs();
    if x < 1.0 {
        2.0 / 3.0 - x * x + 0.5 * x * x * x
    } else if x < 2.0 {
        (2.0 - x).powi(3) / 6.0
    } else {
        0.0
    }
}

/// Cubic B-splines a pitch apart: the field that a board evaluates (`courier_sensor::teeth`).
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct CubicSpline;

impl Kernel for CubicSpline {
    fn half_pitches(&self, _: usize) -> f64 {
        2.0
    }

    fn weight(&self, _: usize, away_pitches: f64) -> f64 {
        cubic_b_spline(away_pitches)
    }
}

/// What a segment's reading averages over: flat to its edges, which fall smoothly (a cubic, level at both ends).
#[derive(Clone, Copy, Debug, Default, PartialEq, Serialize, Deserialize)]
pub struct ApertureKernel {
    /// Half of it along and across the segment's direction, pitches.
    pub half_pitches: [f64; 2],
    /// Share of each half that is its edge: 1 is a bell, near 0 a box.
    pub edge: f64,
}

impl Kernel for ApertureKernel {
    fn half_pitches(&self, direction: usize) -> f64 {
        self.half_pitches[direction]
    }

    /// Teeth a pitch apart have weights that add up to one.
    fn weight(&self, direction: usize, away_pitches: f64) -> f64 {
        let (half, away) = (self.half_pitches[direction], away_pitches.abs());
        if away >= half {
            return 0.0;
        }
        let flat = half * (1.0 - self.edge);
        let fall = ((away - flat) / (half - flat)).max(0.0);
        (1.0 - fall * fall * (3.0 - 2.0 * fall)) / (half * (2.0 - self.edge))
    }
}

/// Teeth along and across a segment that its reading averages. A prior: the fewest that such segments are built with; the more
/// there are, the smoother the field.
const APERTURE_PITCHES: f64 = 4.0;

/// The same of an aperture that nobody has measured yet, on a mesh. Up to a pitch from node to node it is what a tooth has in common with
/// the narrowest aperture that is built, at the nodes, and linear between them. Of a coarser mesh it is a cubic B-spline: what straight
/// lines miss of a field grows with the square of the mesh's width, what such splines miss with its fourth power (de Boor 2001).
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct MeshKernel {
    /// Pitches from node to node.
    pub step_pitches: f64,
    /// Pitches that a reading averages, along and across.
    pub aperture_pitches: f64,
}

impl MeshKernel {
    /// Of a segment that reads several teeth at once: the narrowest that is built.
    #[must_use]
    pub fn of_segment(step_pitches: f64) -> Self {
        Self {
            step_pitches,
            aperture_pitches: APERTURE_PITCHES,
        }
    }

    /// Of a sensor that reads one tooth, or one pole, at a time: what a node adds ends at the next, and between two it is their mean. Nodes are
    /// no more than a pitch apart.
    #[must_use]
    pub fn of_one_tooth(step_pitches: f64) -> Self {
        Self {
            step_pitches,
            aperture_pitches: 2.0 * step_pitches - 1.0,
        }
    }

    /// Nodes to either side that an aperture reaches at most.
    #[must_use]
    pub fn reach(&self) -> i32 {
        if self.is_smooth() {
            return 2;
        }
        ((0.5 * self.aperture_pitches + 0.5) / self.step_pitches)
            .ceil()
            .max(1.0) as i32
    }

    /// True of a mesh coarser than the teeth.
    fn is_smooth(&self) -> bool {
        self.step_pitches > 1.0
    }

    /// Weight at a node so many away.
    fn at_node(&self, away: f64) -> f64 {
        if away == 0.0 {
            return 1.0;
        }
        (0.5 * self.aperture_pitches + 0.5 - away * self.step_pitches).clamp(0.0, 1.0)
    }
}

impl Kernel for MeshKernel {
    fn half_pitches(&self, _: usize) -> f64 {
        f64::from(self.reach()) * self.step_pitches
    }

    fn weight(&self, _: usize, away_pitches: f64) -> f64 {
        let away = away_pitches.abs() / self.step_pitches;
        if self.is_smooth() {
            return cubic_b_spline(away);
        }
        let (first, part) = (away.floor(), away.fract());
        (1.0 - part) * self.at_node(first) + part * self.at_node(first + 1.0)
    }

    /// At the nodes: between them the weights are those of a straight line.
    fn squares(&self, direction: usize, step_pitches: f64) -> f64 {
        let reach = self.reach();
        let at = |k: i32| self.weight(direction, f64::from(k) * step_pitches);
        (-reach..=reach).map(|k| at(k).powi(2)).sum()
    }
}

/// How two readings go together that are 0, 1, 2 … steps apart along a direction, the nodes being independent and a step apart: the
/// kernel's autocorrelation, 1 at zero. As many as are asked for.
#[must_use]
pub fn correlations(
    kernel: &impl Kernel,
    direction: usize,
    step_pitches: f64,
    count: usize,
) -> Vec<f64> {
    let reach = (kernel.half_pitches(direction) / step_pitches).ceil() as i32;
    let weights: Vec<f64> = (-reach..=reach)
        .map(|k| kernel.weight(direction, f64::from(k) * step_pitches))
        .collect();
    let whole: f64 = weights.iter().map(|w| w * w).sum();
    (0..count)
        .map(|lag| {
            let later = weights.iter().skip(lag);
            weights.iter().zip(later).map(|(a, b)| a * b).sum::<f64>() / whole
        })
        .collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    const APERTURE: ApertureKernel = ApertureKernel {
        half_pitches: [3.2, 4.7],
        edge: 0.5,
    };

    /// Integral over a kernel, of a power of its weights.
    fn integral(kernel: &impl Kernel, direction: usize, power: i32) -> f64 {
        let at = |k: i32| kernel.weight(direction, f64::from(k) * 0.01);
        (-600..600).map(|k| 0.01 * at(k).powi(power)).sum()
    }

    #[test]
    fn an_aperture_holds_the_whole_of_what_it_averages() {
        for edge in [0.1, 0.5, 1.0] {
            let aperture = ApertureKernel { edge, ..APERTURE };
            for direction in 0..2 {
                assert!((integral(&aperture, direction, 1) - 1.0).abs() < 1e-3);
                let squares = integral(&aperture, direction, 2);
                for step in [1.0, 1.5] {
                    let found = step * aperture.squares(direction, step);
                    assert!((squares - found).abs() < 1e-3, "{edge} {direction}");
                }
            }
        }
    }

    /// The integral of the squared spline is 151/315 (its own convolution, a spline of seventh degree, at zero).
    #[test]
    fn a_splines_squares_are_those_of_a_table() {
        let found = CubicSpline.squares(0, 1.0);
        assert!((found - 151.0 / 315.0).abs() < 1e-4, "{found}");
        let sum: f64 = (-3..=3)
            .map(|k| CubicSpline.weight(0, 0.3 + f64::from(k)))
            .sum();
        assert!((sum - 1.0).abs() < 1e-15);
    }

    /// A tooth reaches two pitches and a half on a mesh, and nothing at the next node.
    #[test]
    fn a_mesh_reaches_as_far_as_its_aperture() {
        for step in [0.25, 0.5, 1.0] {
            let mesh = MeshKernel::of_segment(step);
            let half = mesh.half_pitches(0);
            assert!(half >= 2.5 && half < 2.5 + step);
            assert_eq!(mesh.weight(0, half), 0.0);
            assert_eq!(mesh.weight(0, 0.0), 1.0);
            assert!(mesh.weight(0, 2.4) > 0.0);
            let one = MeshKernel::of_one_tooth(step);
            let weights = [0.0, 0.25, 1.0].map(|away| one.weight(0, away * step));
            assert_eq!((one.half_pitches(0), weights), (step, [1.0, 0.75, 0.0]));
        }
    }

    /// What one tooth adds to the readings of a segment, whose weights are a bell six pitches wide, fitted by least squares on a coarse mesh. A
    /// cubic B-spline leaves less than a twentieth of it, which is what the forms of effects lack as a rule; straight lines leave more.
    #[test]
    fn a_coarse_mesh_is_smooth() {
        use nalgebra::{DMatrix, DVector};
        /// Pitches from knot to knot: the finest mesh that is coarser than the teeth, of those that the diagnosis lays.
        const STEP: f64 = 1.5;
        let bell = ApertureKernel {
            half_pitches: [3.0; 2],
            edge: 1.0,
        };
        let places: Vec<f64> = (-60..=60).map(|k| 0.1 * f64::from(k)).collect();
        let left = |weight: &dyn Fn(f64) -> f64| {
            let columns = DMatrix::from_fn(places.len(), 9, |row, knot| {
                weight(places[row] - STEP * (knot as f64 - 4.0))
            });
            let target = DVector::from_iterator(
                places.len(),
                places.iter().map(|at| bell.weight(0, at - 0.4)),
            );
            let amounts = (columns.transpose() * &columns)
                .cholesky()
                .unwrap()
                .solve(&(columns.transpose() * &target));
            (&target - columns * amounts).norm() / target.norm()
        };
        let mesh = MeshKernel::of_segment(STEP);
        let smooth = left(&|away| mesh.weight(0, away));
        let straight = left(&|away: f64| (1.0 - away.abs() / STEP).max(0.0));
        assert!(smooth < 0.05 && straight > 0.05, "{smooth} {straight}");
        assert_eq!(mesh.half_pitches(0), 2.0 * STEP);
    }

    #[test]
    fn readings_apart_by_more_than_a_kernel_have_nothing_in_common() {
        let table = correlations(&APERTURE, 0, 1.0 / 64.0, 64 * 7);
        assert_eq!(table[0], 1.0);
        assert!(table.windows(2).all(|pair| pair[1] <= pair[0]));
        assert!(table[64 * 6] > 0.0 && table[410..].iter().all(|c| *c == 0.0));
    }
}
