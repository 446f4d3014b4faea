//! The segments against pose columns: an independent reference, or the commands.

use crate::fault::{ANGLES, Axes, Fault, LENGTHS, Source, Unit, unit_of};
use crate::products::{Fit, Products, fit};
use crate::readings::Readings;
use crate::view::View;
use nalgebra::DVector;

/// A segment that moves by less than this, rms, says nothing: the errors of equation (3) reach some 30 µm (paper, 3.1.2).
pub(crate) const EXCITATION_M: f64 = 60.0e-6;
/// Arm at which an angle counts as a length: half of the paper's lever arm (90 mm, section 3.2.1).
const ARM_M: f64 = 0.05;
/// An angle moves if it does so by this many times its own error. Derived from the normal tail: by chance once in 370.
const TURN_SIGNAL_TO_NOISE: f64 = 3.0;
/// Pose columns explain a motion if less than this share of it is left.
const UNEXPLAINED_SHARE: f64 = 0.2;
/// What is left against a reference and is of this share of the pitch is no error of a sensor. Derived from the paper's parity
/// without calibration, 29.3 µm of four segments (3.1.2): seven times one segment's.
const GROSS_ERROR_PITCHES: f64 = 0.1;
/// What is known of no coefficient better than this error of the readings, m: as much as the paper's parity after calibration,
/// 4.1 to 5.5 µm (3.1.2).
pub(crate) const ERROR_FLOOR_M: f64 = 5.0e-6;
/// A reference's scale is right within this share. Derived from thermal growth (22 ppm/K) over 20 K, ten times that; half the
/// smallest fault that is known, 1 %.
const REFERENCE_SCALE_TOLERANCE: f64 = 0.005;
/// Commands lag and miss: their scale is looked at no more closely than this.
const COMMANDED_SCALE_TOLERANCE: f64 = 0.03;
/// An angle's scale is the span's, and a drawing may be off by this share: within it the diagnosis tells it as an effect. A
/// prior: the paper starts from 5 % (3.2.1), and four times that is no drawing of this courier.
pub(crate) const DRAWING_TOLERANCE: f64 = 0.2;
/// A unit's factor is told from another scale within this share.
const UNIT_TOLERANCE: f64 = 0.01;
/// Standard errors within which two values are the same. A prior: the errors are bounds of what equation (3) leaves, not deviations of noise.
const COVERAGE_FACTOR: f64 = 1.5;

/// Pose columns beside all recorded segments.
#[derive(Clone, Debug)]
pub(crate) struct Poses {
    source: Source,
    products: Products,
    /// Column of each axis in the products.
    axis: [Option<usize>; 3],
    width: usize,
}

/// What a view of the segments makes of pose columns.
#[derive(Clone, Debug, Default)]
pub(crate) struct Judged {
    /// What is wrong with the pose columns.
    pub faults: Vec<Fault>,
    /// Responses that no axis explains.
    pub unexplained: usize,
    /// Responses that move enough to be looked at.
    pub told: usize,
    /// Responses that an axis explains.
    pub explained: usize,
    /// Reading over pose of the lengths and of the angle, with their standard errors, where told.
    pub scales: [Option<[f64; 2]>; 2],
}

/// One response: which axis it follows and by what factor.
#[derive(Clone, Copy, Debug)]
struct Followed {
    axis: usize,
    factor: f64,
    error: f64,
}

impl Poses {
    /// Of the recorded columns of a source, if there are any with enough rows.
    pub fn new(readings: &Readings, source: Source) -> Option<Self> {
        let poses = match source {
            Source::Reference => &readings.reference,
            Source::Commanded => &readings.commanded,
        };
        let mut needed: Vec<&Vec<f64>> = readings.position_m.iter().collect();
        needed.extend(poses.iter());
        if poses.iter().all(Vec::is_empty) {
            return None;
        }
        let mut axis = [None; 3];
        let mut width = 4;
        let mut columns: Vec<&Vec<f64>> = readings.position_m.iter().collect();
        for (k, pose) in poses
            .iter()
            .enumerate()
            .filter(|(_, pose)| !pose.is_empty())
        {
            axis[k] = Some(width);
            width += 1;
            columns.push(pose);
        }
        let products = readings.products(&readings.rows_with(&needed), &columns)?;
        Some(Self {
            source,
            products,
            axis,
            width,
        })
    }

