//! What further rows and a tooth map cost the sampling interrupt, and how much it can hold. `cargo xtask bench` measures the figures.

use super::ErrorModel;

/// Clock of the board's processor, Hz.
const CLOCK_HZ: f32 = 170.0e6;
/// The interrupt with equations (3) and (9), cycles (measured: 1,112), and what each further row adds (measured: 601; ten of them are
/// within the two figures together). All of it runs in the CCM RAM, without wait states.
const STEP_CYCLES: f32 = 1200.0;
const ROW_CYCLES: f32 = 600.0;
/// What a tooth map adds, of as many nodes and waves as it may have, cycles (measured: 2,265).
const MAP_CYCLES: f32 = 2300.0;
/// All else that both sampling interrupts do: start the reading, check it, hand the frame on, entry and return, cycles (`cargo xtask chip
/// time`: 1,463 at most for the plain sample, of which `cargo xtask bench` gives 895 to the step).
const READING_CYCLES: f32 = 600.0;
/// Share of a sampling interval that the interrupt may take.
const SHARE: f32 = 0.9;

/// Most rows beyond equations (3) and (9) that the interrupt has time for.
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
    let room = SHARE * CLOCK_HZ / rate_hz - cycles;
    (room / ROW_CYCLES).max(0.0) as usize
}

impl ErrorModel {
    /// Rows beyond equations (3) and (9), which the interrupt evaluates one by one.
    #[must_use]
    pub fn further_rows(&self) -> usize {
        self.terms.iter().filter(|term| term.is_further()).count()
    }
}
