//! Halfwords to [`Instruction`]: ARMv7-M architecture reference manual, chapter A5.

use crate::{Class, Flow, Instruction, Stack};

const SP: u16 = 1 << 13;
const LR: u16 = 1 << 14;
const PC: u16 = 1 << 15;

/// A plain one: `class`, `cycles`, everything else left alone.
const fn plain(class: Class, cycles: u32) -> Instruction {
    Instruction {
        size: 4,
        class,
        cycles,
        flow: Flow::Next,
        stack: Stack::Keeps,
        address_registers: 0,
        result_register: 0,
        register_offset: false,
        float_reads: 0,
        float_result: 0,
    }
}

const fn away(cycles: u32) -> Instruction {
    Instruction {
        flow: Flow::Away,
        ..plain(Class::Branch, cycles)
    }
}

const fn alu(result: u16) -> Instruction {
    Instruction {
        result_register: 1 << (result & 15),
        ..plain(Class::Alu, 1)
    }
}

/// Integer load (2 cycles) or store (1, or 2 at base plus register).
const fn access(load: bool, address_registers: u16, register_offset: bool) -> Instruction {
    let (class, cycles) = match (load, register_offset) {
        (true, _) => (Class::Load, 2),
        (false, false) => (Class::Store, 1),
        (false, true) => (Class::Store, 2),
    };
    Instruction {
        address_registers,
        register_offset,
        ..plain(class, cycles)
    }
}

/// Load or store of several words: one cycle each and one more.
const fn multiple(words: u32, address_registers: u16) -> Instruction {
    Instruction {
        address_registers,
        ..plain(Class::Multiple, 1 + words)
    }
}

const fn sign_extend(value: u32, bits: u32) -> i32 {
    ((value << (32 - bits)) as i32) >> (32 - bits)
}

const fn bit(halfword: u16, position: u32) -> u32 {
    (halfword as u32 >> position) & 1
}

/// Decodes the instruction at the start of `bytes` (at least 2, and 4 where there are as many left).
///
/// Unknown codes count as data processing of one cycle.
pub fn decode(bytes: &[u8]) -> Instruction {
    let halfword = |at: usize| match bytes.get(at..at + 2) {
        Some(pair) => u16::from_le_bytes([pair[0], pair[1]]),
        None => 0,
    };
    let first = halfword(0);
    if first >> 11 >= 0b11101 {
        wide(first, halfword(2))
    } else {
        Instruction {
            size: 2,
            ..narrow(first)
        }
    }
}

fn narrow(h: u16) -> Instruction {
    let low = |position: u32| 1 << (h >> position & 7);
    match h >> 12 {
        0 | 1 => alu(h & 7),
        2 | 3 => alu(h >> 8 & 7),
        4 => narrow_special(h),
        5 => access(h >> 9 & 7 >= 3, low(3) | low(6), true),
        6..=8 => access(bit(h, 11) == 1, low(3), false),
        9 => access(bit(h, 11) == 1, SP, false),
        0xa => alu(h >> 8 & 7),
        0xb => narrow_miscellaneous(h),
        0xc => multiple((h & 0xff).count_ones(), low(8)),
        0xd if h >> 8 == 0xdf => plain(Class::System, 1),
        0xd => Instruction {
            flow: Flow::Branch(sign_extend(u32::from(h & 0xff), 8) * 2 + 4),
            ..plain(Class::Branch, 1)
        },
        _ => Instruction {
            flow: Flow::Jump(sign_extend(u32::from(h & 0x7ff), 11) * 2 + 4),
            ..plain(Class::Branch, 1)
        },
    }
}

/// 0100: data processing of low registers, high registers and exchange, load of a literal.
fn narrow_special(h: u16) -> Instruction {
    let high = (h >> 4 & 8) | (h & 7);
    match h >> 8 & 15 {
        3 if h >> 6 & 3 == 1 => plain(Class::Multiply, 1),
        0..=3 => alu(h & 7),
        7 if bit(h, 7) == 1 => Instruction {
            flow: Flow::CallRegister,
            ..plain(Class::Branch, 1)
        },
        7 => away(1),
        5 => plain(Class::Alu, 1),
        4 | 6 if high == 15 => away(1),
        4 if high == 13 => Instruction {
            stack: Stack::TakesUnknown,
            ..alu(high)
        },
        4 | 6 => alu(high),
        _ => access(true, 0, false),
    }
}

