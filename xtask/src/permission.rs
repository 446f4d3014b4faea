//! Whether this run may install anything. Only `setup`, once the user has agreed, and `test`, whose purpose it is, may.

use anyhow::Result;
use std::sync::atomic::{AtomicBool, Ordering::Relaxed};

static GRANTED: AtomicBool = AtomicBool::new(false);

/// Something is missing, and this command does not install.
#[derive(Debug, thiserror::Error)]
#[error(
    "found no {missing}, wanted it: `cargo xtask setup{of}` says what it will install, and does it"
)]
pub struct NotSetUp {
    missing: String,
    /// Words behind `setup`: what it is to set up if it is not the emulated board.
    of: &'static str,
}

impl NotSetUp {
    /// `setup` needs these words, the space before them included, to bring what is missing.
    pub fn of(error: anyhow::Error, of: &'static str) -> anyhow::Error {
        match error.downcast::<Self>() {
            Ok(Self { missing, .. }) => Self { missing, of }.into(),
            Err(other) => other,
        }
    }
}

/// From here on this run may install.
pub fn grant() {
    GRANTED.store(true, Relaxed);
}

/// To be called before anything is installed.
///
/// # Errors
/// [`NotSetUp`], which names what is missing.
pub fn wanted(missing: &str) -> Result<()> {
    if GRANTED.load(Relaxed) {
        return Ok(());
    }
    let missing = missing.to_owned();
    Err(NotSetUp { missing, of: "" }.into())
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::arm;

    #[test]
    fn nothing_is_installed_without_a_permission() {
        let error =
            arm::ensure_program("no-such-program-anywhere", &["no-such-package"]).unwrap_err();
        assert!(error.is::<NotSetUp>(), "{error:#}");
        let text = format!("{error:#}");
        assert!(
            text.contains("no-such-program-anywhere") && text.contains("cargo xtask setup`"),
            "{text}"
        );
        let of_chip = NotSetUp::of(error, " chip").to_string();
        assert!(of_chip.contains("`cargo xtask setup chip`"), "{of_chip}");
    }
}
