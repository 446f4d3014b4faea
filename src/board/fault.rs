//! What is kept over a reset: why, when and where. It lies in RAM that start-up leaves alone.
#![allow(unsafe_code)] // memory outside the language's view, and exception handlers

use super::RAM_START;
use crate::app::restarts::{StartReport, faults_in_a_row, is_safe_mode, kept_row, own_row};
use crate::link::message::{FaultReport, Health, ResetCause};
use core::mem::MaybeUninit;
use core::panic::PanicInfo;
use core::ptr::{addr_of, addr_of_mut, read_volatile, write_volatile};
use core::sync::atomic::{AtomicU32, Ordering::Relaxed};
use cortex_m::peripheral::SCB;
use cortex_m_rt::ExceptionFrame;
use heapless::String;

/// Tells a record from what RAM holds after power-on.
const MAGIC: u32 = 0xC0FF_EE74;
/// In its place when there is none: RAM has kept what it held since a start.
const NO_RECORD: u32 = 0xC0FF_EE75;

/// Words of a record: magic, cause, uptime, program counter, link register, length of the message, the message, check.
const WORDS: usize = HEAD_WORDS + MESSAGE_BYTES / 4 + 1;
const HEAD_WORDS: usize = 6;
const MESSAGE_BYTES: usize = 128;

#[unsafe(link_section = ".uninit.fault")]
static mut RECORD: MaybeUninit<[u32; WORDS]> = MaybeUninit::uninit();

/// Faults in a row with the image that had them, and the same with every bit turned over: what RAM holds after power-on is no pair.
#[unsafe(link_section = ".uninit.fault")]
static mut IN_A_ROW: MaybeUninit<[u32; 2]> = MaybeUninit::uninit();

/// Seconds since start, for a record; kept by the main loop.
pub static UPTIME_S: AtomicU32 = AtomicU32::new(0);

/// Kinds of record. As numbers they outlive a firmware update.
const KINDS: [(u32, ResetCause); 4] = [
    (1, ResetCause::Panic),
    (2, ResetCause::HardFault),
    (3, ResetCause::Watchdog),
    (4, ResetCause::Requested),
];

/// Takes what was kept, and forgets it. `hardware` is the cause by the chip's own flags, which are the same for a brown-out and
/// for a supply that came: RAM tells them apart. `image`: its number, 0 for one that no update has installed.
#[inline(never)]
pub fn take(hardware: ResetCause, image: u32) -> StartReport {
    let record: [u32; WORDS] = core::array::from_fn(|index| {
        // SAFETY: any bits are a valid word; magic and check tell whether somebody wrote them.
        unsafe { read_volatile(addr_of!(RECORD).cast::<u32>().add(index)) }
    });
    // SAFETY: the first word alone, so that the record is read once.
    unsafe { write_volatile(addr_of_mut!(RECORD).cast::<u32>(), NO_RECORD) };
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
    let hardware = match hardware {
        ResetCause::BrownOut if magic != MAGIC && magic != NO_RECORD => ResetCause::PowerOn,
        known => known,
    };
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
    let faults = faults_in_a_row(in_a_row(image), cause);
    set_in_a_row(kept_row(faults, image));
    StartReport {
        cause,
        fault,
        health: Health {
            faults_in_a_row: faults,
            safe_mode: is_safe_mode(faults),
            ..Health::default()
        },
    }
}

/// Faults in a row of this image up to the start before; none if memory lost it.
fn in_a_row(image: u32) -> Option<u8> {
    let place = addr_of!(IN_A_ROW).cast::<u32>();
    // SAFETY: any bits are a valid word; the second tells whether somebody wrote the first.
    let [kept, turned] = unsafe { [read_volatile(place), read_volatile(place.add(1))] };
    own_row(kept, image).filter(|_| turned == !kept)
}

/// Keeps a row ([`kept_row`]): 0 after a time of service without a fault.
pub fn set_in_a_row(kept: u32) {
    let place = addr_of_mut!(IN_A_ROW).cast::<u32>();
    // SAFETY: the main loop alone writes here, and the start before it.
    unsafe {
        write_volatile(place, kept);
        write_volatile(place.add(1), !kept);
    }
}

