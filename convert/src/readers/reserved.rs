//! Bits of a signal that stand for no value: codes of SAE J1939 and NMEA 2000, and what a DBC file says of its own.
//!
//! SAE J1939-71 (section 5.1.4) keeps the largest numbers of a signal without a sign: all bits set is "not available", one less is an
//! error of the sensor; of two bytes or more all that begin with the bytes FF and FE. NMEA 2000 keeps the largest number and the one
//! below it, of signals with a sign too. CANopen has no such codes (CiA 301): there, and on any other bus, the DBC file must say them, by a
//! name in a table of values or by a range that leaves the largest number out.

/// Names in a table of values that mean that there is none, in lower case. From DBC files of J1939, where the first and the last are those
/// of its standard; "sna", signal not available, from those of car makers.
const NAMES: [&str; 6] = [
    "not available",
    "unavailable",
    "sna",
    "n/a",
    "invalid",
    "error indicator",
];

/// What a signal's bits are.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Kind {
    /// A whole number without a sign.
    Unsigned,
    /// One with a sign.
    Signed,
    /// IEEE 754, of 32 or 64 bits.
    Real,
}

/// What is known of a signal's codes.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct Reserved {
    /// Codes that a table of values names so.
    pub named: Vec<u64>,
    /// Lowest and highest value that the DBC file states, in the signal's unit; none where both are alike.
    pub range: Option<[f64; 2]>,
}

/// True of a name in a table of values that means no value.
pub fn is_none_by_name(name: &str) -> bool {
    let name = name.to_lowercase().replace('_', " ");
    NAMES.iter().any(|none| match none.contains(' ') {
        true => name.contains(none),
        false => name.split_whitespace().any(|word| word == *none),
    })
}

impl Reserved {
    /// True of bits that stand for no value, where `value` is what they would be as a number. A single bit never is one.
    pub fn is_none(&self, word: u64, bits: usize, kind: Kind, value: f64, is_j1939: bool) -> bool {
        if self.named.contains(&word) {
            return true;
        }
        let is_outside = self
            .range
            .is_some_and(|[low, high]| !(low..=high).contains(&value));
        let all = u64::MAX >> (64 - bits as u32);
        let largest = match kind {
            Kind::Unsigned => all,
            Kind::Signed => all >> 1,
            Kind::Real => return false,
        };
        if bits < 2 {
            return false;
        }
        if is_j1939 {
            let begins = word >> bits.saturating_sub(8);
            let is_long = kind == Kind::Unsigned && bits >= 16 && bits.is_multiple_of(8);
            return word == largest
                || word == largest - 1
                || is_long && is_outside && begins >= 0xfe;
        }
        let is_least = kind == Kind::Signed && word == largest + 1;
        is_outside && (word == largest || is_least)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn none(
        range: Option<[f64; 2]>,
        kind: Kind,
        bits: usize,
        is_j1939: bool,
    ) -> impl Fn(u64) -> bool {
        let reserved = Reserved {
            named: Vec::new(),
            range,
        };
        move |word| reserved.is_none(word, bits, kind, word as f64, is_j1939)
    }

    #[test]
    fn codes_of_j1939_are_no_values() {
        let byte = none(None, Kind::Unsigned, 8, true);
        assert!(byte(0xff) && byte(0xfe) && !byte(0xfa));
        let pair = none(None, Kind::Unsigned, 2, true);
        assert!(pair(3) && pair(2) && !pair(1));
        let one = none(None, Kind::Unsigned, 1, true);
        assert!(!one(1) && !one(0));
        // NMEA 2000 uses all but two of two bytes, J1939 those below FB00, which its files state.
        let open = none(None, Kind::Unsigned, 16, true);
        assert!(open(0xffff) && open(0xfffe) && !open(0xff00));
        let stated = none(Some([0.0, 64_255.0]), Kind::Unsigned, 16, true);
        assert!(stated(0xff00) && stated(0xfe12) && !stated(0xfd00));
        let signed = none(None, Kind::Signed, 16, true);
        assert!(signed(0x7fff) && signed(0x7ffe) && !signed(0xffff));
    }

    #[test]
    fn elsewhere_the_file_must_say_them() {
        let open = none(None, Kind::Unsigned, 12, false);
        assert!(!open(0xfff));
        let stated = none(Some([0.0, 4000.0]), Kind::Unsigned, 12, false);
        assert!(stated(0xfff) && !stated(0xffe));
        let full = none(Some([0.0, 4095.0]), Kind::Unsigned, 12, false);
        assert!(!full(0xfff));
        let signed = |word: u64, value: f64| {
            let reserved = Reserved {
                named: vec![5],
                range: Some([-32_000.0, 32_000.0]),
            };
            reserved.is_none(word, 16, Kind::Signed, value, false)
        };
        assert!(signed(0x7fff, 32_767.0) && signed(0x8000, -32_768.0) && signed(5, 5.0));
        assert!(!signed(0xffff, -1.0) && !signed(0x7ffe, 32_766.0));
    }

    #[test]
    fn names_that_mean_none() {
        let yes = [
            "Not available",
            "SNA",
            "Signal_Not_Available",
            "invalid",
            "Error indicator",
        ];
        assert!(yes.into_iter().all(is_none_by_name));
        let no = ["Error", "Available", "No error", "snap", "Off"];
        assert!(!no.into_iter().any(is_none_by_name));
    }
}
