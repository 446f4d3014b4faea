//! The file of a firmware image, as `courier update` sends it: header, 0xFF up to [`HEADER_ROOM`], body (`docs/update.md`).

use anyhow::{Context, Result, ensure};
use courier_sensor::update::header::{self, CRC32, Header, SIGNATURE_BYTES};
use courier_sensor::update::layout::{HEADER_ROOM, MOST_BODY_BYTES, WORD_BYTES};
use courier_sensor::update::version::Version;
use ed25519_compact::{KeyPair, PublicKey, Seed, Signature};

/// What an erased byte of flash reads as.
const ERASED: u8 = 0xFF;

/// The secret half of the development key, which is no secret: `courier_sensor::update::key`.
pub const DEVELOPMENT_SEED: [u8; 32] = [0x43; 32];

/// The public half of a secret key.
pub fn public_half(seed: [u8; 32]) -> [u8; 32] {
    *KeyPair::from_seed(Seed::new(seed)).pk
}

/// An image.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Image {
    /// What it says of itself.
    pub header: Header,
    /// Whole double words.
    pub body: Vec<u8>,
}

impl Image {
    /// Signs a body, filled up to whole double words. `seed`: the secret key (RFC 8032).
    ///
    /// # Errors
    /// The body is empty or longer than a bank has room for.
    pub fn sign(seed: [u8; 32], board: &str, version: Version, mut body: Vec<u8>) -> Result<Self> {
        let found = body.len();
        ensure!(
            (1..=MOST_BODY_BYTES as usize).contains(&found),
            "found an image of {found} bytes, wanted 1 to {MOST_BODY_BYTES}"
        );
        body.resize(found.next_multiple_of(WORD_BYTES as usize), ERASED);
        let pair = KeyPair::from_seed(Seed::new(seed));
        let mut header = Header {
            board: header::board(board),
            version,
            body_bytes: body.len() as u32,
            body_crc: CRC32.checksum(&body),
            key: *pair.pk,
            signature: [0; SIGNATURE_BYTES],
        };
        header.signature = *pair.sk.sign(message(&header, &body), None);
        Ok(Self { header, body })
    }

    /// Takes a file apart and checks that it is whole and that its signature is by the key that it names. Whether a board trusts that
    /// key, the board says.
    ///
    /// # Errors
    /// What is wrong with it.
    pub fn parse(file: &[u8]) -> Result<Self> {
        let bytes = file.first_chunk().with_context(|| {
            let found = file.len();
            format!("found {found} bytes, wanted an image of this firmware")
        })?;
        let header = Header::parse(bytes).map_err(|error| {
            anyhow::anyhow!("found {error}, wanted an image, as `cargo xtask image` makes it")
        })?;
        let (found, wanted) = (file.len(), (HEADER_ROOM + header.body_bytes) as usize);
        ensure!(
            found == wanted,
            "found {found} bytes, wanted {wanted}: the file is not whole"
        );
        let body = file[HEADER_ROOM as usize..].to_vec();
        ensure!(
            CRC32.checksum(&body) == header.body_crc,
            "found another check value than the header's, wanted the image undamaged"
        );
        PublicKey::new(header.key)
            .verify(message(&header, &body), &Signature::new(header.signature))
            .ok()
            .context("found a wrong signature, wanted one by the key that the image names")?;
        Ok(Self { header, body })
    }

    /// The file's bytes.
    pub fn file(&self) -> Vec<u8> {
        let mut file = self.header.encode().to_vec();
        file.resize(HEADER_ROOM as usize, ERASED);
        file.extend(&self.body);
        file
    }
}

/// What is signed.
fn message(header: &Header, body: &[u8]) -> Vec<u8> {
    [&header.signed()[..], body].concat()
}

#[cfg(test)]
mod tests {
    use super::*;

    fn image() -> Image {
        let version = Version::parse("1.2.3").unwrap();
        Image::sign(DEVELOPMENT_SEED, "g474", version, vec![7; 1001]).unwrap()
    }

    #[test]
    fn a_file_is_read_back() {
        let image = image();
        assert_eq!(image.body.len(), 1008);
        assert_eq!(Image::parse(&image.file()).unwrap(), image);
        assert_eq!(
            image.header.key,
            courier_sensor::update::key::DEVELOPMENT,
            "the published key"
        );
    }

    #[test]
    fn damaged_files_are_told_by_what_is_wrong() {
        let whole = image().file();
        let told = |file: &[u8]| Image::parse(file).unwrap_err().to_string();
        assert!(told(&whole[..100]).contains("found 100 bytes"));
        assert!(told(&whole[..900]).contains("found 900 bytes, wanted 1520"));
        assert!(told(&[0x7F; 2000]).contains("no image"));
        let changed = |place: usize| {
            let mut file = whole.clone();
            file[place] ^= 1;
            file
        };
        assert!(told(&changed(30)).contains("damaged"));
        assert!(told(&changed(700)).contains("check value"));
        let mut image = image();
        image.header.version.major = 9;
        assert!(told(&image.file()).contains("signature"));
        let empty = Image::sign([1; 32], "g474", Version::default(), vec![]);
        assert!(
            empty
                .unwrap_err()
                .to_string()
                .contains("found an image of 0 bytes")
        );
    }
}
