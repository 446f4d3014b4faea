//! The board's own number: bytes on the link and in records, text where people read it.

use core::fmt;
use serde::de::{Error, SeqAccess, Visitor};
use serde::{Deserialize, Deserializer, Serialize, Serializer};

/// Bytes of a board's number. By definition 96 bits (RM0440, unique device identifier).
const BYTES: usize = 12;

/// The board's own number, 96 bits. In JSON it is 24 hexadecimal digits; on the screen too, unless all of its bytes are printable
/// characters: then it is these.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
pub struct Device(pub [u8; BYTES]);

impl fmt::Display for Device {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        match core::str::from_utf8(&self.0) {
            Ok(text) if self.0.iter().all(u8::is_ascii_graphic) => formatter.write_str(text),
            _ => Hexadecimal(self).fmt(formatter),
        }
    }
}

/// The number as hexadecimal digits, whatever its bytes are.
struct Hexadecimal<'a>(&'a Device);

impl fmt::Display for Hexadecimal<'_> {
    fn fmt(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        let bytes = &self.0.0;
        bytes
            .iter()
            .try_for_each(|byte| write!(formatter, "{byte:02x}"))
    }
}

impl Serialize for Device {
    fn serialize<S: Serializer>(&self, serializer: S) -> Result<S::Ok, S::Error> {
        if serializer.is_human_readable() {
            serializer.collect_str(&Hexadecimal(self))
        } else {
            self.0.serialize(serializer)
        }
    }
}

impl<'de> Deserialize<'de> for Device {
    fn deserialize<D: Deserializer<'de>>(deserializer: D) -> Result<Self, D::Error> {
        if deserializer.is_human_readable() {
            deserializer.deserialize_any(Readable)
        } else {
            <[u8; BYTES]>::deserialize(deserializer).map(Self)
        }
    }
}

/// Takes the text, and the list of bytes that files of earlier versions hold.
struct Readable;

impl<'de> Visitor<'de> for Readable {
    type Value = Device;

    fn expecting(&self, formatter: &mut fmt::Formatter<'_>) -> fmt::Result {
        formatter.write_str("a board's number: 24 hexadecimal digits")
    }

    fn visit_str<E: Error>(self, text: &str) -> Result<Device, E> {
        let wrong = || E::invalid_value(serde::de::Unexpected::Str(text), &self);
        let mut bytes = [0; BYTES];
        if text.len() != 2 * BYTES || !text.bytes().all(|digit| digit.is_ascii_hexdigit()) {
            return Err(wrong());
        }
        for (byte, place) in bytes.iter_mut().zip((0..).step_by(2)) {
            let digits = text.get(place..place + 2).ok_or_else(wrong)?;
            *byte = u8::from_str_radix(digits, 16).map_err(|_| wrong())?;
        }
        Ok(Device(bytes))
    }

    fn visit_seq<A: SeqAccess<'de>>(self, mut list: A) -> Result<Device, A::Error> {
        let mut bytes = [0; BYTES];
        for (place, byte) in bytes.iter_mut().enumerate() {
            *byte = list
                .next_element()?
                .ok_or_else(|| A::Error::invalid_length(place, &self))?;
        }
        Ok(Device(bytes))
    }
}