/// 1011: stack, compare and branch, extensions, hints.
fn narrow_miscellaneous(h: u16) -> Instruction {
    let words = (h & 0x1ff).count_ones();
    match h >> 8 & 15 {
        0 if bit(h, 7) == 1 => Instruction {
            stack: Stack::Takes(u32::from(h & 0x7f) * 4),
            ..alu(13)
        },
        0 => alu(13),
        4 | 5 => Instruction {
            stack: Stack::Takes(words * 4),
            ..multiple(words, 0)
        },
        0xc => multiple(words, 0),
        0xd => away(1 + words),
        1 | 3 | 9 | 0xb => {
            let offset = i32::from(h >> 3 & 31) * 2 + i32::from(h >> 9 & 1) * 64 + 4;
            Instruction {
                flow: Flow::Branch(offset),
                ..plain(Class::Branch, 1)
            }
        }
        6 | 0xe | 0xf => plain(Class::System, 1),
        _ => alu(h & 7),
    }
}

fn wide(h: u16, l: u16) -> Instruction {
    match h >> 8 {
        0xe8 | 0xe9 => wide_multiple(h, l),
        0xec | 0xed => float_access(h, l),
        0xee => float_data(h, l),
        0xea | 0xeb => wide_alu(h, l),
        0xf8 | 0xf9 => wide_access(h, l),
        0xfa => alu(l >> 8),
        0xfb if h & 0x80 == 0 => plain(Class::Multiply, 1),
        0xfb if h & 0xf0 == 0x90 || h & 0xf0 == 0xb0 => plain(Class::Divide, 7),
        0xfb => plain(Class::Multiply, 1),
        0xf0..=0xf7 if bit(l, 15) == 1 => wide_branch(h, l),
        _ => wide_alu(h, l),
    }
}

/// Data processing with a modified immediate or a shifted register; those on the stack pointer take stack.
fn wide_alu(h: u16, l: u16) -> Instruction {
    let result = l >> 8 & 15;
    let immediate =
        u32::from(h >> 10 & 1) << 11 | u32::from(l >> 12 & 7) << 8 | u32::from(l & 0xff);
    let stack = match h & 0xfbff {
        0xf1ad | 0xf1bd if result == 13 => Stack::Takes(expand(immediate)),
        0xf2ad if result == 13 => Stack::Takes(immediate),
        _ if h & 0xffef == 0xebad && result == 13 => Stack::TakesUnknown,
        _ => Stack::Keeps,
    };
    // Comparisons name the program counter as their result; nothing follows from it.
    Instruction {
        stack,
        ..alu(result)
    }
}

/// The modified immediate of ARMv7-M, A5.3.2, as far as stack frames use it (multiples of 4: no repeated bytes).
fn expand(immediate: u32) -> u32 {
    if immediate >> 10 == 0 {
        immediate & 0xff
    } else {
        (0x80 | (immediate & 0x7f)).rotate_right(immediate >> 7)
    }
}

fn wide_multiple(h: u16, l: u16) -> Instruction {
    let base = 1 << (h & 15);
    if h & 0x40 == 0 {
        let words = l.count_ones();
        let load = bit(h, 4) == 1;
        return match () {
            () if load && l & PC != 0 => away(1 + words),
            () if !load && h & 0xff2f == 0xe92d => Instruction {
                stack: Stack::Takes(words * 4),
                ..multiple(words, 0)
            },
            () => multiple(words, base),
        };
    }
    if h & 0xfff0 == 0xe8d0 && l & 0xffe0 == 0xf000 {
        return away(2);
    }
    if h & 0x120 != 0 {
        let writes_down = h & 0xff7f == 0xe96d;
        let stack = if writes_down {
            Stack::Takes(u32::from(l & 0xff) * 4)
        } else {
            Stack::Keeps
        };
        return Instruction {
            stack,
            ..multiple(2, base)
        };
    }
    access(bit(h, 4) == 1, base, false)
}

