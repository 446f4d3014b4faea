//! Which calibration is in force, and the two slots it may be stored in.
//!
//! In force means: the interrupt applies it. Every change is checked first, stored second and handed to the interrupt
//! third, so that a refusal at any step leaves both as they were.

pub mod entries;
mod in_force_map;
pub mod kept;
mod maps;
pub mod mode;

use crate::beacon::BeaconSettings;
use crate::calibration::record::{Calibration, check_sensor};
use crate::calibration::slots::{Place, SLOTS, SlotError, SlotInfo, Slots};
use crate::device::Device;
use crate::frame::SEGMENTS;
use crate::geometry::Geometry;
use crate::link::message::{InForce, RecordRefusal, Refusal};
use crate::maps::Writing;
use crate::model::{ErrorModel, TermTable, most_further_rows};
use crate::quadrature::PairCorrection;
use crate::settings::Settings;
use crate::swap::SwapSender;
use crate::teeth::Grid;
use embedded_storage::nor_flash::NorFlash;

/// The calibration in force, the slots and the way to the interrupt.
pub struct Keeper<'q, 'c, F> {
    slots: Slots<F>,
    swap: SwapSender<'q, 'c>,
    /// In force.
    settings: Settings,
    /// The board's own, in force without a calibration.
    board: (Geometry, [PairCorrection; SEGMENTS]),
    /// Whose records count.
    device: Device,
    in_force: Option<Calibration>,
    stored: Option<Place>,
    boot: Result<(), Refusal>,
    map: Option<[Grid; 2]>,
    /// The map in force is a stored one, and the settings are its own above the calibration's.
    is_layered: bool,
    /// A host decides which map is in force, until another calibration comes in force or a map is stored.
    is_map_ordered: bool,
    /// A map that is being stored.
    storing: Option<Writing>,
    /// A map was stored, or was not: the stored calibration is to come back, for which the map's model stood in.
    is_to_return: bool,
    /// The settings in force are a map's that is gone: the calibration's are to come back.
    is_to_restore: bool,
    /// Counts changes of what is stored or in force.
    changes: u8,
    /// Counts changes of the calibrated outputs.
    outputs: u8,
}

impl<'q, 'c, F: NorFlash> Keeper<'q, 'c, F> {
    /// Nothing in force but the own settings of the board `device`, without a model; [`Keeper::start`] looks into the slots.
    pub fn new(
        mut slots: Slots<F>,
        swap: SwapSender<'q, 'c>,
        board: Settings,
        device: Device,
    ) -> Self {
        slots.set_owner(device);
        Self {
            device,
            slots,
            swap,
            board: (board.geometry, board.pairs),
            settings: board,
            in_force: None,
            stored: None,
            boot: Err(Refusal::NotCalibrated),
            map: None,
            is_layered: false,
            is_map_ordered: false,
            storing: None,
            is_to_return: false,
            is_to_restore: false,
            outputs: 0,
            changes: 0,
        }
    }

    /// Puts the newest stored record in force, or the board's own settings where there is none that can be used, and in safe mode.
    pub fn start(&mut self, safe_mode: bool) {
        self.boot = match safe_mode {
            true => Err(Refusal::SafeMode),
            false => self.load_stored(),
        };
    }

    /// How loading the stored calibration went at start-up.
    pub fn boot(&self) -> Result<(), Refusal> {
        self.boot
    }

    /// Whether the interrupt has taken what was put in force last, one sample after it was, and nothing is to follow it. Until then nothing
    /// else can be put in force.
    pub fn is_taken(&mut self) -> bool {
        !(self.is_to_return || self.is_to_restore) && self.swap.taken()
    }

    /// Settings in force.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The calibration in force.
    pub fn in_force(&self) -> Option<&Calibration> {
        self.in_force.as_ref()
    }

    /// The board itself: only its calibrations can come in force.
    pub fn device(&self) -> Device {
        self.device
    }

    /// Where the calibration in force is from.
    pub fn source(&self) -> InForce {
        match (&self.in_force, self.stored) {
            (None, _) => InForce::None,
            (Some(_), None) => InForce::Unsaved,
            (Some(_), Some(place)) => InForce::Stored(place),
        }
    }

    /// The model that a calibration is to fit: the one in force, or zeros.
    #[inline(never)]
    pub fn model_to_fit(&self, model: &mut ErrorModel, fresh: fn() -> TermTable) {
        match &self.settings.model {
            Some(in_force) => model.clone_from(in_force),
            None => *model = ErrorModel::zero(fresh()),
        }
    }

    /// What both slots hold.
    pub fn list(&mut self) -> [SlotInfo; SLOTS] {
        self.slots.list()
    }

    /// One slot's calibration; on an error `to` is of no use.
    ///
    /// # Errors
    /// [`Refusal::Slots`].
    pub fn read(&mut self, slot: u8, to: &mut Calibration) -> Result<Place, Refusal> {
        Ok(self.slots.read_into(slot, to)?)
    }

    /// The flash that the slots are in.
    pub fn flash_mut(&mut self) -> &mut F {
        self.slots.flash_mut()
    }

    /// Puts a calibration in force without storing it.
    ///
    /// # Errors
    /// [`Refusal::Calibration`], [`Refusal::SwapBusy`].
    pub fn load(&mut self, calibration: &Calibration) -> Result<(), Refusal> {
        self.prepare(calibration)?;
        self.adopt(calibration, None)
    }

    /// Stores a calibration and puts it in force.
    ///
    /// # Errors
    /// As [`Keeper::load`], and [`Refusal::Slots`].
    pub fn store(&mut self, calibration: &Calibration) -> Result<Place, Refusal> {
        self.prepare(calibration)?;
        match self.slots.commit(calibration, false) {
            Ok(place) => self.adopt(calibration, Some(place)).map(|()| place),
            Err(error) => {
                self.restore_settings();
                Err(error.into())
            }
        }
    }

