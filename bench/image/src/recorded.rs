//! Frames of a recording, from a file on the host.

use cases::parity;
use cases::setups::Setup;
use cortex_m_semihosting::nr::open;
use cortex_m_semihosting::{hprintln, syscall, syscall1};
use courier_sensor::frame::{RawFrame, SEGMENTS};

/// Bytes of a frame in the file: 12 counts of 16 bits, lower byte first, and the temperature in f32.
const FRAME: usize = 28;

/// The words that the host gave, zero-terminated words after them cut off.
pub fn command_line(buffer: &mut [u8]) -> &str {
    const GET_COMMAND_LINE: usize = 0x15;
    let mut block = [buffer.as_mut_ptr() as usize, buffer.len()];
    // SAFETY: the block points to a buffer of the length it says.
    let failed = unsafe { syscall1(GET_COMMAND_LINE, block.as_mut_ptr() as usize) } != 0;
    let length = if failed {
        0
    } else {
        block[1].min(buffer.len())
    };
    core::str::from_utf8(&buffer[..length])
        .unwrap_or("")
        .trim_end_matches('\0')
}

/// Prints the digest of every setup over a file's frames.
pub fn run(path: &str) {
    for setup in Setup::ALL {
        let Some(file) = File::open(path) else {
            hprintln!("{}: cannot be opened", path);
            return;
        };
        hprintln!("frames {:?} {:016x}", setup, parity::frames(setup, file));
    }
}

/// A file read frame by frame, many at a time.
struct File {
    handle: usize,
    buffer: [u8; FRAME * 512],
    filled: usize,
    used: usize,
}

impl File {
    fn open(path: &str) -> Option<Self> {
        let mut name = [0; 512];
        name.get_mut(..path.len())?.copy_from_slice(path.as_bytes());
        // SAFETY: the name is zero-terminated and its length is given without the zero.
        let handle = unsafe { syscall!(OPEN, name.as_ptr(), open::R_BINARY, path.len()) };
        (handle != usize::MAX).then_some(Self {
            handle,
            buffer: [0; FRAME * 512],
            filled: 0,
            used: 0,
        })
    }

    fn fill(&mut self) {
        // SAFETY: reads at most the buffer's length into it; the answer is how many bytes were not read.
        let left = unsafe {
            syscall!(
                READ,
                self.handle,
                self.buffer.as_mut_ptr(),
                self.buffer.len()
            )
        };
        self.filled = self.buffer.len().saturating_sub(left);
        self.used = 0;
    }
}

impl Iterator for File {
    type Item = RawFrame;

    fn next(&mut self) -> Option<RawFrame> {
        if self.used + FRAME > self.filled {
            self.fill();
        }
        let bytes: &[u8; FRAME] = self.buffer[..self.filled]
            .get(self.used..self.used + FRAME)?
            .try_into()
            .ok()?;
        self.used += FRAME;
        let count = |k: usize| i16::from_le_bytes([bytes[2 * k], bytes[2 * k + 1]]);
        Some(RawFrame {
            quadrature_counts: core::array::from_fn(|i: usize| [count(2 * i), count(2 * i + 1)]),
            electrode_counts: core::array::from_fn(|i: usize| count(2 * SEGMENTS + i)),
            temperature_delta_k: f32::from_le_bytes([bytes[24], bytes[25], bytes[26], bytes[27]]),
            ..RawFrame::default()
        })
    }
}
