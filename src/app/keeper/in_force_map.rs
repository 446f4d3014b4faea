//! The tooth map in force: how a host loads one, what the interrupt has time for beside it, and how it goes.

use super::Keeper;
use crate::link::message::Refusal;
use crate::model::most_rows_beside_a_map;
use crate::teeth::{Grid, MapHeader};
use embedded_storage::nor_flash::NorFlash;

impl<F: NorFlash> Keeper<'_, '_, F> {
    /// Lattices of the tooth map in force.
    pub fn map(&self) -> Option<[Grid; 2]> {
        self.map
    }

    /// Begins to load a tooth map for the calibration in force.
    ///
    /// # Errors
    /// [`Refusal::NotCalibrated`]: a map is added to a calibration; [`Refusal::MapTooDear`], [`Refusal::MapBusy`], [`Refusal::Map`].
    pub fn map_begin(&mut self, header: &MapHeader) -> Result<(), Refusal> {
        if self.in_force.is_none() {
            return Err(Refusal::NotCalibrated);
        }
        self.afford_map()?;
        self.map_drop();
        self.is_map_ordered = true;
        let map = self.swap.map_mut().ok_or(Refusal::MapBusy)?;
        map.begin(header, &self.settings.geometry)
            .map_err(Refusal::Map)
    }

    /// Takes its next nodes.
    ///
    /// # Errors
    /// [`Refusal::MapBusy`], [`Refusal::Map`].
    pub fn map_nodes(&mut self, nodes_nm: &[i16]) -> Result<(), Refusal> {
        let map = self.swap.map_mut().ok_or(Refusal::MapBusy)?;
        map.extend(nodes_nm).map_err(Refusal::Map)
    }

    /// Puts it in force.
    ///
    /// # Errors
    /// [`Refusal::Map`] if nodes are missing, [`Refusal::MapTooDear`] beside what is in force by now, [`Refusal::MapBusy`].
    pub fn map_apply(&mut self) -> Result<(), Refusal> {
        self.afford_map()?;
        let map = self.swap.map_mut().ok_or(Refusal::MapBusy)?;
        map.complete().map_err(Refusal::Map)?;
        self.map_in_force()
    }

    /// Hands the map to the interrupt.
    pub(super) fn map_in_force(&mut self) -> Result<(), Refusal> {
        let map = self.swap.map_mut().ok_or(Refusal::MapBusy)?;
        let grids = *map.grids();
        self.swap.apply_map().map_err(|_| Refusal::MapBusy)?;
        self.map = Some(grids);
        self.note_outputs();
        Ok(())
    }

    /// Whether the interrupt has time for a map beside the model in force. A model that comes later ends the map.
    pub(super) fn afford_map(&self) -> Result<(), Refusal> {
        let most = most_rows_beside_a_map(self.settings.rate_hz);
        match self.further_rows() {
            found if found > most => Err(Refusal::MapTooDear {
                found: found as u8,
                most: most as u8,
            }),
            _ => Ok(()),
        }
    }

    /// Takes the tooth map out of force. If it was a stored one, the calibration's own settings come back by [`Keeper::go_on`].
    pub fn map_drop(&mut self) {
        self.is_to_restore |= self.is_layered;
        self.map_forget_in_force();
    }

    /// The same where settings follow.
    pub(super) fn map_forget_in_force(&mut self) {
        self.swap.recall_map();
        if self.map.is_some() {
            self.note_outputs();
        }
        (self.map, self.is_layered) = (None, false);
    }

    /// Leaves it to a host which map is in force, until another calibration comes in force or a map is stored.
    pub fn map_ordered(&mut self) {
        self.is_map_ordered = true;
    }

    /// Whether it is left to a host.
    pub fn is_map_ordered(&self) -> bool {
        self.is_map_ordered
    }
}
