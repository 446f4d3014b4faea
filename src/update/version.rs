//! An image's version, ordered.

use serde::{Deserialize, Serialize};

/// Version as in Cargo.toml, without what may follow the third number.
#[derive(
    Clone, Copy, Debug, Default, PartialEq, Eq, PartialOrd, Ord, Hash, Serialize, Deserialize,
)]
pub struct Version {
    /// First number.
    pub major: u16,
    /// Second.
    pub minor: u16,
    /// Third.
    pub patch: u16,
}

impl Version {
    /// Of this firmware.
    pub const OWN: Self = match Self::parse(env!("CARGO_PKG_VERSION")) {
        Some(version) => version,
        None => panic!("Cargo.toml's version is three numbers up to 65535"),
    };

    /// Three numbers with points between; `-` or `+` and what follows it is left out.
    pub const fn parse(text: &str) -> Option<Self> {
        let (bytes, mut numbers, mut which, mut digits) = (text.as_bytes(), [0_u32; 3], 0, 0);
        let mut at = 0;
        while at < bytes.len() {
            match bytes[at] {
                digit @ b'0'..=b'9' => {
                    numbers[which] = 10 * numbers[which] + (digit - b'0') as u32;
                    digits += 1;
                    if numbers[which] > u16::MAX as u32 {
                        return None;
                    }
                }
                b'.' if digits > 0 && which < 2 => (which, digits) = (which + 1, 0),
                b'-' | b'+' if digits > 0 && which == 2 => break,
                _ => return None,
            }
            at += 1;
        }
        if which != 2 || digits == 0 {
            return None;
        }
        let [major, minor, patch] = numbers;
        Some(Self {
            major: major as u16,
            minor: minor as u16,
            patch: patch as u16,
        })
    }
}

impl core::fmt::Display for Version {
    fn fmt(&self, f: &mut core::fmt::Formatter<'_>) -> core::fmt::Result {
        write!(f, "{}.{}.{}", self.major, self.minor, self.patch)
    }
}

#[cfg(test)]
mod tests {
    use super::Version;

    #[test]
    fn versions_are_read_and_ordered_by_their_numbers() {
        let parse = Version::parse;
        assert!(parse("0.9.10") < parse("0.10.0"));
        assert!(parse("1.2.3") == parse("1.2.3-rc.1+build"));
        let wrong = [
            "",
            "1",
            "1.2",
            "1.2.",
            "1.2.3.4",
            "1..3",
            ".1.2",
            "1.2.x",
            "1.2.65536",
            "-1.2.3",
        ];
        for text in wrong {
            assert_eq!(parse(text), None, "{text}");
        }
    }
}
