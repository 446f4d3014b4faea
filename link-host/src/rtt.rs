//! SEGGER's real-time transfer: rings in the target's memory, found by a control block that begins with an identifier.
//!
//! ```text
//! +0 "SEGGER RTT" and zeros (16) | +16 up rings | +20 down rings | then a ring each: name, buffer, size, write, read, flags
//! ```
//! The target writes `write` of an up ring and the host `read`; for a down ring it is the other way round. Everything that
//! the target says is checked: it may have just been reset, or be something else.

use crate::memory::TargetMemory;
use anyhow::{Context, Result, ensure};

const IDENTIFIER: &[u8; 10] = b"SEGGER RTT";
const HEADER_BYTES: u32 = 24;
const RING_BYTES: u32 = 24;
/// More rings than any image of this project has.
const MOST_RINGS: u32 = 16;
/// A larger ring does not fit the board.
const LARGEST_RING: u32 = 1 << 17;
/// Bytes read at a time while searching.
const SEARCH_BYTES: usize = 4096;
/// Bytes of a word.
const WORD_BYTES: usize = 4;

/// Up and down rings of a running image.
#[derive(Clone, Debug)]
pub struct Rtt {
    up: Vec<Ring>,
    down: Vec<Ring>,
}

#[derive(Clone, Copy, Debug)]
struct Ring {
    write_index: u32,
    read_index: u32,
    buffer: u32,
    size: u32,
}

impl Rtt {
    /// Reads the control block at `address`; none if the image has not set it up yet.
    ///
    /// # Errors
    /// The memory cannot be read, or the block makes no sense.
    pub fn attach(memory: &mut impl TargetMemory, address: u32) -> Result<Option<Self>> {
        let mut identifier = [0; 10];
        memory.read(address, &mut identifier)?;
        if identifier != *IDENTIFIER {
            return Ok(None);
        }
        let (up, down) = (
            memory.read_word(address + 16)?,
            memory.read_word(address + 20)?,
        );
        ensure!(
            up <= MOST_RINGS && down <= MOST_RINGS,
            "control block at {address:#x}: {up} up and {down} down rings"
        );
        let mut ring = |index: u32| -> Result<Ring> {
            let at = address + HEADER_BYTES + RING_BYTES * index;
            let (buffer, size) = (memory.read_word(at + 4)?, memory.read_word(at + 8)?);
            ensure!(
                size <= LARGEST_RING,
                "ring {index} at {at:#x}: {size} bytes"
            );
            Ok(Ring {
                write_index: at + 12,
                read_index: at + 16,
                buffer,
                size,
            })
        };
        let up: Vec<Ring> = (0..up).map(&mut ring).collect::<Result<_>>()?;
        let down: Vec<Ring> = (up.len() as u32..up.len() as u32 + down)
            .map(&mut ring)
            .collect::<Result<_>>()?;
        let ready = up
            .iter()
            .chain(&down)
            .all(|ring| ring.buffer != 0 && ring.size != 0);
        Ok(ready.then_some(Self { up, down }))
    }

    /// Searches memory for a control block, for an image whose symbols are not at hand.
    ///
    /// # Errors
    /// The memory cannot be read.
    pub fn search(memory: &mut impl TargetMemory, from: u32, bytes: u32) -> Result<Option<u32>> {
        let mut window = vec![0; SEARCH_BYTES + IDENTIFIER.len()];
        let mut at = from;
        while at < from + bytes {
            let length = window.len().min((from + bytes - at) as usize);
            memory.read(at, &mut window[..length])?;
            // The block holds words, and so lies at a word's place.
            if let Some(place) = window[..length]
                .windows(IDENTIFIER.len())
                .step_by(WORD_BYTES)
                .position(|w| w == IDENTIFIER)
            {
                return Ok(Some(at + (place * WORD_BYTES) as u32));
            }
            at += SEARCH_BYTES as u32;
        }
        Ok(None)
    }

    /// The rings at `known`, where they were last found, or else wherever they are in this memory, with their place. After a restart another
    /// image may run, whose rings lie elsewhere; none while it starts.
    ///
    /// # Errors
    /// As [`Rtt::attach`].
    pub fn find(
        memory: &mut impl TargetMemory,
        known: Option<u32>,
        (from, bytes): (u32, u32),
    ) -> Result<Option<(u32, Self)>> {
        if let Some(at) = known
            && let Some(rtt) = Self::attach(memory, at)?
        {
            return Ok(Some((at, rtt)));
        }
        let Some(at) = Self::search(memory, from, bytes)? else {
            return Ok(None);
        };
        Ok(Self::attach(memory, at)?.map(|rtt| (at, rtt)))
    }

    /// Takes what an up ring holds, at most `bytes.len()`; returns how many.
    ///
    /// # Errors
    /// There is no such ring, the memory cannot be read, or the ring's indices make no sense.
    pub fn read(
        &self,
        memory: &mut impl TargetMemory,
        channel: usize,
        bytes: &mut [u8],
    ) -> Result<usize> {
        let ring = self
            .up
            .get(channel)
            .with_context(|| format!("no up ring {channel}"))?;
        let (write, mut read) = ring.indices(memory)?;
        let mut count = 0;
        while count < bytes.len() && read != write {
            let end = if read > write { ring.size } else { write };
            let now = ((end - read) as usize).min(bytes.len() - count);
            memory.read(ring.buffer + read, &mut bytes[count..count + now])?;
            count += now;
            read = (read + now as u32) % ring.size;
        }
        if count > 0 {
            memory.write_word(ring.read_index, read)?;
        }
        Ok(count)
    }

