//! The board's stream of samples, and the noise of its channels where the courier stands.

use crate::board::{Link, motion};
use crate::interrupt;
use anyhow::{Context, Result, bail};
use courier_sensor::link::message::{Action, Reply};
use courier_sensor::link::telemetry::{Channels, Sample, StreamOrder};
use recording::noise::at_rest::{self, CHANNELS, Noise, Reading, Unmeasured};
use std::time::Duration;

/// Time between two looks at the channel: a fifth of what the board's buffer holds at 20 kHz.
pub(super) const LOOK: Duration = Duration::from_millis(1);
/// Looks without any sample after which the rest is given up.
pub(super) const PATIENCE_LOOKS: u32 = 2000;
/// Time over which the noise is measured, s: at 20 kHz it is then known to half a percent.
const NOISE_S: f64 = 0.5;
/// One sample in so many for it: the first with which the link keeps up.
const NOISE_DECIMATIONS: [u16; 5] = [1, 2, 4, 8, 16];
/// What a recording and the measurement of its noise need of each sample.
pub const WANTED: Channels = Channels::STATUS
    .union(Channels::RAW)
    .union(Channels::UNMODIFIED)
    .union(Channels::TEMPERATURE);

/// Starts a stream of so many samples, and forgets those that came before.
pub(super) fn start(link: &mut Link, decimation: u16, samples: u32) -> Result<()> {
    link.drop_samples()?;
    ask(
        link,
        Action::Stream(StreamOrder {
            channels: WANTED.bits(),
            decimation,
            samples,
        }),
    )
}

/// Noise of the board's channels where the courier stands: at the full rate, or as near to it as the link keeps up.
pub(super) fn measure_noise(link: &mut Link, rate_hz: f64) -> Result<Noise> {
    motion::rest(link)?;
    let mut found = Err(Unmeasured::Gaps { blocks: 0 });
    for decimation in NOISE_DECIMATIONS {
        let readings = readings(link, decimation, (NOISE_S * rate_hz).ceil() as u32)?;
        found = at_rest::measure(&readings, decimation.into());
        if !matches!(found, Err(Unmeasured::Gaps { .. })) {
            break;
        }
    }
    found.context("noise of the channels (or state it: --noise-counts QUADRATURE,ELECTRODE)")
}

/// So many readings, less those that were lost.
fn readings(link: &mut Link, decimation: u16, wanted: u32) -> Result<Vec<Reading>> {
    start(link, decimation, wanted)?;
    let mut readings = Vec::with_capacity(wanted as usize);
    let mut silent = 0;
    while (readings.len() as u32).saturating_add(link.lost()) < wanted && silent < PATIENCE_LOOKS {
        let seen = readings.len();
        interrupt::check()?;
        link.pass(LOOK)?;
        link.listen(|sample| {
            readings.extend(reading(sample));
            Ok(())
        })?;
        silent = if readings.len() == seen {
            silent + 1
        } else {
            0
        };
    }
    ask(link, Action::Stream(StreamOrder::default()))?;
    Ok(readings)
}

fn reading(sample: &Sample) -> Option<Reading> {
    let ((pairs, electrodes), outputs) = (sample.raw?, sample.unmodified?);
    let mut counts = [0.0; CHANNELS];
    let all = pairs.iter().flatten().chain(&electrodes);
    counts
        .iter_mut()
        .zip(all)
        .for_each(|(place, count)| *place = f64::from(*count));
    Some(Reading {
        sequence: sample.sequence,
        counts,
        position_turns: outputs
            .map(|output| f64::from(output.teeth) + f64::from(output.fraction_turns)),
    })
}

/// An order that is answered by a plain yes.
pub(super) fn ask(link: &mut Link, action: Action) -> Result<()> {
    let Reply::Done = link.ask(action)? else {
        bail!("the board: wanted a plain yes")
    };
    Ok(())
}
