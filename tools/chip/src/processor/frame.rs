//! What the processor pushes at an exception and takes back at its return (ARMv7-M ARM, B1.5.6 to B1.5.8).
//!
//! Floating-point registers are pushed at once where the processor would only keep room for them; what the code sees is the same.

use unicorn_engine::{RegisterARM as Reg, Unicorn};

/// Words of both kinds of frame.
const BASIC: u32 = 8;
const EXTENDED: u32 = 26;
/// The bit of the pushed program status that tells of a word of padding.
const PADDED: u32 = 1 << 9;
/// CONTROL: process stack in use, floating-point registers in use.
const SPSEL: u32 = 1 << 1;
const FPCA: u32 = 1 << 2;
/// The part of the program status that is the number of the exception.
const NUMBER: u32 = 0x1FF;

/// Floating-point registers that an exception pushes.
pub const SINGLES: [Reg; 16] = [
    Reg::S0,
    Reg::S1,
    Reg::S2,
    Reg::S3,
    Reg::S4,
    Reg::S5,
    Reg::S6,
    Reg::S7,
    Reg::S8,
    Reg::S9,
    Reg::S10,
    Reg::S11,
    Reg::S12,
    Reg::S13,
    Reg::S14,
    Reg::S15,
];

/// A register.
pub fn get<D>(uc: &Unicorn<'_, D>, register: Reg) -> u32 {
    uc.reg_read(register).expect("the processor has it") as u32
}

/// Sets a register.
pub fn set<D>(uc: &mut Unicorn<'_, D>, register: Reg, value: u32) {
    uc.reg_write(register, u64::from(value))
        .expect("the processor has it");
}

/// The flags' register makes unicorn look anew at mode and floating-point state.
fn refresh<D>(uc: &mut Unicorn<'_, D>) {
    let flags = get(uc, Reg::XPSR);
    set(uc, Reg::APSR_NZCV, flags);
}

/// Changes the number of the running exception; 0 is none.
fn set_number<D>(uc: &mut Unicorn<'_, D>, number: u32) {
    set(uc, Reg::IPSR, number);
    refresh(uc);
}

/// Pushes a frame and enters the handler at `vector`. Whether the frame could be pushed.
pub fn enter<D>(uc: &mut Unicorn<'_, D>, exception: u16, vector: u32) -> bool {
    let control = get(uc, Reg::CONTROL);
    let status = get(uc, Reg::XPSR);
    let in_handler = status & NUMBER != 0;
    let extended = control & FPCA != 0;
    let mut words = vec![];
    for register in [Reg::R0, Reg::R1, Reg::R2, Reg::R3, Reg::R12, Reg::LR] {
        words.push(get(uc, register));
    }
    words.push(get(uc, Reg::PC) & !1);
    let size = 4 * if extended { EXTENDED } else { BASIC };
    let top = get(uc, Reg::SP);
    let aligned = (top - size) & !7;
    let padding = if top & 4 != 0 { PADDED } else { 0 };
    words.push(status & !PADDED | padding);
    if extended {
        words.extend(SINGLES.map(|register| get(uc, register)));
        words.extend([get(uc, Reg::FPSCR), 0]);
    }
    let bytes: Vec<u8> = words.iter().flat_map(|word| word.to_le_bytes()).collect();
    let pushed = uc.mem_write(u64::from(aligned), &bytes).is_ok();
    set(uc, Reg::SP, aligned);
    let process = !in_handler && control & SPSEL != 0;
    let back = 0xFFFF_FFE1
        | if extended { 0 } else { 1 << 4 }
        | if in_handler { 0 } else { 1 << 3 }
        | if process { 1 << 2 } else { 0 };
    // The number changes the stack in use; the flags of the process stack stay in CONTROL until then.
    set_number(uc, u32::from(exception));
    set(uc, Reg::CONTROL, control & !(FPCA | SPSEL));
    jump(uc, vector, back);
    pushed
}

/// A handler follows another one without taking the frame back in between.
pub fn chain<D>(uc: &mut Unicorn<'_, D>, exception: u16, vector: u32, back: u32) {
    set_number(uc, u32::from(exception));
    let control = get(uc, Reg::CONTROL);
    set(uc, Reg::CONTROL, control & !FPCA);
    jump(uc, vector, back);
}

fn jump<D>(uc: &mut Unicorn<'_, D>, vector: u32, back: u32) {
    set(uc, Reg::EPSR, 1 << 24);
    refresh(uc);
    set(uc, Reg::LR, back);
    set(uc, Reg::PC, vector);
}

/// Takes the frame back that `back` (the value in the link register at entry) tells of. Whether that could be.
pub fn leave<D>(uc: &mut Unicorn<'_, D>, back: u32) -> bool {
    let (extended, thread, process) = (back & 1 << 4 == 0, back & 1 << 3 != 0, back & 1 << 2 != 0);
    let count = if extended { EXTENDED } else { BASIC };
    let place = match process {
        true => get(uc, Reg::PSP),
        false => get(uc, Reg::SP),
    };
    let mut bytes = vec![0; 4 * count as usize];
    if uc.mem_read(u64::from(place), &mut bytes).is_err() {
        return false;
    }
    let words: Vec<u32> = bytes
        .as_chunks::<4>()
        .0
        .iter()
        .map(|word| u32::from_le_bytes(*word))
        .collect();
    let status = words[7];
    let above = place + 4 * count + if status & PADDED != 0 { 4 } else { 0 };
    if !process {
        set(uc, Reg::SP, above);
    }
    set_number(uc, if thread { 0 } else { status & NUMBER });
    let control = get(uc, Reg::CONTROL) & !(FPCA | SPSEL);
    let stack = if process { SPSEL } else { 0 };
    set(
        uc,
        Reg::CONTROL,
        control | stack | if extended { FPCA } else { 0 },
    );
    if process {
        set(uc, Reg::PSP, above);
    }
    for (register, word) in [Reg::R0, Reg::R1, Reg::R2, Reg::R3, Reg::R12, Reg::LR]
        .into_iter()
        .zip(&words)
    {
        set(uc, register, *word);
    }
    if extended {
        for (register, word) in SINGLES.into_iter().zip(&words[8..]) {
            set(uc, register, *word);
        }
        set(uc, Reg::FPSCR, words[24]);
    }
    set(
        uc,
        Reg::XPSR_NZCVQG,
        status & !(PADDED | NUMBER) | get(uc, Reg::IPSR),
    );
    refresh(uc);
    set(uc, Reg::PC, words[6] | 1);
    true
}
