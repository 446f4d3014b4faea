//! Where the chip's memory lies (RM0440, memory map).

/// Where bank 1 of the flash begins.
pub const FLASH: u32 = 0x0800_0000;
/// Bytes of a bank.
pub const BANK_BYTES: u32 = 256 << 10;
/// Where the RAM begins.
pub const RAM: u32 = 0x2000_0000;
/// Bytes of it.
pub const RAM_BYTES: u32 = 128 << 10;
