//! The MCAP file that `courier monitor` writes besides, in builds with the feature `mcap`.

use anyhow::{Context, Result};
use std::path::{Path, PathBuf};

/// What a line of the monitor says.
#[derive(Clone, Copy, Debug)]
#[cfg_attr(
    not(feature = "mcap"),
    expect(dead_code, reason = "a build without the feature writes nothing")
)]
pub struct Seen<'a> {
    /// The board's time, s.
    pub t_s: f64,
    /// x and y, m.
    pub place_m: [f64; 2],
    /// The angle by each pair, rad.
    pub theta_rad: [f64; 2],
    /// g_p, m.
    pub parity_m: f64,
    /// The status' bits, and their names.
    pub status: (u32, &'a str),
}

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
    use std::time::{SystemTime, UNIX_EPOCH};

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
            Live::Ready(file) => {
                let now_ns = SystemTime::now().duration_since(UNIX_EPOCH)?.as_nanos();
                let zero_ns = u64::try_from(now_ns)?.saturating_sub((seen.t_s * 1e9) as u64);
                Box::new(bag::Live::begin(file, zero_ns)?)
            }
            Live::Begun(begun) => begun,
            Live::Failed => return Ok(()),
        };
        let [x_m, y_m] = seen.place_m;
        let state = bag::State {
            t_s: seen.t_s,
            x_m,
            y_m,
            theta_rad: seen.theta_rad,
            parity_m: seen.parity_m,
            status: seen.status,
        };
        begun.push(&state)?;
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
