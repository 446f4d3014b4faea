//! The intake's interrupt: the processor's pendable one (PendSV), below all others. Each sample calls it.
#![allow(unsafe_code)] // an exception handler

use super::interrupt::{INTAKE as PRIORITY, Owned};
use super::once::Once;
use super::rtt::Stream;
use crate::app::intake::Intake;
use core::mem::MaybeUninit;
use cortex_m::peripheral::scb::SystemHandler;
use cortex_m::peripheral::{Peripherals, SCB};
use cortex_m_rt::exception;

type Own = Intake<'static, 'static, Stream>;

/// Where it lies: by this name the linker puts it into the CCM RAM (`memory.x`).
static PLACE: Once<MaybeUninit<Own>> = Once::new(MaybeUninit::uninit());
/// What the interrupt owns.
static INTAKE: Owned<&'static mut Own> = Owned::empty();

/// Gives the interrupt what it owns. To be called once, before sampling begins.
///
/// # Panics
/// On a second call.
pub fn start(intake: Own) {
    let place = PLACE.take().expect("called once");
    // SAFETY: nobody calls the interrupt before sampling begins; its priority is its own.
    unsafe {
        INTAKE.put(place.write(intake));
        let mut processor = Peripherals::steal();
        processor.SCB.set_priority(SystemHandler::PendSV, PRIORITY);
    }
}

/// Calls it: it runs when no interrupt above it does. For the sampling interrupt, at its end.
#[inline(always)]
pub fn isr_call() {
    SCB::set_pendsv();
}

#[exception]
fn PendSV() {
    // SAFETY: this interrupt owns it.
    if let Some(intake) = unsafe { INTAKE.get() } {
        intake.run();
    }
}
