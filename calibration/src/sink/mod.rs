//! The one way out of everything that is serialised: records and messages in postcard's format, given away in pieces.
//!
//! A closure behind a reference takes the pieces, so that the image holds each type's serialiser once, wherever its bytes go.

mod out_of_line;

use self::out_of_line::OutOfLine;
use postcard::ser_flavors::Flavor;
use serde::Serialize;

/// Takes the next bytes; false: there is no room for them.
type Take<'a> = &'a mut dyn FnMut(&[u8]) -> bool;

struct Sink<'a>(Take<'a>);

impl Flavor for Sink<'_> {
    type Output = ();

    fn try_extend(&mut self, data: &[u8]) -> postcard::Result<()> {
        if (self.0)(data) {
            Ok(())
        } else {
            Err(postcard::Error::SerializeBufferFull)
        }
    }

    fn try_push(&mut self, data: u8) -> postcard::Result<()> {
        self.try_extend(&[data])
    }

    fn finalize(self) -> postcard::Result<()> {
        Ok(())
    }
}

/// Gives `value` to `take`; false as soon as that has no room.
pub fn pour(value: &(impl Serialize + ?Sized), take: Take<'_>) -> bool {
    let mut serializer = OutOfLine(postcard::Serializer { output: Sink(take) });
    value.serialize(&mut serializer).is_ok()
}

/// Writes `value` to the start of `buffer`; returns its bytes, or none if there is no room.
pub fn write<'b>(value: &impl Serialize, buffer: &'b mut [u8]) -> Option<&'b [u8]> {
    let mut length = 0;
    let fits = pour(value, &mut |piece| {
        let end = length + piece.len();
        let place = buffer.get_mut(length..end);
        length = end;
        place.map(|place| place.copy_from_slice(piece)).is_some()
    });
    buffer.get(..length).filter(|_| fits)
}
