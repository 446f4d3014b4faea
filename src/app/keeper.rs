//! Which calibration is in force, and the two slots it may be stored in.
//!
//! In force means: the interrupt applies it. Every change is checked first, stored second and handed to the interrupt
//! third, so that a refusal at any step leaves both as they were.

use crate::calibration::record::Calibration;
use crate::calibration::slots::{Place, SLOTS, SlotError, SlotInfo, Slots};
use crate::link::message::{InForce, RecordRefusal, Refusal};
use crate::settings::Settings;
use crate::step::StepConfig;
use crate::swap::SwapSender;
use embedded_storage::nor_flash::NorFlash;

/// The calibration in force, the slots and the way to the interrupt.
pub struct Keeper<'q, 'c, F> {
    slots: Slots<F>,
    swap: SwapSender<'q, 'c>,
    /// In force; without the parts that a calibration brings: the board's own.
    settings: Settings,
    board: Settings,
    in_force: Option<Calibration>,
    stored: Option<Place>,
    boot: Result<(), Refusal>,
}

impl<'q, 'c, F: NorFlash> Keeper<'q, 'c, F> {
    /// Puts the newest stored record in force, or `board`'s own settings where there is none that can be used.
    pub fn start(slots: Slots<F>, swap: SwapSender<'q, 'c>, board: Settings) -> Self {
        let settings = board.clone();
        let mut keeper = Self {
            slots,
            swap,
            settings,
            board,
            in_force: None,
            stored: None,
            boot: Ok(()),
        };
        keeper.boot = keeper.load_stored();
        keeper
    }

    /// How loading the stored calibration went at start-up.
    pub fn boot(&self) -> &Result<(), Refusal> {
        &self.boot
    }

    /// Settings in force.
    pub fn settings(&self) -> &Settings {
        &self.settings
    }

    /// The calibration in force.
    pub fn in_force(&self) -> Option<&Calibration> {
        self.in_force.as_ref()
    }

    /// Where the calibration in force is from.
    pub fn source(&self) -> InForce {
        match (&self.in_force, self.stored) {
            (None, _) => InForce::None,
            (Some(_), None) => InForce::Unsaved,
            (Some(_), Some(place)) => InForce::Stored(place),
        }
    }

    /// What both slots hold.
    pub fn list(&mut self) -> [SlotInfo; SLOTS] {
        self.slots.list()
    }

    /// One slot's calibration.
    ///
    /// # Errors
    /// [`Refusal::Slots`].
    pub fn read(&mut self, slot: u8) -> Result<Calibration, Refusal> {
        Ok(self.slots.read(slot)?.1)
    }

    /// Puts a calibration in force without storing it.
    ///
    /// # Errors
    /// [`Refusal::Calibration`], [`Refusal::SwapBusy`].
    pub fn load(&mut self, calibration: Calibration) -> Result<(), Refusal> {
        let (settings, config) = self.checked(&calibration)?;
        self.swap.offer(&config).map_err(|_| Refusal::SwapBusy)?;
        self.adopt(calibration, settings, None);
        Ok(())
    }

    /// Stores a calibration and puts it in force.
    ///
    /// # Errors
    /// As [`Keeper::load`], and [`Refusal::Slots`].
    pub fn store(&mut self, calibration: Calibration) -> Result<Place, Refusal> {
        let (settings, config) = self.checked(&calibration)?;
        if !self.swap.taken() {
            return Err(Refusal::SwapBusy);
        }
        let place = self.slots.commit(&calibration, false)?;
        // The interrupt's end was free a moment ago and only this end can have filled it.
        self.swap.offer(&config).map_err(|_| Refusal::SwapBusy)?;
        self.adopt(calibration, settings, Some(place));
        Ok(place)
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

    fn load_stored(&mut self) -> Result<(), Refusal> {
        match self.slots.load() {
            Ok((place, calibration)) => {
                self.load(calibration)?;
                self.stored = Some(place);
                Ok(())
            }
            Err(error) => {
                let config = StepConfig::build(&self.board).map_err(|_| INVALID)?;
                self.swap.offer(&config).map_err(|_| Refusal::SwapBusy)?;
                (self.in_force, self.stored) = (None, None);
                self.settings = self.board.clone();
                match error {
                    // A new board: nothing was lost.
                    SlotError::NoneInForce => Err(Refusal::NotCalibrated),
                    other => Err(other.into()),
                }
            }
        }
    }

    fn checked(&self, calibration: &Calibration) -> Result<(Settings, StepConfig), Refusal> {
        let settings = Settings {
            geometry: calibration.geometry,
            pairs: calibration.pairs,
            model: Some(calibration.model.clone()),
            ..self.board.clone()
        };
        let config = StepConfig::build(&settings).map_err(|_| INVALID)?;
        Ok((settings, config))
    }

    fn adopt(&mut self, calibration: Calibration, settings: Settings, stored: Option<Place>) {
        self.settings = settings;
        self.in_force = Some(calibration);
        self.stored = stored;
    }
}

const INVALID: Refusal = Refusal::Calibration(RecordRefusal::Invalid);