    /// Puts bytes into a down ring; returns how many there was room for.
    ///
    /// # Errors
    /// As [`Rtt::read`].
    pub fn write(
        &self,
        memory: &mut impl TargetMemory,
        channel: usize,
        bytes: &[u8],
    ) -> Result<usize> {
        let ring = self
            .down
            .get(channel)
            .with_context(|| format!("no down ring {channel}"))?;
        let (mut write, read) = ring.indices(memory)?;
        let mut count = 0;
        while count < bytes.len() {
            // One place stays free, or a full ring would look empty.
            let end = if read > write {
                read - 1
            } else {
                ring.size - u32::from(read == 0)
            };
            let now = (end.saturating_sub(write) as usize).min(bytes.len() - count);
            if now == 0 {
                break;
            }
            memory.write(ring.buffer + write, &bytes[count..count + now])?;
            count += now;
            write = (write + now as u32) % ring.size;
        }
        if count > 0 {
            memory.write_word(ring.write_index, write)?;
        }
        Ok(count)
    }
}

impl Ring {
    fn indices(&self, memory: &mut impl TargetMemory) -> Result<(u32, u32)> {
        let (write, read) = (
            memory.read_word(self.write_index)?,
            memory.read_word(self.read_index)?,
        );
        ensure!(
            write < self.size && read < self.size,
            "ring of {} bytes: indices {write} and {read}",
            self.size
        );
        Ok((write, read))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// A target that is a slice of bytes at address 0.
    struct Bytes(Vec<u8>);

    impl TargetMemory for Bytes {
        fn read(&mut self, address: u32, bytes: &mut [u8]) -> Result<()> {
            bytes.copy_from_slice(
                self.0
                    .get(address as usize..)
                    .and_then(|b| b.get(..bytes.len()))
                    .context("outside")?,
            );
            Ok(())
        }

        fn write(&mut self, address: u32, bytes: &[u8]) -> Result<()> {
            let place = self
                .0
                .get_mut(address as usize..)
                .and_then(|b| b.get_mut(..bytes.len()));
            place.context("outside")?.copy_from_slice(bytes);
            Ok(())
        }
    }

    const BLOCK: u32 = 8192;

    /// One up and one down ring of 8 bytes each.
    fn target() -> Bytes {
        let mut memory = Bytes(vec![0; 16_384]);
        let _ = memory.write(BLOCK, IDENTIFIER);
        let words = [1, 1, 0, 64, 8, 0, 0, 0, 0, 72, 8, 0, 0, 0];
        for (k, word) in words.into_iter().enumerate() {
            let _ = memory.write_word(BLOCK + 16 + 4 * k as u32, word);
        }
        memory
    }

    #[test]
    fn block_is_found_and_read() {
        let mut memory = target();
        assert_eq!(Rtt::search(&mut memory, 0, 16_384).unwrap(), Some(BLOCK));
        assert!(Rtt::attach(&mut memory, BLOCK).unwrap().is_some());
        assert!(Rtt::attach(&mut memory, 0).unwrap().is_none());
    }

    #[test]
    fn the_rings_of_another_image_are_found_where_they_are() {
        let mut memory = target();
        let whole = (0, 16_384);
        let found = |memory: &mut Bytes, known| {
            let found = Rtt::find(memory, known, whole).unwrap();
            found.map(|(at, _)| at)
        };
        assert_eq!(found(&mut memory, None), Some(BLOCK));
        assert_eq!(found(&mut memory, Some(BLOCK)), Some(BLOCK));
        // A restart: none, then those of an image that has them elsewhere.
        let block = memory.0[BLOCK as usize..][..100].to_vec();
        memory.0[BLOCK as usize] = 0;
        assert_eq!(found(&mut memory, Some(BLOCK)), None);
        memory.0[256..356].copy_from_slice(&block);
        assert_eq!(found(&mut memory, Some(BLOCK)), Some(256));
    }

    #[test]
    fn rings_wrap_and_never_overflow() {
        let mut memory = target();
        let rtt = Rtt::attach(&mut memory, BLOCK).unwrap().unwrap();
        let down = BLOCK + HEADER_BYTES + RING_BYTES;
        for start in 0..8 {
            let _ = memory.write_word(down + 12, start);
            let _ = memory.write_word(down + 16, start);
            assert_eq!(
                rtt.write(&mut memory, 0, b"123456789").unwrap(),
                7,
                "one place stays free"
            );
            assert_eq!(rtt.write(&mut memory, 0, b"x").unwrap(), 0);
            assert_eq!(memory.read_word(down + 12).unwrap(), (start + 7) % 8);
        }
        for start in 0..8 {
            for (k, byte) in b"abcdefg".iter().enumerate() {
                memory.0[64 + (start as usize + k) % 8] = *byte;
            }
            let _ = memory.write_word(BLOCK + HEADER_BYTES + 12, (start + 7) % 8);
            let _ = memory.write_word(BLOCK + HEADER_BYTES + 16, start);
            let mut bytes = [0; 16];
            assert_eq!(rtt.read(&mut memory, 0, &mut bytes).unwrap(), 7);
            assert_eq!(&bytes[..7], b"abcdefg");
            assert_eq!(rtt.read(&mut memory, 0, &mut bytes).unwrap(), 0);
        }
    }

    #[test]
    fn nonsense_is_refused() {
        let mut memory = target();
        let rtt = Rtt::attach(&mut memory, BLOCK).unwrap().unwrap();
        let _ = memory.write_word(BLOCK + HEADER_BYTES + 12, 8);
        assert!(rtt.read(&mut memory, 0, &mut [0; 4]).is_err());
        assert!(rtt.read(&mut memory, 1, &mut [0; 4]).is_err());
        let _ = memory.write_word(BLOCK + 16, 1000);
        assert!(Rtt::attach(&mut memory, BLOCK).is_err());
    }
}
