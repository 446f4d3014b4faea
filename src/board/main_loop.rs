//! The main loop of every board: everything below the sampling interrupt.

pub use super::hang::WATCHDOG_MS;
use super::rtt::Rings;
use super::{fault, hang};
use crate::app::background::Background;
use crate::app::console::Console;
use crate::app::restarts::SERVICE_S;
pub use crate::drivers::converter::timing::RATE_HZ;
use crate::frame::Status;
use crate::link::message::ResetCause;
use core::sync::atomic::Ordering::Relaxed;
use embedded_io::{Read, ReadReady, Write, WriteReady};
use embedded_storage::nor_flash::NorFlash;

/// Samples between two looks at what changes slowly: 100 ms.
const SLOW_SAMPLES: u32 = RATE_HZ / 10;

/// From the reply to a restart until the restart, 20 ms: the host takes the reply out of RAM meanwhile.
const FAREWELL_SAMPLES: u32 = RATE_HZ / 50;

/// What the loop needs of a board. Invariants: nothing here waits, but [`Board::sleep`] until the next interrupt.
pub trait Board {
    /// Feeds the watchdog.
    fn feed(&mut self);
    /// Calls the sampling interrupt by hand if the converter has been silent for some instants.
    fn wake_silent_converter(&mut self);
    /// Switches the status LED.
    fn set_led(&mut self, on: bool);
    /// Board temperature, where there is a new one.
    fn temperature_c(&mut self) -> Option<f32>;
    /// Conversions that BUSY has not answered with a pulse, since start, where a board counts them. To be called twice a second at least.
    fn unanswered(&mut self) -> Option<i32>;
    /// Whether the input of a reference mark is on; never, where a board has none.
    fn at_mark(&mut self) -> bool;
    /// Sleeps until an interrupt has been served.
    fn sleep(&mut self);
}

/// Runs for ever. The watchdog is fed only if, since the last time, the interrupt has sampled and the background has come
/// round.
pub fn run<S, F>(
    mut board: impl Board,
    background: &mut Background<'_, '_, S, F>,
    console: &mut Console<'_, Rings>,
) -> !
where
    S: Read + ReadReady + Write + WriteReady,
    F: NorFlash,
{
    background.start(console.is_safe_mode());
    let mailbox = background.mailbox();
    let (mut fed_at, mut slow_at) = (mailbox.samples(), mailbox.samples());
    let (mut said, mut restart_at) = (Status::empty(), None);
    loop {
        background.set_at_mark(board.at_mark());
        let taken = background.poll();
        console.serve(background);
        let worked = background.work();
        let samples = mailbox.samples();
        if console.wants_restart() {
            let since = samples.wrapping_sub(*restart_at.get_or_insert(samples));
            if since >= FAREWELL_SAMPLES {
                restart();
            }
        }
        if samples != fed_at {
            fed_at = samples;
            board.feed();
            hang::note_progress();
        }
        if samples.wrapping_sub(slow_at) >= SLOW_SAMPLES {
            slow_at = samples;
            let uptime_s = background.time().uptime_s;
            fault::UPTIME_S.store(uptime_s, Relaxed);
            if uptime_s >= SERVICE_S {
                fault::set_in_a_row(0);
            }
            if background.is_trial_over() {
                restart();
            }
            if let Some(temperature_c) = board.temperature_c() {
                background.set_temperature_c(temperature_c);
            }
            if let Some(conversions) = board.unanswered() {
                console.note_unanswered(conversions);
            }
            background.keep_events(console.started());
            said = show(&mut board, background.last_frame().status, said, samples);
        }
        board.wake_silent_converter();
        if taken == 0 && !worked {
            board.sleep();
        }
    }
}

fn restart() -> ! {
    fault::keep(ResetCause::Requested, 0, 0, b"");
    cortex_m::peripheral::SCB::sys_reset()
}

/// LED: on when all is well, blinking without a calibration that holds, dark at a fault. Changes are logged.
fn show(board: &mut impl Board, status: Status, said: Status, samples: u32) -> Status {
    let blink = samples / (5 * SLOW_SAMPLES) % 2 == 0;
    board.set_led(match status {
        s if s.is_empty() => true,
        s if Status::UNCALIBRATED
            .union(Status::CALIBRATION_DRIFT)
            .contains(s) =>
        {
            blink
        }
        _ => false,
    });
    if status != said {
        defmt::info!(
            "status {=u32:#x}, was {=u32:#x}",
            status.bits(),
            said.bits()
        );
    }
    status
}