    /// What the pose columns leave of x and y, rms, m; infinite where nothing is told.
    pub fn left_m(&self, view: &View) -> [f64; 2] {
        [0, 1].map(|response| {
            let fitted = self.fitted(view, response);
            fitted.map_or(f64::INFINITY, |(_, _, fit)| fit.left)
        })
    }

    /// A response's weights, the axes that move, and its fit by them. Where the courier went along one line alone, x and y move in proportion, and
    /// neither's share is told: the response is then fitted by its own axis and the angle.
    fn fitted(&self, view: &View, response: usize) -> Option<(DVector<f64>, Vec<usize>, Fit)> {
        let weights = view.response(response, self.width)?;
        self.axis[response]?;
        let by = |axes: &[usize]| {
            let regressors: Vec<DVector<f64>> = axes.iter().map(|k| self.unit(*k)).collect();
            fit(&self.products.projected, &weights, &regressors)
        };
        let mut axes: Vec<usize> = (0..3).filter(|k| self.moves(*k)).collect();
        let mut fit = by(&axes);
        if fit.alone.iter().any(|alone| *alone <= 0.0) {
            axes.retain(|axis| *axis == response || *axis == 2);
            fit = by(&axes);
        }
        Some((weights, axes, fit))
    }

    /// Weights that make an axis of the pose columns.
    fn unit(&self, axis: usize) -> DVector<f64> {
        let mut weights = DVector::zeros(self.width);
        weights[self.axis[axis].unwrap_or(0)] = 1.0;
        weights
    }

    /// Judges the columns as a view of the segments sees them.
    pub fn judge(&self, view: &View) -> Judged {
        let mut judged = Judged::default();
        let followed = [0, 1, 2].map(|response| self.followed(view, response, &mut judged));
        judged.explained = followed.iter().flatten().count();
        let exchanged = self.exchanged(&followed, &mut judged);
        self.signs(&followed, &mut judged);
        self.scales(&followed, exchanged, &mut judged);
        judged
    }

    /// The axis that a response (x, y or theta of the segments) follows; `None` where that is not told.
    fn followed(&self, view: &View, response: usize, judged: &mut Judged) -> Option<Followed> {
        let (weights, axes, fit) = self.fitted(view, response)?;
        let arm = if response == 2 { ARM_M } else { 1.0 };
        // By what was measured, whatever the view's scale: no view makes a motion too small to be looked at.
        let inexact = if response == 2 {
            view.angle_error_rad(self.products.periodic_m)
        } else {
            0.0
        };
        let moved = |i: usize| fit.coefficients[i].abs() * self.rms(axes[i]);
        let main = (0..axes.len()).max_by(|a, b| moved(*a).total_cmp(&moved(*b)))?;
        // An angle that only the pose column shows is as much of a contradiction. Two angles that are small against the segments' errors may
        // still show whether they turn alike: one of their sum and difference is then large, whichever sign is right.
        let was = if response == 2 {
            let together = [-1.0, 1.0].map(|sign| {
                let sum = &weights + self.unit(2) * sign;
                (&self.products.projected * &sum).dot(&sum).max(0.0).sqrt()
            });
            together
                .into_iter()
                .fold(fit.was.max(self.rms(2)), f64::max)
        } else {
            fit.was
        };
        let moves =
            was * arm * view.lengths >= EXCITATION_M && was >= TURN_SIGNAL_TO_NOISE * inexact;
        // However inexact the segments' angle is: errors of theirs do not turn as an instrument of its own says.
        let turns_with_it =
            response == 2 && axes[main] == 2 && fit.left <= UNEXPLAINED_SHARE * fit.was;
        if !moves && !turns_with_it {
            return None;
        }
        judged.told += 1;
        let of_the_pitch = self.source == Source::Reference
            && response < 2
            && fit.left > GROSS_ERROR_PITCHES * view.tooth_m;
        if fit.left > (UNEXPLAINED_SHARE * fit.was).max(inexact) || of_the_pitch {
            judged.unexplained += usize::from(fit.was * arm > EXCITATION_M || !view.logged);
            return None;
        }
        let error = fit.error(main, ERROR_FLOOR_M / arm);
        Some(Followed {
            axis: axes[main],
            factor: fit.coefficients[main],
            error,
        })
    }

