//! Answers under a hash: whoever diagnoses can be shown afterwards that they were not changed.

use rand::TryRng as _;
use rand::rngs::SysRng;
use serde::{Deserialize, Serialize};
use sha2::{Digest, Sha256};
use specimens::Case;

/// What is sealed. The salt keeps the answers from being guessed by trying seeds.
#[derive(Serialize, Deserialize)]
struct Sealed {
    schema: u32,
    salt: String,
    cases: Vec<Case>,
}

/// Text of the answers, with a random salt.
pub fn answers(cases: &[Case]) -> Result<String, String> {
    let mut salt = [0_u8; 32];
    SysRng
        .try_fill_bytes(&mut salt)
        .map_err(|error| format!("no random salt: {error}"))?;
    let sealed = Sealed {
        schema: 1,
        salt: hex(&salt),
        cases: cases.to_vec(),
    };
    serde_json::to_string_pretty(&sealed).map_err(|error| error.to_string())
}

/// The cases of a text.
pub fn open(text: &str) -> Result<Vec<Case>, String> {
    let sealed: Sealed = serde_json::from_str(text).map_err(|error| error.to_string())?;
    if sealed.schema == 1 {
        Ok(sealed.cases)
    } else {
        Err(format!("schema: found {}, wanted 1", sealed.schema))
    }
}

/// SHA-256 in hexadecimal.
pub fn hash(bytes: &[u8]) -> String {
    hex(&Sha256::digest(bytes))
}

fn hex(bytes: &[u8]) -> String {
    bytes.iter().map(|byte| format!("{byte:02x}")).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use specimens::Conditions;

    #[test]
    fn the_hash_is_sha_256() {
        assert_eq!(
            hash(b"abc"),
            "ba7816bf8f01cfea414140de5dae2223b00361a396177a9cb410ff61f20015ad"
        );
    }

    #[test]
    fn the_same_answers_are_sealed_differently_and_open_the_same() {
        let cases: Vec<Case> = (0..3)
            .map(|n| Case::draw(n, 1, Conditions::Usual))
            .collect();
        let (one, other) = (answers(&cases).unwrap(), answers(&cases).unwrap());
        assert_ne!(hash(one.as_bytes()), hash(other.as_bytes()));
        assert_eq!(open(&one).unwrap(), cases);
    }
}
