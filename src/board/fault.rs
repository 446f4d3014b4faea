//! What is kept over a reset: why, when and where. It lies in RAM that start-up leaves alone.
#![allow(unsafe_code)] // memory outside the language's view, and exception handlers

use crate::app::console::StartReport;
use crate::link::message::{FaultReport, ResetCause};
use core::mem::MaybeUninit;
use core::panic::PanicInfo;
use core::ptr::{addr_of, addr_of_mut, read_volatile, write_volatile};
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use cortex_m::peripheral::SCB;
use cortex_m_rt::{ExceptionFrame, exception};
use heapless::String;

/// Tells a record from what RAM holds after power-on.
const MAGIC: u32 = 0xC0FF_EE74;

#[derive(Clone, Copy)]
#[repr(C)]
struct Record {
    magic: u32,
    cause: u32,
    uptime_s: u32,
    program_counter: u32,
    link_register: u32,
    length: u32,
    message: [u8; 128],
    check: u32,
}

#[unsafe(link_section = ".uninit.fault")]
static mut RECORD: MaybeUninit<Record> = MaybeUninit::uninit();

/// Seconds since start, for a record; kept by the main loop.
pub static UPTIME_S: AtomicU32 = AtomicU32::new(0);

/// Kinds of record. As numbers they outlive a firmware update.
const KINDS: [(u32, ResetCause); 4] = [
    (1, ResetCause::Panic),
    (2, ResetCause::HardFault),
    (3, ResetCause::Watchdog),
    (4, ResetCause::Requested),
];

/// Takes what was kept, and forgets it. `hardware` is the cause by the chip's own flags.
pub fn take(hardware: ResetCause) -> StartReport {
    // SAFETY: any bits are a valid record; magic and check tell whether somebody wrote them.
    let record = unsafe { read_volatile(addr_of!(RECORD).cast::<Record>()) };
    // SAFETY: the first word alone, so that the record is read once.
    unsafe { write_volatile(addr_of_mut!(RECORD).cast::<u32>(), 0) };
    let kept = KINDS.iter().find(|(kind, _)| *kind == record.cause);
    let Some((_, cause)) = kept.filter(|_| record.magic == MAGIC && record.check == check(&record))
    else {
        return StartReport {
            cause: hardware,
            fault: None,
        };
    };
    if *cause == ResetCause::Requested {
        return StartReport {
            cause: *cause,
            fault: None,
        };
    }
    let text = record.message.get(..record.length as usize).unwrap_or(&[]);
    let mut message = String::new();
    let _ = message.push_str(core::str::from_utf8(text).unwrap_or(""));
    let fault = FaultReport {
        cause: *cause,
        uptime_s: record.uptime_s,
        program_counter: record.program_counter,
        link_register: record.link_register,
        message,
    };
    StartReport {
        cause: *cause,
        fault: Some(fault),
    }
}

/// Keeps a record for the next start.
pub fn keep(cause: ResetCause, program_counter: u32, link_register: u32, message: &str) {
    let kind = KINDS
        .iter()
        .find(|(_, known)| *known == cause)
        .map_or(0, |(kind, _)| *kind);
    let mut record = Record {
        magic: MAGIC,
        cause: kind,
        uptime_s: UPTIME_S.load(Relaxed),
        program_counter,
        link_register,
        length: 0,
        message: [0; 128],
        check: 0,
    };
    for (place, byte) in record.message.iter_mut().zip(message.bytes()) {
        *place = byte;
        record.length += 1;
    }
    record.check = check(&record);
    // SAFETY: nobody else writes here: either the main loop ends now, or this is an exception that does not return.
    unsafe { write_volatile(addr_of_mut!(RECORD).cast::<Record>(), record) };
}

fn check(record: &Record) -> u32 {
    let words = [
        record.magic,
        record.cause,
        record.uptime_s,
        record.program_counter,
        record.link_register,
        record.length,
    ];
    let bytes = record.message.iter().map(|byte| u32::from(*byte));
    words
        .into_iter()
        .chain(bytes)
        .fold(0x811C_9DC5, |hash, word| {
            (hash ^ word).wrapping_mul(0x0100_0193)
        })
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    let mut text: String<128> = String::new();
    // Place and fixed text alone: formatting the rest would bring 15 KiB of code along. What does not fit is cut off.
    if let Some(place) = info.location() {
        push(&mut text, place.file());
        push(&mut text, ":");
        push_number(&mut text, place.line());
    }
    if let Some(fixed) = info.message().as_str() {
        push(&mut text, " ");
        push(&mut text, fixed);
    }
    keep(ResetCause::Panic, 0, 0, &text);
    SCB::sys_reset();
}

/// Hard, bus, usage and memory faults; a stack that ran over is one, since RAM ends below it.
#[exception]
unsafe fn HardFault(frame: &ExceptionFrame) -> ! {
    // SAFETY: status registers of the processor, read only.
    let status = unsafe { (*cortex_m::peripheral::SCB::PTR).cfsr.read() };
    let mut text: String<128> = String::new();
    push(&mut text, "fault status ");
    push_number(&mut text, status);
    keep(ResetCause::HardFault, frame.pc(), frame.lr(), &text);
    SCB::sys_reset();
}

fn push(text: &mut String<128>, more: &str) {
    for character in more.chars() {
        let _ = text.push(character);
    }
}

/// Decimal.
fn push_number(text: &mut String<128>, number: u32) {
    let mut digits = [0; 10];
    let (mut rest, mut used) = (number, 0);
    for place in &mut digits {
        *place = b'0' + (rest % 10) as u8;
        rest /= 10;
        used += 1;
        if rest == 0 {
            break;
        }
    }
    for digit in digits.iter().take(used).rev() {
        let _ = text.push(char::from(*digit));
    }
}
