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

/// Words of a record: magic, cause, uptime, program counter, link register, length of the message, the message, check.
const WORDS: usize = HEAD_WORDS + MESSAGE_BYTES / 4 + 1;
const HEAD_WORDS: usize = 6;
const MESSAGE_BYTES: usize = 128;

#[unsafe(link_section = ".uninit.fault")]
static mut RECORD: MaybeUninit<[u32; WORDS]> = MaybeUninit::uninit();

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
#[inline(never)]
pub fn take(hardware: ResetCause) -> StartReport {
    let record: [u32; WORDS] = core::array::from_fn(|index| {
        // SAFETY: any bits are a valid word; magic and check tell whether somebody wrote them.
        unsafe { read_volatile(addr_of!(RECORD).cast::<u32>().add(index)) }
    });
    // SAFETY: the first word alone, so that the record is read once.
    unsafe { write_volatile(addr_of_mut!(RECORD).cast::<u32>(), 0) };
    let [
        magic,
        cause,
        uptime_s,
        program_counter,
        link_register,
        length,
        message @ ..,
        check,
    ] = record;
    let sum = record
        .iter()
        .take(WORDS - 1)
        .fold(SEED, |sum, word| mix(sum, *word));
    let known = KINDS.iter().find(|(kind, _)| *kind == cause);
    let kept = known.filter(|_| magic == MAGIC && check == sum);
    let cause = kept.map_or(hardware, |(_, cause)| *cause);
    let fault = (kept.is_some() && cause != ResetCause::Requested).then(|| {
        let mut text = String::new();
        let bytes = message.iter().flat_map(|word| word.to_le_bytes());
        for byte in bytes.take(length as usize) {
            // What was cut off in the middle of a character is not ASCII.
            let _ = text.push(char::from(byte & 0x7F));
        }
        FaultReport {
            cause,
            uptime_s,
            program_counter,
            link_register,
            message: text,
        }
    });
    StartReport { cause, fault }
}

/// Keeps a record for the next start. Little stack: there may be none left.
pub fn keep(cause: ResetCause, program_counter: u32, link_register: u32, message: &str) {
    let kind = KINDS
        .iter()
        .find(|(_, known)| *known == cause)
        .map_or(0, |(kind, _)| *kind);
    let length = message.len().min(MESSAGE_BYTES) as u32;
    let head = [
        MAGIC,
        kind,
        UPTIME_S.load(Relaxed),
        program_counter,
        link_register,
        length,
    ];
    let mut bytes = message.bytes();
    let mut sum = SEED;
    for index in 0..WORDS {
        let word = match head.get(index) {
            Some(word) => *word,
            None if index + 1 == WORDS => sum,
            None => {
                let mut four = || bytes.next().unwrap_or(0);
                u32::from_le_bytes([four(), four(), four(), four()])
            }
        };
        sum = mix(sum, word);
        // SAFETY: nobody else writes here: either the main loop ends now, or this is an exception that does not return.
        unsafe { write_volatile(addr_of_mut!(RECORD).cast::<u32>().add(index), word) };
    }
}

const SEED: u32 = 0x811C_9DC5;

/// A word further in the check (Fowler, Noll and Vo's hash).
fn mix(sum: u32, word: u32) -> u32 {
    (sum ^ word).wrapping_mul(0x0100_0193)
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
