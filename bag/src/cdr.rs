//! Values in CDR, the Common Data Representation of OMG's DDS, as ROS 2 has it: four bytes that say the order of bytes, then values, each at
//! a multiple of its size from there.

/// Bytes before the first value.
const HEAD: usize = 4;

/// Packs values, least significant byte first.
#[derive(Clone, Debug)]
pub struct Packer {
    bytes: Vec<u8>,
}

impl Default for Packer {
    fn default() -> Self {
        Self {
            bytes: vec![0, 1, 0, 0],
        }
    }
}

impl Packer {
    /// The message.
    #[must_use]
    pub fn bytes(&self) -> &[u8] {
        &self.bytes
    }

    /// Begins anew.
    pub fn clear(&mut self) {
        self.bytes.truncate(HEAD);
    }

    fn align(&mut self, size: usize) {
        while !(self.bytes.len() - HEAD).is_multiple_of(size) {
            self.bytes.push(0);
        }
    }

    /// `float64`
    pub fn float64(&mut self, value: f64) {
        self.align(8);
        self.bytes.extend(value.to_le_bytes());
    }

    /// `float32`
    pub fn float32(&mut self, value: f32) {
        self.align(4);
        self.bytes.extend(value.to_le_bytes());
    }

    /// `uint32`
    pub fn uint32(&mut self, value: u32) {
        self.align(4);
        self.bytes.extend(value.to_le_bytes());
    }

    /// `int32`
    pub fn int32(&mut self, value: i32) {
        self.uint32(value as u32);
    }

    /// `string`
    pub fn string(&mut self, text: &str) {
        self.uint32(text.len() as u32 + 1);
        self.bytes.extend(text.as_bytes());
        self.bytes.push(0);
    }
}

/// Unpacks values.
#[derive(Clone, Debug)]
pub struct Unpacker<'a> {
    bytes: &'a [u8],
    at: usize,
    big: bool,
    /// The largest multiple that a value stands at.
    largest: usize,
}

impl<'a> Unpacker<'a> {
    /// A message; none where it is of a form that is not known.
    #[must_use]
    pub fn new(bytes: &'a [u8]) -> Option<Self> {
        // Second byte: bit 0 is the order of bytes; 0 is the plain form, 6 that of the second version, whose values stand at fours.
        let form = *bytes.get(1)?;
        let largest = match form & !1 {
            0 => 8,
            6 => 4,
            _ => return None,
        };
        Some(Self {
            bytes: bytes.get(HEAD..)?,
            at: 0,
            big: form & 1 == 0,
            largest,
        })
    }

    /// Bytes that are left.
    #[must_use]
    pub fn left(&self) -> usize {
        self.bytes.len() - self.at
    }

    /// A value of `size` bytes, 1 to 8, as a word.
    pub fn word(&mut self, size: usize) -> Option<u64> {
        self.at = self.at.next_multiple_of(size.min(self.largest));
        let part = self.bytes.get(self.at..self.at + size)?;
        self.at += size;
        let add = |word: u64, byte: &u8| word << 8 | u64::from(*byte);
        Some(if self.big {
            part.iter().fold(0, add)
        } else {
            part.iter().rev().fold(0, add)
        })
    }

    /// `string`
    pub fn string(&mut self) -> Option<String> {
        let length = self.word(4)? as usize;
        let part = self.bytes.get(self.at..self.at.checked_add(length)?)?;
        self.at += length;
        Some(String::from_utf8_lossy(part.strip_suffix(&[0]).unwrap_or(part)).into_owned())
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn values_stand_at_multiples_of_their_sizes() {
        let mut packer = Packer::default();
        packer.string("ab");
        packer.float64(-1.5);
        packer.float32(0.25);
        packer.int32(-7);
        // 4 + 3 bytes of text, one to the next eight, 8, 4, 4.
        assert_eq!(packer.bytes().len(), HEAD + 8 + 8 + 4 + 4);
        let mut unpacker = Unpacker::new(packer.bytes()).unwrap();
        assert_eq!(unpacker.string().as_deref(), Some("ab"));
        assert_eq!(unpacker.word(8).map(f64::from_bits), Some(-1.5));
        assert_eq!(
            unpacker.word(4).map(|word| f32::from_bits(word as u32)),
            Some(0.25)
        );
        assert_eq!(unpacker.word(4).map(|word| word as u32 as i32), Some(-7));
        assert_eq!((unpacker.left(), unpacker.word(1)), (0, None));
    }

    #[test]
    fn other_forms() {
        let mut big = Unpacker::new(&[0, 0, 0, 0, 0, 0, 0, 5]).unwrap();
        assert_eq!(big.word(4), Some(5));
        // The second version: eight bytes at a multiple of four.
        let mut second = Unpacker::new(&[0, 7, 0, 0, 1, 0, 0, 0, 2, 0, 0, 0, 0, 0, 0, 0]).unwrap();
        assert_eq!((second.word(4), second.word(8)), (Some(1), Some(2)));
        assert!(Unpacker::new(&[0, 3, 0, 0]).is_none() && Unpacker::new(&[0]).is_none());
        assert_eq!(
            Unpacker::new(&[0, 1, 0, 0, 255, 255, 255, 255])
                .unwrap()
                .string(),
            None
        );
    }
}