/// Keeps a record for the next start. Little stack: there may be none left.
pub fn keep(cause: ResetCause, program_counter: u32, link_register: u32, message: &[u8]) {
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
    let mut bytes = message.iter().copied();
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

/// Text of a record in the making: bytes, since characters would bring their encoding along.
struct Text {
    bytes: [u8; MESSAGE_BYTES],
    length: usize,
}

impl Text {
    const fn new() -> Self {
        Self {
            bytes: [0; MESSAGE_BYTES],
            length: 0,
        }
    }

    /// Adds what there is room for.
    #[inline(never)]
    fn push(&mut self, more: &[u8]) {
        for byte in more {
            if let Some(place) = self.bytes.get_mut(self.length) {
                *place = *byte;
                self.length += 1;
            }
        }
    }

    /// Adds a number, decimal.
    fn push_number(&mut self, number: u32) {
        let mut digits = [0; 10];
        let (mut rest, mut first) = (number, digits.len());
        for (index, digit) in digits.iter_mut().enumerate().rev() {
            *digit = b'0' + (rest % 10) as u8;
            rest /= 10;
            first = index;
            if rest == 0 {
                break;
            }
        }
        self.push(digits.get(first..).unwrap_or_default());
    }

    fn get(&self) -> &[u8] {
        self.bytes.get(..self.length).unwrap_or_default()
    }
}

#[panic_handler]
fn panic(info: &PanicInfo<'_>) -> ! {
    let mut text = Text::new();
    // Place and fixed text alone: formatting the rest would bring 15 KiB of code along. What does not fit is cut off.
    if let Some(place) = info.location() {
        text.push(place.file().as_bytes());
        text.push(b":");
        text.push_number(place.line());
    }
    if let Some(fixed) = info.message().as_str() {
        text.push(b" ");
        text.push(fixed.as_bytes());
    }
    keep(ResetCause::Panic, 0, 0, text.get());
    SCB::sys_reset();
}

/// Floating-point context control register: lazy stacking and its state.
const LAZY_STACKING: u32 = 0xE000_EF34;
/// Stack that [`hard_fault`] must have; its own is a third of it (`cargo xtask firmware`).
const OWN_STACK: u32 = 512;

/// Hard, bus, usage and memory faults; a stack that ran over is one ([`guard`](super::guard)). Then the processor could not push
/// what it was at, and neither could a handler: it gets the stack from its top, as nothing goes on from here. Registers of
/// the floating point that wait to be pushed (LSPACT) are let go, or its first use of them would fault again.
#[unsafe(naked)]
#[unsafe(no_mangle)]
#[allow(non_snake_case)] // the vector's name
extern "C" fn HardFault() -> ! {
    core::arch::naked_asm!(
        "mrs r0, msp",
        "ldr r1, ={lowest}",
        "cmp r0, r1",
        "bhs 2f",
        "ldr r1, =_stack_start",
        "msr msp, r1",
        "ldr r1, ={lazy}",
        "movs r2, #0",
        "str r2, [r1]",
        "2:",
        "b {handler}",
        lowest = const RAM_START + OWN_STACK,
        lazy = const LAZY_STACKING,
        handler = sym hard_fault,
    )
}

/// Program counter and link register of what an exception interrupted, whose frame begins at `place`; zeros if that is no memory.
pub fn interrupted(place: u32) -> (u32, u32) {
    if place < RAM_START {
        return (0, 0);
    }
    // SAFETY: the processor pushed its registers there, in RAM.
    let frame = unsafe { &*(place as *const ExceptionFrame) };
    (frame.pc(), frame.lr())
}

/// Keeps the reason and restarts. `place` is where the processor pushed its registers, or tried to.
extern "C" fn hard_fault(place: u32) -> ! {
    // SAFETY: status registers of the processor, read only.
    let status = unsafe { (*cortex_m::peripheral::SCB::PTR).cfsr.read() };
    let mut text = Text::new();
    if place < RAM_START {
        text.push(b"stack overflow, ");
    }
    let (program_counter, link_register) = interrupted(place);
    text.push(b"fault status ");
    text.push_number(status);
    let cause = ResetCause::HardFault;
    keep(cause, program_counter, link_register, text.get());
    SCB::sys_reset();
}
