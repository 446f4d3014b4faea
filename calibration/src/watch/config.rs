//! What is watched for.

use crate::frame::SEGMENTS;
use crate::geometry::Geometry;
use crate::math::sqrt;
use crate::model::ErrorModel;
use crate::record::Quality;
use core::f32::consts::TAU;

/// What is left alone, of what is told: what a reference of eight windows does not know, nearly eight deviations of it. Derived
/// from those eight windows, an eighth of whose variance is the reference's own.
pub(crate) const LEFT_ALONE: f32 = 0.3;
/// What is taken for the held-out residual of a calibration that states none: the paper's, 4.1 µm.
const UNSTATED_RESIDUAL_M: f32 = 4.1e-6;

/// What is watched for.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct WatchConfig {
    /// A change of one segment's error at one order that is told, metres rms.
    pub told_rms_m: f32,
    /// Above this a calibration is stale, metres rms.
    pub stale_rms_m: f32,
    /// What the calibration left in the parity of held-out poses, metres rms.
    pub residual_m: f32,
    /// Predicted standard deviation of its corrections at the worst place, metres.
    pub uncertainty_m: f32,
    /// Slopes of its corrections over the output, rms: of order 6, of orders 4 and 6, of all. Of so much of a change they are looked up beside
    /// their places.
    pub slopes: [f32; 3],
    /// Deviations of a window's amounts between what is told and the middle to what is left alone: [`WatchConfig::APART`].
    pub apart: f32,
    /// Sum of a test at which a change is told: [`WatchConfig::SCORE`].
    pub score: f32,
}

impl WatchConfig {
    /// A window counts once its amounts are known so well. What a window's readings have in common with each other alone, as
    /// where a courier goes over the same teeth again and again, is then told once in a thousand million windows. Derived from
    /// the normal tail: six deviations are once in a thousand million.
    pub const APART: f32 = 6.0;
    /// Sum of evidence at which a change is told, of windows of about 2 s or more. Derived from one false alarm in 10,000 hours
    /// of motion, ten times fewer than is asked of it: ln(192 * 10,000 * 3,600 / 2) = 22.0.
    pub const SCORE: f32 = 22.0;

    /// Half a micrometre is told (issue 39); stale is what adds as much as the calibration left, or four times what is told.
    #[must_use]
    pub fn of(quality: &Quality, model: &ErrorModel, geometry: &Geometry) -> Self {
        let stated = quality.residual_after_m;
        let residual_m = if stated > 0.0 && stated < 1.0e-3 {
            stated
        } else {
            UNSTATED_RESIDUAL_M
        };
        let worst = quality.predicted_worst_m;
        let told_rms_m = 0.5e-6;
        Self {
            told_rms_m,
            stale_rms_m: residual_m.max(4.0 * told_rms_m),
            residual_m,
            uncertainty_m: if worst < residual_m {
                worst
            } else {
                residual_m
            },
            slopes: [6, 4, 1].map(|from| slope(model, from, geometry.pitch_m)),
            apart: Self::APART,
            score: Self::SCORE,
        }
    }

    /// Amplitude of a wave that is told, metres.
    #[must_use]
    pub fn told_m(&self) -> f32 {
        core::f32::consts::SQRT_2 * self.told_rms_m
    }

    pub(super) fn bounds(&self) -> Bounds {
        let told_m = self.told_m();
        Bounds {
            told_m,
            left_alone_m: LEFT_ALONE * told_m,
        }
    }

    /// A window's amounts must be known to this, metres, to count.
    pub(super) fn precision_m(&self) -> f32 {
        self.bounds().middle_m() / self.apart
    }

    /// Prior of the shapes' amounts: all of what is left, in six waves.
    pub(crate) fn shape_m(&self) -> f32 {
        self.residual_m / sqrt(6.0)
    }
}

/// Slope of corrections from an order on over the output, rms over a tooth and the segments.
fn slope(model: &ErrorModel, from: u8, pitch_m: f32) -> f32 {
    let terms = model.terms.iter().zip(&model.coefficients);
    let terms = terms.filter(|(term, _)| term.own_order >= from);
    let square: f32 = terms
        .map(|(term, rows)| {
            let order = f32::from(term.own_order);
            let squares = rows.as_flattened().iter().map(|k| 0.5 * k * k);
            order * order * squares.sum::<f32>()
        })
        .sum();
    TAU / pitch_m * sqrt(square / SEGMENTS as f32)
}

/// What is told and what is left alone, amplitudes in metres.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(super) struct Bounds {
    pub told_m: f32,
    pub left_alone_m: f32,
}

impl Bounds {
    pub const fn middle_m(self) -> f32 {
        0.5 * (self.told_m + self.left_alone_m)
    }
}
