//! Four rotations of the estimator at a time, in assembly: only VLDM and VSTM move a number a cycle, no compiler here writes
//! them for numbers that are computed with, and the order below has no instruction wait for the result of the one before.
//!
//! Every number goes through the operations of `lsq/rotate.rs` in their order, each rounded, so the bits are the same. Cost: 160
//! cycles a block, 118 for each four columns right of it (20 loads, 20 stores, 64 multiplications and additions), 68 for two.
//!
//! Registers: s0 g; s4-s7, s12-s14, s15-s16, s17 the block's rows; s8-s11 its entries, which become the factors of the
//! factor's entries; s18-s21 those of the row's; s22 one, s27 the least share kept. Along the columns: s4-s7 entries, s12-s15 a row, s16 and s17 products.

/// Rows of a block. Derived from the 32 registers, of which four rows with their entries and factors leave three free.
const BLOCK: usize = 4;

/// `e -= t u` of two columns.
#[rustfmt::skip] // an instruction a line
macro_rules! entries {
    ($e0:literal, $u0:literal, $e1:literal, $u1:literal, $t:literal) => {
        concat!(
            "vmul.f32 s16, ", $u0, ", ", $t, "\n",
            "vmul.f32 s17, ", $u1, ", ", $t, "\n",
            "vsub.f32 ", $e0, ", ", $e0, ", s16\n",
            "vsub.f32 ", $e1, ", ", $e1, ", s17\n",
        )
    };
}

/// `u += k e` of two columns.
#[rustfmt::skip] // an instruction a line
macro_rules! row {
    ($e0:literal, $u0:literal, $e1:literal, $u1:literal, $k:literal) => {
        concat!(
            "vmul.f32 s16, ", $e0, ", ", $k, "\n",
            "vmul.f32 s17, ", $e1, ", ", $k, "\n",
            "vadd.f32 ", $u0, ", ", $u0, ", s16\n",
            "vadd.f32 ", $u1, ", ", $u1, ", s17\n",
        )
    };
}

/// Four columns of one row, which comes from and goes to memory and moves on.
#[rustfmt::skip] // an instruction a line
macro_rules! four {
    ($row:literal, $t:literal, $k:literal) => {
        concat!(
            "vldm {", $row, "}, {{s12-s15}}\n",
            entries!("s4", "s12", "s5", "s13", $t),
            entries!("s6", "s14", "s7", "s15", $t),
            row!("s4", "s12", "s5", "s13", $k),
            row!("s6", "s14", "s7", "s15", $k),
            "vstm {", $row, "}!, {{s12-s15}}\n",
        )
    };
}

/// Two.
#[rustfmt::skip] // an instruction a line
macro_rules! two {
    ($row:literal, $t:literal, $k:literal) => {
        concat!(
            "vldm {", $row, "}, {{s12-s13}}\n",
            entries!("s4", "s12", "s5", "s13", $t),
            row!("s4", "s12", "s5", "s13", $k),
            "vstm {", $row, "}!, {{s12-s13}}\n",
        )
    };
}

/// One.
#[rustfmt::skip] // an instruction a line
macro_rules! one {
    ($row:literal, $t:literal, $k:literal) => {
        concat!(
            "vldr s12, [{", $row, "}]\n",
            "vmul.f32 s16, s12, ", $t, "\n",
            "vsub.f32 s4, s4, s16\n",
            "vmul.f32 s16, s4, ", $k, "\n",
            "vadd.f32 s12, s12, s16\n",
            "vstm {", $row, "}!, {{s12}}\n",
        )
    };
}

/// So many columns of all four rows of a block.
macro_rules! block {
    ($columns:ident) => {
        concat!(
            $columns!("a", "s8", "s18"),
            $columns!("b", "s9", "s19"),
            $columns!("c", "s10", "s20"),
            $columns!("d", "s11", "s21"),
        )
    };
}

/// The end of a rotation: `scale`, one over the `new` diagonal, becomes its share of the old one; too small a share ends the
/// block, undone; else the diagonal is the new one and g goes on with its share.
#[rustfmt::skip] // an instruction a line
macro_rules! turned {
    ($diagonal:literal, $new:literal, $scale:literal) => {
        concat!(
            "vmul.f32 ", $scale, ", ", $diagonal, ", ", $scale, "\n",
            "vmov.f32 ", $diagonal, ", ", $new, "\n",
            "vcmp.f32 ", $scale, ", s27\n",
            "vmrs APSR_nzcv, fpscr\n",
            "blt 8f\n",
            "vmul.f32 s0, s0, ", $scale, "\n",
        )
    };
}

