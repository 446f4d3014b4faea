//! What further rows and a tooth map cost the sampling interrupt, and how much it can hold. `cargo xtask bench` measures the figures.

use super::ErrorModel;

/// Clock of the board's processor, Hz. By definition of the board's set-up (`board::g474::clocks`).
const CLOCK_HZ: f32 = 170.0e6;
/// The interrupt with equations (3) and (9), cycles (measured: 1,115). All of it runs in the CCM RAM, without wait states.
const STEP_CYCLES: f32 = 1200.0;
/// What further rows add, however many there are: multiples of the own phase up to the highest order, 16, and of the lateral phase, cycles
/// (measured: 1,087).
const FURTHER_CYCLES: f32 = 1100.0;
/// What each further row adds, whatever its orders and factors, cycles (measured: 123).
const ROW_CYCLES: f32 = 125.0;
/// What a tooth map adds, of as many nodes and waves as it may have, cycles (measured: 2,266).
const MAP_CYCLES: f32 = 2300.0;
/// All else that both sampling interrupts do: start the reading, check it, hand the frame on, entry and return, cycles. As was
/// measured by `cargo xtask chip time`, 1,463 at most for the plain sample, of which `cargo xtask bench` gives 899 to the step:
/// 564.
const READING_CYCLES: f32 = 600.0;
/// What is left of each sample to the intake of frames and the background, cycles. As is measured by `cargo xtask chip stream`:
/// with 2,290 every frame is taken up, and sent as a recording wants it.
pub const BACKGROUND_CYCLES: u32 = 2290;

/// Most rows beyond equations (3) and (9) that the interrupt has time for; a table may have room for fewer.
#[must_use]
pub fn most_further_rows(rate_hz: f32) -> usize {
    rows_beside(READING_CYCLES + STEP_CYCLES, rate_hz)
}

/// The same with a tooth map in force.
#[must_use]
pub fn most_rows_beside_a_map(rate_hz: f32) -> usize {
    rows_beside(READING_CYCLES + STEP_CYCLES + MAP_CYCLES, rate_hz)
}

fn rows_beside(cycles: f32, rate_hz: f32) -> usize {
    let needed = cycles + FURTHER_CYCLES + BACKGROUND_CYCLES as f32;
    let room = CLOCK_HZ / rate_hz - needed;
    (room / ROW_CYCLES).max(0.0) as usize
}

impl ErrorModel {
    /// Rows beyond equations (3) and (9), which the interrupt evaluates one by one.
    #[must_use]
    pub fn further_rows(&self) -> usize {
        self.terms.iter().filter(|term| term.is_further()).count()
    }
}
