//! The public key that an image trusts. Its secret half signs images and is in no image.
//!
//! Without a key of one's own an image trusts the development key. Its secret half is published with the source
//! (`cargo xtask image` signs with it), so that it protects from mistakes alone: anybody can sign with it.

/// An Ed25519 public key (RFC 8032).
pub type PublicKey = [u8; 32];

/// Public half of the development key: of the seed that is 32 times the byte 0x43, an arbitrary choice.
pub const DEVELOPMENT: PublicKey = [
    0x22, 0xfc, 0x29, 0x77, 0x92, 0xf0, 0xb6, 0xff, 0xc0, 0xbf, 0xcf, 0xdb, 0x7e, 0xdb, 0x0c, 0x0a,
    0xa1, 0x4e, 0x02, 0x5a, 0x36, 0x5e, 0xc0, 0xe3, 0x42, 0xe8, 0x6e, 0x38, 0x29, 0xcb, 0x74, 0xb6,
];

/// The key that this image trusts: `COURIER_UPDATE_KEY`, 64 hexadecimal digits, of the environment that it was built in, or the
/// development key.
pub const TRUSTED: PublicKey = match option_env!("COURIER_UPDATE_KEY") {
    None => DEVELOPMENT,
    Some(text) => match parse(text) {
        Some(key) => key,
        None => panic!("COURIER_UPDATE_KEY: wanted 64 hexadecimal digits, the public key"),
    },
};

/// Whether `key` is the development key.
pub const fn is_development(key: &PublicKey) -> bool {
    let (mut same, mut at) = (true, 0);
    while at < key.len() {
        same &= key[at] == DEVELOPMENT[at];
        at += 1;
    }
    same
}

/// A key as 64 hexadecimal digits.
pub const fn parse(text: &str) -> Option<PublicKey> {
    let (digits, mut key, mut at) = (text.as_bytes(), [0; 32], 0);
    if digits.len() != 64 {
        return None;
    }
    while at < 64 {
        let Some(digit) = (digits[at] as char).to_digit(16) else {
            return None;
        };
        key[at / 2] = key[at / 2] << 4 | digit as u8;
        at += 1;
    }
    Some(key)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn keys_are_64_hexadecimal_digits() {
        let text = "22fc297792f0b6ffc0bfcfdb7edb0c0aa14e025a365ec0e342e86e3829cb74b6";
        assert_eq!(parse(text), Some(DEVELOPMENT));
        assert!(is_development(&DEVELOPMENT) && !is_development(&[0; 32]));
        assert_eq!(parse(&text[1..]), None);
        assert_eq!(parse(&text.replace('f', "g")), None);
    }

    #[test]
    fn the_development_key_is_of_the_published_seed() {
        let seed = ed25519_compact::Seed::new([0x43; 32]);
        let pair = ed25519_compact::KeyPair::from_seed(seed);
        assert_eq!(pair.pk.as_ref(), DEVELOPMENT);
    }
}
