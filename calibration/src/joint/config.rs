//! What a joint session is told, and its check.

use super::constraint::{Constraints, ReadingNoise, Weighting};
use super::layout::{JOINT_UNKNOWNS, Layout, Values};
use super::solver::Priors;
use super::steps::Step;
use crate::equations::PARITY_SIGN;
use crate::frame::SEGMENTS;
use crate::geometry::Geometry;
use crate::math::sqrt;
use crate::model::{ErrorModel, Term, TermTable};
use crate::plan::Range;
use crate::range::{OutOfRange, within};
use crate::start_error::StartError;
use crate::visits::Visits;

/// What a joint calibration must meet.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct JointLimits {
    /// Largest share of poses that may be lost: beacon not seen, not stood still.
    pub lost_share: f32,
    /// Largest change of the light on the coordination sensor, as a share: a second beacon doubles it.
    pub light_share: f32,
    /// Least rms of the poses' angles, radians. 0.1°: the lever arm is then known to 0.3 mm.
    pub least_turn_rad: f32,
    /// Largest difference of height and lever arm from what was entered, as a share of these. Twice the 20 % that a
    /// drawing may be off.
    pub geometry_share: f32,
    /// Largest predicted standard deviation of height and lever arm, as a share.
    pub undetermined_share: f32,
}

impl Default for JointLimits {
    fn default() -> Self {
        Self {
            lost_share: 0.1,
            light_share: 0.3,
            least_turn_rad: 1.75e-3,
            geometry_share: 0.4,
            undetermined_share: 0.05,
        }
    }
}

/// What a joint session is to do.
#[derive(Clone, Debug, PartialEq)]
pub struct JointConfig {
    /// Geometry as entered: height and lever arm are where the fit starts.
    pub geometry: Geometry,
    /// Calibration in force, or zeros: where the fit starts, and the terms to fit. The lateral ones are added if missing.
    pub model: ErrorModel,
    /// Where it goes: at most [`super::sample::POSES`] poses together; the coordination sensor is displaced by half the
    /// travel to either side of the beacon.
    pub visits: Visits,
    /// Stated noise of a pose's averaged readings: the least that is believed.
    pub noise: ReadingNoise,
    /// How the three constraints are weighted.
    pub weighting: Weighting,
    /// Whether the coordination sensor's own errors are tried as well.
    pub sensor_terms: bool,
    /// What is believed before the data.
    pub priors: Priors,
    /// What the result must meet.
    pub limits: JointLimits,
}

impl Default for JointConfig {
    /// The paper's 3.2.1: 1000 poses over two pitches and ±1.5°.
    #[inline(never)] // a kilobyte is put together, on whose stack the caller's work does not come
    fn default() -> Self {
        let geometry = Geometry::PAPER;
        Self {
            geometry,
            model: ErrorModel::zero(TermTable::equation_9()),
            visits: Visits::paper(Range {
                travel_m: 2.0 * geometry.pitch_m,
                turn_rad: 26.179_94e-3,
            }),
            noise: ReadingNoise {
                segment_m: 0.05e-6,
                displacement_m: 0.05e-6,
            },
            weighting: Weighting::Covariance,
            sensor_terms: true,
            priors: Priors::default(),
            limits: JointLimits::default(),
        }
    }
}

impl JointConfig {
    /// Checks every number.
    ///
    /// # Errors
    /// The first that is out of range. Lengths are in metres: a lever arm of 90 is refused.
    pub fn validate(&self) -> Result<(), OutOfRange> {
        let g = &self.geometry;
        within("pitch_m", g.pitch_m, 1.0e-5, 0.1)?;
        within("span_m", g.span_m, 1.0e-4, 1.0)?;
        within("lateral_m", g.lateral_m, -1.0, 1.0)?;
        within("height_m", g.height_m, 1.0e-3, 1.0)?;
        within("lever_m[0]", g.lever_m[0], -1.0, 1.0)?;
        within("lever_m[1]", g.lever_m[1], -1.0, 1.0)?;
        within("lever arm's length", lever_length_m(g), 1.0e-3, 1.0)?;
        within("tan_full_scale", g.tan_full_scale, 1.0e-3, 10.0)?;
        let visits = &self.visits;
        within("poses", visits.poses as f32, 32.0, 1.0e5)?;
        within("held_out_poses", visits.held_out_poses as f32, 16.0, 1.0e5)?;
        let room = super::sample::POSES as f32;
        within(
            "poses and held_out_poses",
            visits.total() as f32,
            48.0,
            room,
        )?;
        // What the buffer can hold, with as much again for the turns about the sensor.
        let farthest_m = f32::from(super::sample::FARTHEST_TEETH) * g.pitch_m;
        within(
            "travel_m",
            visits.range.travel_m,
            g.pitch_m,
            farthest_m.min(0.1),
        )?;
        within("turn_rad", visits.range.turn_rad, 0.0, 0.05)?;
        visits.validate()?;
        within("noise.segment_m", self.noise.segment_m, 1.0e-10, 1.0e-4)?;
        within(
            "noise.displacement_m",
            self.noise.displacement_m,
            1.0e-10,
            1.0e-4,
        )
    }

