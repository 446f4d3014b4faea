//! The MCAP file that `courier monitor` writes besides, in builds with the feature `mcap`.

use crate::seen::Seen;
use anyhow::{Context, Result};
use std::path::{Path, PathBuf};

/// A new file, which is never put over another.
pub struct MonitorFile {
    path: PathBuf,
    form: form::Live,
}

impl MonitorFile {
    /// Begins it.
    ///
    /// # Errors
    /// There is a file already, or none can be made; a build without the feature.
    pub fn new(path: &Path) -> Result<Self> {
        Ok(Self {
            path: path.to_owned(),
            form: form::new(path)?,
        })
    }

    /// Adds what was seen.
    ///
    /// # Errors
    /// A failure to write.
    pub fn push(&mut self, seen: &Seen) -> Result<()> {
        form::push(&mut self.form, seen).with_context(|| self.path.display().to_string())
    }

    /// Ends it with its index; one that is not ended can be read but for its last second.
    ///
    /// # Errors
    /// A failure to write.
    pub fn end(self) -> Result<()> {
        form::end(self.form).with_context(|| self.path.display().to_string())
    }
}

#[cfg(feature = "mcap")]
mod form {
    use super::Seen;
    use anyhow::{Context, Result};
    use std::fs::File;
    use std::path::Path;

    /// Begun with the first state: only that tells when the board's time was zero.
    pub(super) enum Live {
        Ready(File),
        Begun(Box<bag::Live>),
        Failed,
    }

    pub(super) fn new(path: &Path) -> Result<Live> {
        let told = || format!("{}: wanted the name of a new file", path.display());
        File::create_new(path).map(Live::Ready).with_context(told)
    }

    pub(super) fn push(live: &mut Live, seen: &Seen) -> Result<()> {
        let mut begun = match std::mem::replace(live, Live::Failed) {
            Live::Ready(file) => Box::new(bag::Live::begin(file, seen.zero_ns()?)?),
            Live::Begun(begun) => begun,
            Live::Failed => return Ok(()),
        };
        begun.push(&seen.state())?;
        *live = Live::Begun(begun);
        Ok(())
    }

    pub(super) fn end(live: Live) -> Result<()> {
        match live {
            Live::Begun(begun) => Ok(begun.end()?),
            Live::Ready(_) | Live::Failed => Ok(()),
        }
    }
}

#[cfg(not(feature = "mcap"))]
mod form {
    use super::Seen;
    use anyhow::{Result, bail};
    use std::path::Path;

    pub(super) enum Live {}

    pub(super) fn new(path: &Path) -> Result<Live> {
        bail!(
            "{}: found --mcap, wanted a courier with MCAP: `cargo install --path host --features mcap`",
            path.display()
        )
    }

    pub(super) fn push(live: &mut Live, _: &Seen) -> Result<()> {
        match *live {}
    }

    pub(super) fn end(live: Live) -> Result<()> {
        match live {}
    }
}
