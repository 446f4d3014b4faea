//! Cycles of a sequence: the tables of ARM's public Cortex-M4 reference manual (DDI 0439, sections 3.3 and 7.2.3).
//!
//! Modelled: the tables; N loads in a row take N + 1 cycles; a store at base plus register takes 2 unless it follows a load;
//! an address made by the instruction before costs 1; a floating-point result used by the next instruction costs 1;
//! a taken branch costs [`REFILL`] (the manual says 1 to 3).
//! Not modelled: wait states of the flash, bus contention, how division depends on its operands (taken at 7 of 2 to 12),
//! integer instructions that finish while a floating-point division runs (so a division is never cheaper here than there).

use crate::{Class, Flow, Instruction};

/// Cycles that refilling the pipeline adds to a taken branch.
pub const REFILL: u32 = 2;

/// Cycles of `instruction` after `before` (none at the start of a block), without the refill of a taken branch.
pub fn cost(before: Option<&Instruction>, instruction: &Instruction) -> u32 {
    let Some(before) = before else {
        return instruction.cycles;
    };
    let load = |class| matches!(class, Class::Load | Class::FloatLoad);
    let store = |class| matches!(class, Class::Store | Class::FloatStore);
    let dependent = instruction.address_registers & before.result_register != 0;
    let mut cycles = instruction.cycles;
    if load(before.class)
        && (load(instruction.class) || (store(instruction.class) && instruction.cycles > 1))
    {
        cycles -= 1;
    }
    cycles + u32::from(dependent) + u32::from(instruction.float_reads & before.float_result != 0)
}

/// Where a block of instructions ends without a branch. What is behind it follows its last instruction, in whichever block it lies: a count
/// that forgot this would depend on where the linker places a function.
#[derive(Clone, Copy, Debug)]
pub struct Cut {
    behind: u64,
    last: Instruction,
}

impl Cut {
    /// Of a block whose last instruction lies at this address; none where it is a branch, after which any may come.
    #[must_use]
    pub fn of(address: u64, last: Instruction) -> Option<Self> {
        let goes_on = last.class != Class::Branch && last.flow == Flow::Next;
        let behind = address + u64::from(last.size);
        goes_on.then_some(Self { behind, last })
    }

    /// The instruction before the one at an address; none where that does not lie behind the cut.
    #[must_use]
    pub fn before(self, address: u64) -> Option<Instruction> {
        (address == self.behind).then_some(self.last)
    }
}

#[cfg(test)]
mod tests {
    use super::{Cut, cost};
    use crate::decode;

    /// Total of a sequence given as halfwords.
    fn total(halfwords: &[u16]) -> u32 {
        let bytes: Vec<u8> = halfwords.iter().flat_map(|h| h.to_le_bytes()).collect();
        let (mut at, mut sum, mut before) = (0, 0, None);
        while at < bytes.len() {
            let instruction = decode(&bytes[at..]);
            sum += cost(before.as_ref(), &instruction);
            at += instruction.size as usize;
            before = Some(instruction);
        }
        sum
    }

    #[test]
    fn manual_examples() {
        assert_eq!(total(&[0x6808, 0x6811]), 3, "ldr r0,[r1]; ldr r1,[r2]");
        assert_eq!(
            total(&[0x5888, 0x6218]),
            3,
            "ldr r0,[r1,r2]; str r0,[r3,#32]"
        );
        assert_eq!(
            total(&[0x5888, 0x5099]),
            3,
            "ldr r0,[r1,r2]; str r1,[r3,r2]"
        );
        assert_eq!(
            total(&[0x1840, 0x6801]),
            4,
            "adds r0,r0,r1; ldr r1,[r0]: one stall for the address"
        );
    }

    /// `ldr r0,[r1]; ldr r1,[r2]` takes 3 cycles, and 4 where nothing is known of what came before the second.
    #[test]
    fn what_a_page_cuts_in_two_costs_as_one() {
        let [first, second] = [0x6808_u16, 0x6811].map(|h| decode(&h.to_le_bytes()));
        let cut = Cut::of(0x3fe, first).unwrap();
        let second_at = |address| cost(cut.before(address).as_ref(), &second);
        assert_eq!(cost(None, &first) + second_at(0x400), 3);
        assert_eq!(cost(None, &first) + second_at(0x800), 4);
        // bx lr
        assert!(Cut::of(0x3fe, decode(&0x4770_u16.to_le_bytes())).is_none());
    }

    #[test]
    fn floating_point_result_used_at_once_stalls() {
        // vadd.f32 s0,s0,s1; vmul.f32 s2,s0,s0 against vmul.f32 s2,s3,s3
        assert_eq!(total(&[0xee30, 0x0a20, 0xee20, 0x1a00]), 3);
        assert_eq!(total(&[0xee30, 0x0a20, 0xee21, 0x1aa1]), 2);
        assert_eq!(total(&[0xee80, 0x0a20]), 14, "vdiv.f32");
        assert_eq!(total(&[0xeeb1, 0x0ac0]), 14, "vsqrt.f32");
        assert_eq!(total(&[0xee00, 0x0a81]), 3, "vmla.f32");
        assert_eq!(total(&[0xeea0, 0x0a81]), 3, "vfma.f32");
    }
}