    /// Steps of the schedule.
    #[must_use]
    pub fn steps(&self) -> &'static [Step] {
        if self.sensor_terms {
            &Step::ALL
        } else {
            &Step::PAPER
        }
    }

    /// Constraints, and the values to start from. The lateral terms are added to the model if they are missing.
    ///
    /// # Errors
    /// [`StartError::Terms`] if more than six terms would be fitted.
    pub(super) fn prepare(&mut self) -> Result<(Constraints, Values), StartError> {
        add_lateral(&mut self.model).ok_or(StartError::Terms)?;
        let layout = Layout::new(&self.model).ok_or(StartError::Terms)?;
        let values = entered(&layout, &self.model, &self.geometry);
        let constraints = Constraints {
            geometry: self.geometry,
            layout,
            noise: self.noise,
            stated_noise: self.noise,
            weighting: self.weighting,
        };
        Ok((constraints, values))
    }
}

/// Length of the lever arm.
pub(super) fn lever_length_m(g: &Geometry) -> f32 {
    sqrt(g.lever_m[0] * g.lever_m[0] + g.lever_m[1] * g.lever_m[1])
}

fn add_lateral(model: &mut ErrorModel) -> Option<()> {
    if model.terms.iter().any(|term| term.lateral_order != 0) {
        return Some(());
    }
    model.terms.push(Term::lateral(1)).ok()?;
    model.coefficients.push([[0.0; 2]; SEGMENTS]).ok()
}

/// Values of a model and a geometry. Pair means of the constants are gauge and left out; the sensor's own errors are zero.
#[must_use]
pub fn entered(layout: &Layout, model: &ErrorModel, geometry: &Geometry) -> Values {
    let mut values = [0.0; JOINT_UNKNOWNS];
    for (k, (term, _)) in layout.terms.iter().enumerate() {
        let rows = model
            .coefficients
            .get(usize::from(*term))
            .copied()
            .unwrap_or_default();
        for (segment, row) in rows.iter().enumerate() {
            let at = segment * layout.columns() + 2 * k;
            values[at..at + 2].copy_from_slice(row);
        }
    }
    let k = model.constants_m;
    values[layout.parity_offset()] = k.iter().zip(PARITY_SIGN).map(|(k, s)| k * s).sum();
    values[layout.angle_offset()] = (k[0] - k[2]) + (k[1] - k[3]);
    values[layout.height()] = geometry.height_m;
    values[layout.lever()] = geometry.lever_m[0];
    values[layout.lever() + 1] = geometry.lever_m[1];
    values
}

/// The model that values make of a template.
#[must_use]
pub fn model_of(layout: &Layout, values: &Values, template: &ErrorModel) -> ErrorModel {
    let mut model = template.clone();
    for (k, (term, _)) in layout.terms.iter().enumerate() {
        let Some(rows) = model.coefficients.get_mut(usize::from(*term)) else {
            continue;
        };
        for (segment, row) in rows.iter_mut().enumerate() {
            let at = segment * layout.columns() + 2 * k;
            row.copy_from_slice(&values[at..at + 2]);
        }
    }
    let (parity, angle) = (
        values[layout.parity_offset()] / 4.0,
        values[layout.angle_offset()] / 4.0,
    );
    model.constants_m = [
        parity + angle,
        angle - parity,
        -parity - angle,
        parity - angle,
    ];
    model
}