/// The four rotations of a block, one begun while the one before still writes.
macro_rules! rotations {
    () => {
        concat!(
            // First rotation.
            "vmul.f32 s1, s0, s8\n",
            "vmul.f32 s2, s8, s5\n",
            "vmul.f32 s3, s1, s8\n",
            "vsub.f32 s9, s9, s2\n",
            "vadd.f32 s2, s4, s3\n",
            "vmul.f32 s23, s8, s6\n",
            "vdiv.f32 s24, s22, s2\n",
            "vsub.f32 s10, s10, s23\n",
            "vmul.f32 s18, s1, s24\n",
            turned!("s4", "s2", "s24"),
            "vmul.f32 s2, s8, s7\n",
            // Second.
            "vmul.f32 s1, s0, s9\n",
            "vsub.f32 s11, s11, s2\n",
            "vmul.f32 s3, s1, s9\n",
            "vmul.f32 s23, s9, s13\n",
            "vmul.f32 s2, s18, s9\n",
            "vadd.f32 s24, s12, s3\n",
            "vadd.f32 s5, s5, s2\n",
            "vdiv.f32 s25, s22, s24\n",
            "vmul.f32 s2, s18, s10\n",
            "vmul.f32 s19, s1, s25\n",
            turned!("s12", "s24", "s25"),
            "vadd.f32 s6, s6, s2\n",
            "vsub.f32 s10, s10, s23\n",
            "vmul.f32 s2, s18, s11\n",
            // Third.
            "vmul.f32 s1, s0, s10\n",
            "vadd.f32 s7, s7, s2\n",
            "vmul.f32 s3, s1, s10\n",
            "vmul.f32 s23, s9, s14\n",
            "vsub.f32 s11, s11, s23\n",
            "vadd.f32 s24, s15, s3\n",
            "vmul.f32 s2, s19, s10\n",
            "vdiv.f32 s25, s22, s24\n",
            "vadd.f32 s13, s13, s2\n",
            "vmul.f32 s20, s1, s25\n",
            turned!("s15", "s24", "s25"),
            "vmul.f32 s2, s10, s16\n",
            "vmul.f32 s23, s19, s11\n",
            "vsub.f32 s11, s11, s2\n",
            "vadd.f32 s14, s14, s23\n",
            // Fourth.
            "vmul.f32 s1, s0, s11\n",
            "vmul.f32 s2, s20, s11\n",
            "vmul.f32 s3, s1, s11\n",
            "vadd.f32 s16, s16, s2\n",
            "vadd.f32 s24, s17, s3\n",
            "vdiv.f32 s25, s22, s24\n",
            "vmul.f32 s21, s1, s25\n",
            turned!("s17", "s24", "s25"),
        )
    };
}

/// The columns right of a block, four at a time, then two, then one.
macro_rules! columns {
    () => {
        concat!(
            "subs {left}, #4\n",
            "mov {e}, {entries}\n",
            "lsrs {count}, {left}, #2\n",
            "beq 4f\n",
            "3:\n",
            "vldm {e}, {{s4-s7}}\n",
            block!(four),
            "vstm {e}!, {{s4-s7}}\n",
            "subs {count}, #1\n",
            "bne 3b\n",
            "4:\n",
            "tst {left}, #2\n",
            "beq 5f\n",
            "vldm {e}, {{s4-s5}}\n",
            block!(two),
            "vstm {e}!, {{s4-s5}}\n",
            "5:\n",
            "tst {left}, #1\n",
            "beq 6f\n",
            "vldr s4, [{e}]\n",
            block!(one),
            "vstr s4, [{e}]\n",
            "6:\n",
        )
    };
}

/// Rotates the entering row, the `entries` of which are as many as the first row of `factor`, into as many blocks of four rows
/// as are wholly of the first kind, and `weight` with it. Returns how many rows that were.
#[inline(always)]
#[allow(unsafe_code)] // inline assembly is the only way to these instructions
pub fn rotate_fours(factor: &mut [f32], entries: &mut [f32], weight: &mut f32) -> usize {
    let length = entries.len();
    if length <= BLOCK || factor.len() < length * (length + 1) / 2 - 1 {
        return 0;
    }
    let (mut left, mut bits) = (length, weight.to_bits());
    // SAFETY: a triangle of rows of `length`, `length - 1`, down to 2 numbers lies in `factor`, as was checked; the blocks read
    // and write these, and `length` numbers of `entries`, only. All registers that are changed are named. Every image runs
    // with the floating-point unit on.
    unsafe {
        core::arch::asm!(
            "vmov s0, {bits}",
            "vmov.f32 s22, #1.0",
            "vmov.f32 s27, #0.125",
            "2:",
            "vmov.f32 s26, s0",
            "add {b}, {a}, {left}, lsl #2",
            "add {c}, {b}, {left}, lsl #2",
            "add {d}, {c}, {left}, lsl #2",
            "subs {c}, #4",
            "subs {d}, #12",
            "vldm {a}, {{s4-s7}}",
            "vldm {entries}!, {{s8-s11}}",
            "vldm {b}, {{s12-s14}}",
            "vldm {c}, {{s15-s16}}",
            "vldr s17, [{d}]",
            rotations!(),
            "vstm {a}!, {{s4-s7}}",
            "vstm {b}!, {{s12-s14}}",
            "vstm {c}!, {{s15-s16}}",
            "vstm {d}!, {{s17}}",
            // The columns right of the block.
            columns!(),
            "mov {a}, {d}",
            "cmp {left}, #5",
            "bhs 2b",
            "b 9f",
            "8:",
            "vmov.f32 s0, s26",
            "9:",
            "vmov {bits}, s0",
            a = inout(reg) factor.as_mut_ptr() => _,
            entries = inout(reg) entries.as_mut_ptr() => _,
            left = inout(reg) left,
            bits = inout(reg) bits,
            b = out(reg) _, c = out(reg) _, d = out(reg) _, e = out(reg) _, count = out(reg) _,
            out("s0") _, out("s1") _, out("s2") _, out("s3") _, out("s4") _, out("s5") _, out("s6") _, out("s7") _,
            out("s8") _, out("s9") _, out("s10") _, out("s11") _, out("s12") _, out("s13") _, out("s14") _,
            out("s15") _, out("s16") _, out("s17") _, out("s18") _, out("s19") _, out("s20") _, out("s21") _,
            out("s22") _, out("s23") _, out("s24") _, out("s25") _, out("s26") _, out("s27") _,
            options(nostack),
        );
    }
    *weight = f32::from_bits(bits);
    length - left
}