fn wide_access(h: u16, l: u16) -> Instruction {
    let load = bit(h, 4) == 1;
    if load && l >> 12 == 15 && h & 0x60 == 0x40 {
        return away(2);
    }
    let base = if h & 15 == 15 { 0 } else { 1 << (h & 15) };
    let register_offset = h & 0x80 == 0 && l & 0xfc0 == 0 && h & 15 != 15;
    let offset = if register_offset { 1 << (l & 15) } else { 0 };
    let pushes = h == 0xf84d && l & 0xf00 == 0xd00;
    let stack = if pushes {
        Stack::Takes(u32::from(l & 0xff))
    } else {
        Stack::Keeps
    };
    Instruction {
        stack,
        ..access(load, base | offset, register_offset)
    }
}

fn wide_branch(h: u16, l: u16) -> Instruction {
    let (s, j1, j2) = (bit(h, 10), bit(l, 13), bit(l, 11));
    let far = || {
        let (i1, i2) = (1 ^ j1 ^ s, 1 ^ j2 ^ s);
        let value =
            s << 23 | i1 << 22 | i2 << 21 | u32::from(h & 0x3ff) << 11 | u32::from(l & 0x7ff);
        sign_extend(value, 24) * 2 + 4
    };
    match (bit(l, 14), bit(l, 12)) {
        (1, 1) => Instruction {
            flow: Flow::Call(far()),
            ..plain(Class::Branch, 1)
        },
        (0, 1) => Instruction {
            flow: Flow::Jump(far()),
            ..plain(Class::Branch, 1)
        },
        (0, 0) if h >> 7 & 7 != 7 => {
            let value =
                s << 19 | j2 << 18 | j1 << 17 | u32::from(h & 0x3f) << 11 | u32::from(l & 0x7ff);
            Instruction {
                flow: Flow::Branch(sign_extend(value, 20) * 2 + 4),
                ..plain(Class::Branch, 1)
            }
        }
        _ => plain(Class::System, 1),
    }
}

/// Loads and stores of floating-point registers, and moves of two at a time.
fn float_access(h: u16, l: u16) -> Instruction {
    if h & 0x1e0 == 0x40 {
        return plain(Class::FloatMove, 2);
    }
    let (single, load) = (l >> 8 & 15 == 10, bit(h, 4) == 1);
    let words = u32::from(l & 0xff);
    let base = if h & 15 == 15 { 0 } else { 1 << (h & 15) };
    if h & 0x120 == 0x100 {
        let class = if load {
            Class::FloatLoad
        } else {
            Class::FloatStore
        };
        let source = destination(h, l);
        let reads = if load || !single { 0 } else { source };
        return Instruction {
            address_registers: base,
            float_reads: reads,
            ..plain(class, if single { 2 } else { 3 })
        };
    }
    let pushes = h & 0xffbf == 0xed2d;
    let stack = if pushes {
        Stack::Takes(words * 4)
    } else {
        Stack::Keeps
    };
    Instruction {
        stack,
        address_registers: base & !SP & !LR,
        ..plain(Class::FloatMultiple, 1 + words)
    }
}

const fn destination(h: u16, l: u16) -> u32 {
    1 << ((l as u32 >> 12) << 1 | bit(h, 6))
}

fn float_data(h: u16, l: u16) -> Instruction {
    if bit(l, 4) == 1 {
        // From or to a core register; a read of the floating-point side may wait for it.
        let reads = if bit(h, 4) == 1 {
            1 << ((u32::from(h) & 15) << 1 | bit(l, 7))
        } else {
            0
        };
        return Instruction {
            float_reads: reads,
            ..plain(Class::FloatMove, 1)
        };
    }
    let d = destination(h, l);
    let n = 1 << ((u32::from(h) & 15) << 1 | bit(l, 7));
    let m = 1 << ((u32::from(l) & 15) << 1 | bit(l, 5));
    let arithmetic = |class, cycles, reads| Instruction {
        float_reads: reads,
        float_result: d,
        ..plain(class, cycles)
    };
    match h >> 4 & 0xb {
        0 | 1 | 9 | 0xa => arithmetic(Class::FloatMultiplyAdd, 3, d | n | m),
        2 => arithmetic(Class::FloatMultiply, 1, n | m),
        3 => arithmetic(Class::FloatAdd, 1, n | m),
        8 => arithmetic(Class::FloatDivide, 14, n | m),
        _ if bit(l, 6) == 0 => plain(Class::FloatMove, 1),
        _ => match (h & 15, bit(l, 7)) {
            (1, 1) => arithmetic(Class::FloatDivide, 14, m),
            (0 | 1, _) => Instruction {
                float_reads: m,
                ..plain(Class::FloatMove, 1)
            },
            (4, _) => Instruction {
                float_reads: d | m,
                ..plain(Class::FloatConvert, 1)
            },
            (5, _) => Instruction {
                float_reads: d,
                ..plain(Class::FloatConvert, 1)
            },
            _ => arithmetic(Class::FloatConvert, 1, m),
        },
    }
}