    /// Stores what is in force. `lose_unknown` as in [`Slots::commit`].
    ///
    /// # Errors
    /// [`Refusal::NotCalibrated`], [`Refusal::AlreadyStored`], [`Refusal::Slots`].
    pub fn commit(&mut self, lose_unknown: bool) -> Result<Place, Refusal> {
        let calibration = self.in_force.as_ref().ok_or(Refusal::NotCalibrated)?;
        if let Some(place) = self.stored {
            return Err(Refusal::AlreadyStored(place));
        }
        let place = self.slots.commit(calibration, lose_unknown)?;
        self.stored = Some(place);
        self.note_change();
        Ok(place)
    }

    /// Goes back to the stored calibration before the newest, and puts it in force.
    ///
    /// # Errors
    /// [`Refusal::Slots`], [`Refusal::SwapBusy`].
    pub fn roll_back(&mut self) -> Result<Place, Refusal> {
        if !self.swap.taken() {
            return Err(Refusal::SwapBusy);
        }
        let place = self.slots.roll_back()?;
        self.load_stored()?;
        Ok(place)
    }

    /// Counts changes of what is stored or in force: who follows the maps looks again when it differs.
    pub fn changes(&self) -> u8 {
        self.changes
    }

    /// Counts what changes the calibrated outputs: another calibration in force, or none, or a tooth map that comes or goes.
    pub fn outputs(&self) -> u8 {
        self.outputs
    }

    fn note_outputs(&mut self) {
        self.outputs = self.outputs.wrapping_add(1);
    }

    fn note_change(&mut self) {
        self.is_map_ordered = false;
        self.changes = self.changes.wrapping_add(1);
    }

    fn load_stored(&mut self) -> Result<(), Refusal> {
        let error = match self.load_newest() {
            Ok(result) => return result,
            Err(error) => error,
        };
        self.map_forget_in_force();
        self.note_change();
        self.in_force = None;
        self.restore_settings();
        self.build()?;
        self.stored = None;
        self.note_outputs();
        self.swap.send().map_err(|_| Refusal::SwapBusy)?;
        match error {
            // A new board: nothing was lost.
            SlotError::NoneInForce => Err(Refusal::NotCalibrated),
            other => Err(other.into()),
        }
    }

    /// Puts the newest stored record in force, if there is one: how that went.
    #[inline(never)] // a calibration on the stack
    fn load_newest(&mut self) -> Result<Result<(), Refusal>, SlotError> {
        let mut calibration = Calibration::identity(self.board.0);
        let place = self.slots.load_into(&mut calibration)?;
        let prepared = self.prepare(&calibration);
        Ok(prepared.and_then(|()| self.adopt(&calibration, Some(place))))
    }

    /// Brings settings and spare set to a calibration; where that cannot be done, the settings stay as they were.
    fn prepare(&mut self, calibration: &Calibration) -> Result<(), Refusal> {
        if calibration.device != self.device {
            let other = RecordRefusal::OtherDevice(calibration.device);
            return Err(Refusal::Calibration(other));
        }
        check_sensor(calibration, &self.board.0).map_err(|_| INVALID)?;
        apply(&mut self.settings, calibration);
        self.build().inspect_err(|_| self.restore_settings())
    }

    /// Rows of the settings' model beyond equations (3) and (9).
    fn further_rows(&self) -> usize {
        let model = self.settings.model.as_ref();
        model.map_or(0, ErrorModel::further_rows)
    }

    /// Writes the spare set by the settings.
    fn build(&mut self) -> Result<(), Refusal> {
        let most = most_further_rows(self.settings.rate_hz);
        if self.further_rows() > most {
            let [found, most] = [self.further_rows(), most].map(|n| n as u8);
            return Err(Refusal::TooDear { found, most });
        }
        let spare = self.swap.spare().map_err(|_| Refusal::SwapBusy)?;
        spare.set(&self.settings).map_err(|_| INVALID)
    }

    /// Hands the prepared set to the interrupt.
    #[inline(never)]
    fn adopt(&mut self, calibration: &Calibration, stored: Option<Place>) -> Result<(), Refusal> {
        // The spare set was there when it was prepared, and only this end can have sent it.
        self.swap.send().map_err(|_| Refusal::SwapBusy)?;
        // A map was estimated with the calibration before.
        self.map_forget_in_force();
        self.note_change();
        self.is_to_restore = false;
        self.in_force = Some(calibration.clone());
        self.stored = stored;
        self.note_outputs();
        Ok(())
    }

    /// Settings as in force.
    fn restore_settings(&mut self) {
        match &self.in_force {
            Some(calibration) => apply(&mut self.settings, calibration),
            None => {
                (self.settings.geometry, self.settings.pairs) = self.board;
                self.settings.model = None;
                self.settings.beacon = None;
                self.settings.drifted = false;
            }
        }
    }
}

fn apply(settings: &mut Settings, calibration: &Calibration) {
    settings.drifted = false;
    settings.geometry = calibration.geometry;
    settings.pairs = calibration.pairs;
    settings.model = Some(calibration.model.clone());
    settings.beacon = calibration.beacon.as_ref().map(|beacon| BeaconSettings {
        origin_teeth: beacon.origin_teeth,
        origin_m: beacon.origin_m,
        sensor: beacon.sensor,
        segment_sd_m: beacon.segment_sd_m,
        displacement_sd_m: beacon.displacement_sd_m,
    });
}

const INVALID: Refusal = Refusal::Calibration(RecordRefusal::Invalid);
