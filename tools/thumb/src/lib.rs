//! Decodes what the project's tools must know of a Cortex-M4F instruction: its class, its time, where it goes, what it does
//! to the stack. Used by the counting plugin (`tools/m4plug`) and by the image checks (`xtask`).
//!
//! Not a disassembler: registers and immediates that none of this needs are not decoded.

mod decode;
mod timing;

pub use decode::decode;
pub use timing::{Cut, REFILL, cost};

/// Kind of an instruction; each has a counter in the plugin.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(usize)]
pub enum Class {
    /// Integer data processing.
    Alu,
    /// Integer multiplication, with or without accumulation.
    Multiply,
    /// Integer division.
    Divide,
    /// Integer load of one word or less.
    Load,
    /// Integer store of one word or less.
    Store,
    /// Integer load or store of several words, push and pop.
    Multiple,
    /// Anything that can change the program counter.
    Branch,
    /// IT, hints, barriers, special registers.
    System,
    /// Floating-point addition, subtraction.
    FloatAdd,
    /// Floating-point multiplication.
    FloatMultiply,
    /// Floating-point multiply-add, chained or fused.
    FloatMultiplyAdd,
    /// Floating-point division and square root.
    FloatDivide,
    /// Floating-point load.
    FloatLoad,
    /// Floating-point store.
    FloatStore,
    /// Floating-point load or store of several words.
    FloatMultiple,
    /// Floating-point move, absolute value, negation.
    FloatMove,
    /// Floating-point conversion and comparison.
    FloatConvert,
}

impl Class {
    /// All of them, in the order of their counters.
    pub const ALL: [Self; 17] = [
        Self::Alu,
        Self::Multiply,
        Self::Divide,
        Self::Load,
        Self::Store,
        Self::Multiple,
        Self::Branch,
        Self::System,
        Self::FloatAdd,
        Self::FloatMultiply,
        Self::FloatMultiplyAdd,
        Self::FloatDivide,
        Self::FloatLoad,
        Self::FloatStore,
        Self::FloatMultiple,
        Self::FloatMove,
        Self::FloatConvert,
    ];
}

/// Where control goes after an instruction. Offsets are from the instruction's own address, in bytes.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Flow {
    /// To the next instruction.
    Next,
    /// Always there.
    Jump(i32),
    /// There or to the next instruction.
    Branch(i32),
    /// A call that comes back to the next instruction.
    Call(i32),
    /// A call of a function that only a register knows.
    CallRegister,
    /// Away: a return, a jump table, or a tail call through a register.
    Away,
}

/// What an instruction does to the stack pointer.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub enum Stack {
    /// Nothing, or gives stack back.
    Keeps,
    /// Takes this many bytes.
    Takes(u32),
    /// Takes an amount that only a register knows.
    TakesUnknown,
}

/// One decoded instruction.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Instruction {
    /// 2 or 4 bytes.
    pub size: u32,
    /// Its kind.
    pub class: Class,
    /// Cycles of the table alone, without what its neighbours add.
    pub cycles: u32,
    /// Where control goes.
    pub flow: Flow,
    /// What it does to the stack.
    pub stack: Stack,
    /// Core registers that form the address of a load or store, one bit each.
    pub address_registers: u16,
    /// Core register that an integer data operation writes, one bit.
    pub result_register: u16,
    /// A store whose address is base plus register.
    pub register_offset: bool,
    /// Floating-point registers (s0 to s31) that it reads, one bit each.
    pub float_reads: u32,
    /// Floating-point register that an arithmetic instruction writes, one bit.
    pub float_result: u32,
}
