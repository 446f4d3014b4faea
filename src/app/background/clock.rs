//! The background's time and temperature.

use super::Background;
use crate::calibration::record::Instant;
use embedded_io::{Read, ReadReady, Write, WriteReady};
use embedded_storage::nor_flash::NorFlash;

impl<S, F> Background<'_, '_, S, F>
where
    S: Read + ReadReady + Write + WriteReady,
    F: NorFlash,
{
    /// Tells the board's temperature, from which the temperature terms count.
    pub fn set_temperature_c(&mut self, temperature_c: f32) {
        self.temperature_c = Some(temperature_c);
        let reference_c = self.reference_c();
        self.mailbox
            .set_temperature_delta_k(temperature_c - reference_c);
    }

    /// Board temperature, if it is measured.
    pub fn temperature_c(&self) -> Option<f32> {
        self.temperature_c
    }

    /// Tells the time of day, seconds since 1970 UTC.
    pub fn set_time(&mut self, unix_s: u64) {
        self.unix_offset_s = Some(unix_s.saturating_sub(self.uptime_s()));
    }

    /// Uptime, by the samples that came up the queue, and the date if it was told.
    pub fn time(&self) -> Instant {
        let uptime_s = self.uptime_s();
        Instant {
            unix_s: self
                .unix_offset_s
                .map(|offset| offset.saturating_add(uptime_s)),
            uptime_s: u32::try_from(uptime_s).unwrap_or(u32::MAX),
        }
    }

    fn uptime_s(&self) -> u64 {
        (self.samples as f32 / self.keeper.settings().rate_hz) as u64
    }

    pub(super) fn reference_c(&self) -> f32 {
        let measured = self.temperature_c.unwrap_or_default();
        self.keeper
            .in_force()
            .map_or(measured, |calibration| calibration.temperature_c)
    }
}
