//! Checks of what a host orders, before any of it reaches the background.

use super::message::{Action, CalibrateOrder, Source};
use super::refusal::{Field, Refusal};
use super::telemetry::{Channels, StreamOrder};
use crate::calibration::LEAST_POSES;
use crate::calibration::record::Method;
use crate::calibration::slots::SLOTS;
use crate::maps;

/// Poses that the joint calibration's buffer holds.
pub const JOINT_POSES: u16 = 1000;
/// Fewest poses that it takes.
pub const LEAST_JOINT_POSES: u16 = 50;
/// Fewest poses that the platen sensor's calibration takes.
pub const LEAST_PLATEN_POSES: u16 = LEAST_POSES as u16;
/// Two hours of self-motions.
pub const PLATEN_POSES: u16 = 20_000;
/// 2100-01-01: a date beyond it is a mistake.
const LATEST_UNIX_S: f32 = 4.1e9;

impl<C> Action<C> {
    /// Checks every number of the action.
    ///
    /// # Errors
    /// [`Refusal::Range`] for the first that cannot be used. A calibration is checked where it is decoded.
    pub fn validate(&self) -> Result<(), Refusal> {
        match self {
            Self::Calibrate(order) => order.validate(),
            Self::Read(Source::Slot(slot)) => {
                range(Field::Slot, f32::from(*slot), 0.0, (SLOTS - 1) as f32)
            }
            Self::MapBegin(header) | Self::MapStore { header, .. } => {
                header.validate().map_err(Refusal::Map)
            }
            Self::MapSlot(slot) | Self::MapForget(slot) | Self::MapAtMark { slot, .. } => {
                range(Field::Slot, f32::from(*slot), 0.0, (maps::SLOTS - 1) as f32)
            }
            Self::Stream(order) => order.validate(),
            Self::Record { samples } => {
                range(Field::Samples, *samples as f32, 1.0, u32::MAX as f32)
            }
            Self::SetTime { unix_s } => range(Field::UnixS, *unix_s as f32, 0.0, LATEST_UNIX_S),
            Self::GoTo {
                target,
                speed_m_per_s,
            } => {
                range(Field::XM, target.x_m, -1.0, 1.0)?;
                range(Field::YM, target.y_m, -1.0, 1.0)?;
                range(Field::ThetaRad, target.theta_rad, -0.06, 0.06)?;
                range(Field::SpeedMPerS, *speed_m_per_s, 1.0e-3, 1.5)
            }
            _ => Ok(()),
        }
    }
}

impl CalibrateOrder {
    fn validate(&self) -> Result<(), Refusal> {
        let (least, most) = match self.method {
            Method::Joint => (LEAST_JOINT_POSES, JOINT_POSES),
            Method::Platen => (LEAST_PLATEN_POSES, PLATEN_POSES),
        };
        range(Field::Poses, self.poses.into(), least.into(), most.into())?;
        range(Field::HeldOutPoses, self.held_out_poses.into(), 8.0, 1000.0)?;
        range(Field::TravelM, self.travel_m, 1.0e-3, 0.5)?;
        range(Field::TurnRad, self.turn_rad, 0.0, 0.06)?;
        range(Field::SpeedMPerS, self.speed_m_per_s, 1.0e-3, 1.5)?;
        range(Field::TargetDeviationM, self.target_deviation_m, 0.0, 1.0)
    }
}

impl StreamOrder {
    fn validate(&self) -> Result<(), Refusal> {
        range(
            Field::Channels,
            self.channels.into(),
            0.0,
            Channels::all().bits().into(),
        )?;
        // An order that ends the stream needs no decimation.
        let least = if self.channels == 0 { 0.0 } else { 1.0 };
        range(
            Field::Decimation,
            self.decimation.into(),
            least,
            u16::MAX.into(),
        )
    }
}

/// Not a number fails as well.
fn range(field: Field, value: f32, low: f32, high: f32) -> Result<(), Refusal> {
    if (low..=high).contains(&value) {
        Ok(())
    } else {
        Err(Refusal::Range {
            field,
            value,
            low,
            high,
        })
    }
}
