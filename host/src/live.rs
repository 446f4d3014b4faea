//! Commands that show what a board says as it comes.

use crate::board::Link;
use crate::json::Json;
use anyhow::{Result, ensure};
use std::time::{Duration, Instant};

/// Time between two looks at the channel.
const LOOK: Duration = Duration::from_millis(20);

/// Their options.
#[derive(Debug, clap::Args)]
pub struct Live {
    /// Stop after so many seconds; without it, when interrupted.
    #[arg(long, value_name = "S")]
    seconds: Option<f64>,
    /// JSON, one object a line.
    #[command(flatten)]
    pub json: Json,
}

impl Live {
    /// How long, s.
    ///
    /// # Errors
    /// The user gave no time.
    pub fn seconds(&self) -> Result<f64> {
        let seconds = self.seconds.unwrap_or(f64::INFINITY);
        ensure!(seconds > 0.0, "--seconds: found {seconds}, wanted above 0");
        Ok(seconds)
    }

    /// Looks again and again until the time is over. A simulated board's time runs as fast as it can: here it runs with the
    /// clock, since live is what was asked for.
    ///
    /// # Errors
    /// The board cannot be reached, or `look` fails.
    pub fn watch(
        &self,
        link: &mut Link,
        mut look: impl FnMut(&mut Link) -> Result<()>,
    ) -> Result<()> {
        let seconds = self.seconds()?;
        let begin = Instant::now();
        let mut passed = Duration::ZERO;
        while passed.as_secs_f64() < seconds {
            link.pass(LOOK)?;
            passed += LOOK;
            look(link)?;
            std::thread::sleep(passed.saturating_sub(begin.elapsed()));
        }
        Ok(())
    }
}
