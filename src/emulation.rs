//! What the emulated board and the host that answers it agree on: places in the RAM that both see, and operations.
//!
//! QEMU's mps2-an386 backs the 16 MiB at [`RAM_BASE`] by a file. Near its end lie two mailboxes, one a priority: the
//! interrupt may ask while a question of the background stands. A question is written, its `sequence` incremented, and the
//! bell rung (an address that the plugin watches): the processor and its time stand still until the host has answered
//! every open question. So a run repeats exactly, whatever the host does meanwhile.

/// The emulator.
pub const QEMU: &str = "qemu-system-arm";
/// Its arguments, but for the RAM's file, the plugin and the image.
pub const QEMU_ARGUMENTS: [&str; 9] = [
    "-cpu",
    "cortex-m4",
    "-machine",
    "mps2-an386,memory-backend=ram",
    "-nographic",
    "-monitor",
    "none",
    "-serial",
    "null",
];
/// What comes after `-object`: before and after the file's path.
pub const RAM_OBJECT: [&str; 2] = ["memory-backend-file,id=ram,size=16M,mem-path=", ",share=on"];

/// Guest address of the shared RAM.
pub const RAM_BASE: u32 = 0x2100_0000;
/// Its size.
pub const RAM_BYTES: usize = 16 << 20;

/// Guest address of the first mailbox; the second follows.
pub const MAILBOX_BASE: u32 = RAM_BASE + 0x00FF_8000;
/// Distance of the mailboxes.
pub const MAILBOX_STRIDE: u32 = 0x2000;
/// Mailbox of the interrupt.
pub const INTERRUPT: usize = 0;
/// Mailbox of everything below it.
pub const BACKGROUND: usize = 1;
/// Words before the data: see [`Word`].
pub const HEADER_BYTES: u32 = 64;
/// Most bytes of one question or answer.
pub const DATA_BYTES: usize = 4096;

/// Guest address of the answers ahead: while nothing but samples is asked for, the host carries out the next few instants
/// (the timer's edge, then each chip's transfer as it was asked the last time) and leaves the answers here, stamped. The
/// board takes them at their instants without a question. If it asks a chip for something else, what was done ahead is
/// taken back: the wire carries the same bits either way. Layout: [`AheadWord`], both chips' questions, then the instants.
pub const AHEAD_BASE: u32 = RAM_BASE + 0x00FF_E000;
/// Instants answered ahead at most: 0.4 ms at 20 kHz, by which a byte on the serial line may be late.
pub const AHEAD_INSTANTS: u32 = 8;
/// Longest transfer that is answered ahead.
pub const AHEAD_BYTES: u32 = 64;
/// Place of a chip's question: its length in a word, then its bytes.
pub const fn ahead_question(chip: u32) -> u32 {
    AHEAD_BASE + 0x10 + chip * (AHEAD_BYTES + 4)
}
/// Place of an instant: its stamp, its answer as of [`Operation::Convert`], then both chips' answers.
pub const fn ahead_instant(index: u32) -> u32 {
    AHEAD_BASE + 0x100 + index * (8 + 2 * AHEAD_BYTES)
}

/// Word at [`AHEAD_BASE`], as an index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum AheadWord {
    /// Instants that are answered; written by the host.
    Given = 0,
    /// Instants taken or let go by; written by the board.
    Taken = 1,
    /// Bit c: the transfer of chip c at the last instant taken has been taken too.
    Chips = 2,
}

/// Guest address of the words by which plugin and host hand over: questions rung, questions answered, host gone.
pub const POST_BASE: u32 = RAM_BASE + 0x00FF_D000;
/// Guest address of the plugin's counters.
pub const COUNTERS_BASE: u32 = RAM_BASE + 0x00FF_F000;

/// Rate of the counter that stamps each question, hertz.
pub const TICK_HZ: u32 = 25_000_000;

/// Word of a mailbox's header, as an index.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Word {
    /// Questions asked here.
    Sequence = 0,
    /// Questions answered here.
    Done = 1,
    /// [`Operation`].
    Operation = 2,
    /// First argument; the operation's own.
    Argument = 3,
    /// Bytes of data that go with the question, or that are wanted.
    Length = 4,
    /// The answer: bytes of data that come with it, a level, or [`FAILED`].
    Answer = 5,
    /// The guest's counter of [`TICK_HZ`] when it asked, modulo 2^32.
    Ticks = 6,
}

/// Answer of an operation that did not succeed.
pub const FAILED: u32 = u32::MAX;
/// Answer when the supply has gone in the middle of the operation: the board starts anew, keeping nothing.
pub const POWER_LOST: u32 = u32::MAX - 1;
/// Answer of a part that never answers: who asked waits for ever.
pub const HUNG: u32 = u32::MAX - 2;
/// Answer at which who asked calls itself until the stack is spent: what a defect of the firmware would do.
pub const STACK_SPENT: u32 = u32::MAX - 3;

/// What may be asked.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Operation {
    /// The image starts; its counter starts from the stamp. The answer's data: the board's number, 12 bytes.
    Boot = 1,
    /// The timer's edge of CONVST, and BUSY's rise and fall; the argument is the ticks between two instants. Answer: bit 0 if
    /// it rose and fell, bit 1 if the serial line has bytes, bit 2 if the input of the reference mark is on.
    Convert = 2,
    /// Full-duplex transfer with the chip given as argument; the answer's data are as long.
    Spi = 3,
    /// Level of an output: the argument is [`Pin`] times 2 plus the level.
    SetPin = 4,
    /// Level of an input, the argument is [`Pin`].
    GetPin = 5,
    /// Bytes to the motion controller. Answer: how many were taken.
    SerialWrite = 6,
    /// Bytes from it, at most the length. Answer: how many there were; none is an answer.
    SerialRead = 7,
    /// The flash, from the argument's offset.
    FlashRead = 8,
    /// Erases from the argument's offset, length bytes.
    FlashErase = 9,
    /// Programs.
    FlashWrite = 10,
    /// Board temperature. Answer: thousandths of a degree Celsius plus 1,000,000.
    Temperature = 11,
}

impl Operation {
    /// All of them.
    pub const ALL: [Self; 11] = [
        Self::Boot,
        Self::Convert,
        Self::Spi,
        Self::SetPin,
        Self::GetPin,
        Self::SerialWrite,
        Self::SerialRead,
        Self::FlashRead,
        Self::FlashErase,
        Self::FlashWrite,
        Self::Temperature,
    ];

    /// From the header's word.
    pub fn from_word(word: u32) -> Option<Self> {
        Self::ALL
            .into_iter()
            .find(|operation| *operation as u32 == word)
    }
}

/// Lines to the converters.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
#[repr(u32)]
pub enum Pin {
    /// CONVST.
    Convst = 0,
    /// RESET.
    Reset = 1,
    /// BUSY.
    Busy = 2,
    /// The status LED.
    Led = 3,
}
