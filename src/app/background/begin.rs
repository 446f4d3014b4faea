//! How a calibration is begun by order, and ended by one.

use super::{Background, Errand};
use crate::calibration::joint::JointConfig;
use crate::calibration::record::Method;
use crate::calibration::{SessionConfig, StartError};
use crate::event_log::entry::Event;
use crate::frame::Status;
use crate::link::message::{Field, Refusal, StartRefusal};
use crate::model::TermTable;
use crate::range::OutOfRange;
use embedded_io::{Read, ReadReady, Write, WriteReady};
use embedded_storage::nor_flash::NorFlash;

impl<S, F> Background<'_, '_, S, F>
where
    S: Read + ReadReady + Write + WriteReady,
    F: NorFlash,
{
    /// Starts a self-calibration from where the courier stands. Geometry and model of `config` are replaced by those
    /// in force.
    ///
    /// # Errors
    /// [`Refusal`]; nothing is changed.
    #[inline(never)]
    pub fn calibrate(&mut self, config: &mut SessionConfig, errand: Errand) -> Result<(), Refusal> {
        self.may_calibrate()?;
        config.geometry = self.keeper.settings().geometry;
        config.validate().map_err(out_of_range)?;
        self.task.make_platen();
        self.keeper
            .model_to_fit(&mut config.model, TermTable::equation_3);
        self.task.start(config).map_err(not_started)?;
        self.begin(Method::Platen, errand);
        Ok(())
    }

    /// Starts a joint calibration of both sensors from where the courier stands, under a beacon. Geometry and model of
    /// `config` are replaced by those in force.
    ///
    /// # Errors
    /// [`Refusal`]; nothing is changed.
    #[inline(never)]
    pub fn calibrate_joint(
        &mut self,
        config: &mut JointConfig,
        errand: Errand,
    ) -> Result<(), Refusal> {
        self.may_calibrate()?;
        let status = self.last.status;
        if status.contains(Status::BEACON_MISSING) {
            return Err(Refusal::Start(StartRefusal::NoBeacon));
        }
        config.geometry = self.keeper.settings().geometry;
        config.validate().map_err(out_of_range)?;
        self.task.make_joint();
        self.keeper
            .model_to_fit(&mut config.model, TermTable::equation_9);
        self.task.start_joint(config).map_err(not_started)?;
        self.begin(Method::Joint, errand);
        Ok(())
    }

    fn begin(&mut self, method: Method, errand: Errand) {
        self.method = method;
        self.errand = errand;
        self.guide.forget_origin();
        self.ended = None;
        self.events.session_begun();
        self.log_event(&Event::CalibrationBegun(method));
    }

    /// Ends the session; the calibration in force stays.
    ///
    /// # Errors
    /// [`Refusal::NothingUnderWay`].
    pub fn abort(&mut self) -> Result<(), Refusal> {
        if !self.is_calibrating() {
            return Err(Refusal::NothingUnderWay);
        }
        self.task.abort();
        Ok(())
    }
}

fn not_started(error: StartError) -> Refusal {
    match error {
        StartError::Busy => Refusal::Busy,
        StartError::Terms => Refusal::Start(StartRefusal::Terms),
        StartError::Range(number) => out_of_range(number),
    }
}

fn out_of_range(number: OutOfRange) -> Refusal {
    let OutOfRange {
        name,
        value,
        low,
        high,
    } = number;
    match FIELDS.iter().find(|(known, _)| *known == name) {
        Some((_, field)) => Refusal::Range {
            field: *field,
            value,
            low,
            high,
        },
        None => Refusal::Start(StartRefusal::Settings),
    }
}

/// What a host can order, as a session names it.
const FIELDS: [(&str, Field); 4] = [
    ("poses", Field::Poses),
    ("held_out_poses", Field::HeldOutPoses),
    ("travel_m", Field::TravelM),
    ("turn_rad", Field::TurnRad),
];
