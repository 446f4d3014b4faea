//! Programs that connect to `courier monitor` and draw while it runs, in builds with the feature `mcap`.

use crate::seen::Seen;
use anyhow::Result;
use std::net::SocketAddr;

/// Listens while the monitor runs.
pub struct MonitorServer(form::Serving);

impl MonitorServer {
    /// Begins to listen.
    ///
    /// # Errors
    /// The address is not to be had; a build without the feature.
    pub fn new(address: SocketAddr) -> Result<Self> {
        form::new(address).map(Self)
    }

    /// Where it listens.
    ///
    /// # Errors
    /// The system does not say.
    pub fn address(&self) -> Result<SocketAddr> {
        form::address(&self.0)
    }

    /// Sends what was seen to all who ask for it. Waits for nobody.
    ///
    /// # Errors
    /// The host's clock.
    pub fn push(&mut self, seen: &Seen) -> Result<()> {
        form::push(&mut self.0, seen)
    }
}

#[cfg(feature = "mcap")]
mod form {
    use super::Seen;
    use anyhow::{Context, Result};
    use std::net::SocketAddr;

    pub(super) struct Serving {
        server: bag::Server,
        /// Set by the first state: only that tells when the board's time was zero.
        zero_ns: Option<u64>,
    }

    pub(super) fn new(address: SocketAddr) -> Result<Serving> {
        let told = || {
            format!(
                "--serve: found {address}, wanted an address of this machine and a port that is free"
            )
        };
        Ok(Serving {
            server: bag::Server::bind(address).with_context(told)?,
            zero_ns: None,
        })
    }

    pub(super) fn address(serving: &Serving) -> Result<SocketAddr> {
        Ok(serving.server.address()?)
    }

    pub(super) fn push(serving: &mut Serving, seen: &Seen) -> Result<()> {
        let zero_ns = match serving.zero_ns {
            Some(zero_ns) => zero_ns,
            None => *serving.zero_ns.insert(seen.zero_ns()?),
        };
        serving.server.push(&seen.state(), zero_ns);
        Ok(())
    }
}

#[cfg(not(feature = "mcap"))]
mod form {
    use super::Seen;
    use anyhow::{Result, bail};
    use std::net::SocketAddr;

    pub(super) enum Serving {}

    pub(super) fn new(_: SocketAddr) -> Result<Serving> {
        bail!(
            "found --serve, wanted a courier with MCAP: `cargo install --path host --features mcap`"
        )
    }

    pub(super) fn address(serving: &Serving) -> Result<SocketAddr> {
        match *serving {}
    }

    pub(super) fn push(serving: &mut Serving, _: &Seen) -> Result<()> {
        match *serving {}
    }
}