#[cfg(test)]
mod tests {
    use super::decode;
    use crate::{Class, Flow, Stack};

    fn halfwords(first: u16, second: u16) -> crate::Instruction {
        let (a, b) = (first.to_le_bytes(), second.to_le_bytes());
        decode(&[a[0], a[1], b[0], b[1]])
    }

    #[test]
    fn stack_is_taken() {
        let cases = [
            ((0xb5f0, 0), Stack::Takes(20), "push {r4-r7,lr}"),
            ((0xb083, 0), Stack::Takes(12), "sub sp,#12"),
            ((0xf5ad, 0x5d80), Stack::Takes(4096), "sub.w sp,sp,#4096"),
            ((0xf5ad, 0x7d1a), Stack::Takes(616), "sub.w sp,sp,#616"),
            ((0xe92d, 0x4ff0), Stack::Takes(36), "push.w {r4-r11,lr}"),
            ((0xed2d, 0x8b10), Stack::Takes(64), "vpush {d8-d15}"),
            ((0xf84d, 0x8d04), Stack::Takes(4), "str r8,[sp,#-4]!"),
            ((0xb003, 0), Stack::Keeps, "add sp,#12"),
        ];
        for ((first, second), wanted, text) in cases {
            assert_eq!(halfwords(first, second).stack, wanted, "{text}");
        }
    }

    #[test]
    fn flow_is_followed() {
        let cases = [
            ((0xf000, 0xf801), Flow::Call(6), "bl +2"),
            ((0xf7ff, 0xfffe), Flow::Call(0), "bl to itself"),
            ((0xf7ff, 0xbffe), Flow::Jump(0), "b.w to itself"),
            ((0xe7fe, 0), Flow::Jump(0), "b to itself"),
            ((0xd0fe, 0), Flow::Branch(0), "beq to itself"),
            ((0xf43f, 0xaffe), Flow::Branch(0), "beq.w to itself"),
            ((0x4798, 0), Flow::CallRegister, "blx r3"),
            ((0x4770, 0), Flow::Away, "bx lr"),
            ((0xe8bd, 0x8ff0), Flow::Away, "pop.w {r4-r11,pc}"),
        ];
        for ((first, second), wanted, text) in cases {
            assert_eq!(halfwords(first, second).flow, wanted, "{text}");
        }
    }

    #[test]
    fn classes() {
        let cases = [
            ((0xed90, 0x0a00), Class::FloatLoad, "vldr s0,[r0]"),
            ((0xed80, 0x0a00), Class::FloatStore, "vstr s0,[r0]"),
            ((0xecb0, 0x0a04), Class::FloatMultiple, "vldmia r0!,{s0-s3}"),
            ((0xeeb4, 0x0a60), Class::FloatConvert, "vcmp"),
            ((0xeef1, 0xfa10), Class::FloatMove, "vmrs"),
            ((0xfbb0, 0xf0f1), Class::Divide, "udiv"),
            ((0xfb00, 0xf001), Class::Multiply, "mul.w"),
            ((0xf3bf, 0x8f4f), Class::System, "dsb"),
            ((0xe8df, 0xf000), Class::Branch, "tbb"),
        ];
        for ((first, second), wanted, text) in cases {
            assert_eq!(halfwords(first, second).class, wanted, "{text}");
        }
    }
}