    fn rms(&self, axis: usize) -> f64 {
        let column = self.axis[axis];
        column.map_or(0.0, |c| self.products.projected[(c, c)].max(0.0).sqrt())
    }

    fn moves(&self, axis: usize) -> bool {
        self.rms(axis) > 0.0
    }

    /// Whether x and y are exchanged.
    fn exchanged(&self, followed: &[Option<Followed>; 3], judged: &mut Judged) -> bool {
        let on = |response: usize| followed[response].map(|f| f.axis);
        if on(2).is_some_and(|axis| axis != 2) || on(0) == Some(2) || on(1) == Some(2) {
            judged.unexplained += 1;
        }
        let crossed = match (on(0), on(1)) {
            (Some(1), Some(0) | None) | (None, Some(0)) => true,
            (Some(a), Some(b)) if a == b => {
                judged.unexplained += 1;
                false
            }
            _ => false,
        };
        if crossed {
            judged.faults.push(Fault::PoseAxesExchanged(self.source));
        }
        crossed
    }

    fn signs(&self, followed: &[Option<Followed>; 3], judged: &mut Judged) {
        let told: Vec<Followed> = followed.iter().flatten().copied().collect();
        let turned: Vec<Followed> = told.iter().copied().filter(|f| f.factor < 0.0).collect();
        if turned.len() > 1 && turned.len() == told.len() {
            judged.faults.push(Fault::PoseAllReversed(self.source));
        } else {
            let fault = |f: &Followed| Fault::PoseReversed(self.source, f.axis);
            judged.faults.extend(turned.iter().map(fault));
        }
    }

    fn scales(&self, followed: &[Option<Followed>; 3], crossed: bool, judged: &mut Judged) {
        let share = match self.source {
            Source::Reference => REFERENCE_SCALE_TOLERANCE,
            Source::Commanded => COMMANDED_SCALE_TOLERANCE,
        };
        let beyond = |f: &Followed, around: f64, share: f64| {
            (f.factor.abs() - around).abs() > share * around + COVERAGE_FACTOR * f.error
        };
        let off = |f: &Followed, around: f64| beyond(f, around, share);
        let push = |judged: &mut Judged, axes: Axes, f: Followed, units: &[Unit]| {
            let factor = 1.0 / f.factor.abs();
            let known = unit_of(
                factor,
                units,
                UNIT_TOLERANCE.max(COVERAGE_FACTOR * f.error / f.factor.abs()),
            );
            let factor = known.map_or(factor, |unit| unit.factor);
            let fault = Fault::PoseScale(self.source, axes, factor);
            judged.faults.push(fault);
        };
        let lengths: Vec<Followed> = followed[..2].iter().flatten().copied().collect();
        match lengths[..] {
            [x, y] if off(&x, y.factor.abs()) && off(&y, x.factor.abs()) => {
                for (response, f) in [x, y].into_iter().enumerate().filter(|(_, f)| off(f, 1.0)) {
                    let axis = if crossed { 1 - response } else { response };
                    push(judged, Axes::One(axis), f, &LENGTHS);
                }
            }
            [f, ..] => {
                let best = lengths.iter().min_by(|a, b| a.error.total_cmp(&b.error));
                let best = *best.unwrap_or(&f);
                judged.scales[0] = Some([best.factor.abs(), best.error]);
                if off(&best, 1.0) {
                    push(judged, Axes::Lengths, best, &LENGTHS);
                }
            }
            [] => {}
        }
        if let Some(angle) = followed[2] {
            judged.scales[1] = Some([angle.factor.abs(), angle.error]);
            if beyond(&angle, 1.0, DRAWING_TOLERANCE) {
                push(judged, Axes::Angle, angle, &ANGLES);
            }
        }
    }
}
