//! A recording from a board's telemetry.

mod measured;
mod stream;
mod tape;

pub use stream::WANTED;
pub use tape::{meta, row};

use crate::board::{Link, motion};
use crate::destination::Destination;
use crate::interrupt;
use anyhow::{Result, bail};
use courier_sensor::app::background::SELF_MOTION_M_PER_S;
use courier_sensor::drivers::motion::Target;
use courier_sensor::link::message::{Action, Reply};
use courier_sensor::link::telemetry::StreamOrder;
use hal_sim::world::World;
use indicatif::ProgressBar;
use measured::Measured;
use recording::noise::at_rest::Noise;
use recording::{Meta, Recording, Samples};
use serde::Serialize;
use stream::{LOOK, PATIENCE_LOOKS, ask, measure_noise, start};
use tape::{Logged, Tape};

/// What to record.
#[derive(Clone, Debug)]
pub struct Order {
    /// Where to.
    pub to: Destination,
    /// One sample in so many.
    pub decimation: u16,
    /// Names of the platen and of the beacon, empty where none is stated.
    pub surroundings: [String; 2],
    /// Noise of the channels where it is known; none: measured before the first run, while the courier rests.
    pub noise: Option<Noise>,
    /// One after the other.
    pub runs: Vec<Run>,
}

/// One motion and its samples.
#[derive(Clone, Debug)]
pub struct Run {
    /// Name of the motion.
    pub name: String,
    /// Where it starts; none: where the courier is.
    pub from: Option<Target>,
    /// Where it goes, and how fast, m/s; none: it stands, or others move it.
    pub to: Option<(Target, f32)>,
    /// How long, s.
    pub seconds: f64,
}

/// What was recorded.
#[derive(Clone, Copy, Debug, Serialize)]
pub struct Recorded {
    /// Samples in the recording.
    pub samples: u32,
    /// Samples that should be in it and are not: the link or the board was too slow for them.
    pub lost: u32,
    /// Noise that the recording states.
    #[serde(skip)]
    pub noise: Noise,
}

/// Records. `world` is what is around a simulated board: what its machine logs beside the readings stands in the recording as well.
///
/// # Errors
/// The board cannot be reached or refuses; the noise cannot be measured; the folder cannot be written. Nothing is left of it then.
pub fn record(
    link: &mut Link,
    world: Option<&World>,
    order: &Order,
    progress: &ProgressBar,
) -> Result<Recorded> {
    let mut recorder = Recorder::begin(link, world, &order.to, order.decimation, false)?;
    let [platen_id, beacon_id] = &order.surroundings;
    recorder.state_surroundings(platen_id, beacon_id);
    let all = order
        .runs
        .iter()
        .map(|run| recorder.wanted(run))
        .sum::<u32>();
    progress.set_length(u64::from(all));
    recorder.know_noise(link, order.noise)?;
    for run in &order.runs {
        recorder.take_run(link, run, progress, |_| false)?;
    }
    progress.finish_and_clear();
    recorder.finish()
}

/// A recording that is added to motion by motion.
pub struct Recorder {
    tape: Tape,
    wanted: u32,
}

impl Recorder {
    /// Begins a recording; nothing is sampled yet. One that `is_watched` keeps its samples in memory as well, for [`Self::so_far`].
    ///
    /// # Errors
    /// The board cannot be reached or the folder cannot be written.
    pub fn begin(
        link: &mut Link,
        world: Option<&World>,
        to: &Destination,
        decimation: u16,
        is_watched: bool,
    ) -> Result<Self> {
        let Reply::Status(status) = link.ask(Action::Status)? else {
            bail!("the board: wanted a status")
        };
        let meta = meta(link);
        let logged = world.and_then(Logged::new);
        let names: Vec<&str> = logged.iter().map(|logged| logged.name).collect();
        let tape = Tape {
            writer: to.create_logging(&meta, &names)?,
            seen: Recording {
                meta,
                samples: Samples::default(),
                warnings: Vec::new(),
            },
            is_watched,
            beside: Vec::new(),
            logged,
            decimation,
            run: String::new(),
            rate_hz: f64::from(link.hello().rate_hz),
            status,
            measured: Measured::default(),
            noise: Noise::default(),
            samples: 0,
            first: None,
            temperature_0_k: None,
        };
        Ok(Self { tape, wanted: 0 })
    }

    /// States which platen and which beacon the courier is over and under; an empty name states nothing.
    pub fn state_surroundings(&mut self, platen_id: &str, beacon_id: &str) {
        for meta in [self.tape.writer.meta_mut(), &mut self.tape.seen.meta] {
            meta.names.platen_id = platen_id.into();
            meta.names.beacon_id = beacon_id.into();
        }
    }

    /// Takes the noise of the channels as known, or measures it while the courier rests.
    ///
    /// # Errors
    /// It cannot be measured.
    pub fn know_noise(&mut self, link: &mut Link, known: Option<Noise>) -> Result<()> {
        self.tape.noise = match known {
            Some(known) => known,
            None => measure_noise(link, self.tape.rate_hz)?,
        };
        Ok(())
    }

    /// Samples of a run.
    fn wanted(&self, run: &Run) -> u32 {
        let wanted = run.seconds * self.tape.rate_hz / f64::from(self.tape.decimation);
        wanted.ceil().max(2.0) as u32
    }

    /// Goes to where the run starts, and keeps its samples from the moment at which its motion begins, until all are there or those of this
    /// run are `enough`.
    ///
    /// # Errors
    /// The board cannot be reached, refuses the motion, or the user interrupts.
    pub fn take_run(
        &mut self,
        link: &mut Link,
        run: &Run,
        progress: &ProgressBar,
        mut enough: impl FnMut(&Samples) -> bool,
    ) -> Result<()> {
        let wanted = self.wanted(run);
        let tape = &mut self.tape;
        tape.run.clone_from(&run.name);
        if let Some(from) = run.from {
            motion::go(link, from, SELF_MOTION_M_PER_S)?;
        }
        let before = tape.samples;
        start(link, tape.decimation, wanted)?;
        if let Some((target, speed_m_per_s)) = run.to {
            motion::start(link, target, speed_m_per_s)?;
        }
        let mut silent = 0;
        let mut ended_early = false;
        while tape.samples - before + link.lost() < wanted
            && silent < PATIENCE_LOOKS
            && !ended_early
        {
            let seen = tape.samples;
            interrupt::check()?;
            link.pass(LOOK)?;
            link.listen(|sample| tape.take(sample))?;
            silent = if tape.samples == seen { silent + 1 } else { 0 };
            progress.set_position(u64::from(tape.samples));
            ended_early = tape.samples > seen && enough(&tape.seen.samples);
        }
        self.wanted += if ended_early {
            tape.samples - before + link.lost()
        } else {
            wanted
        };
        ask(link, Action::Stream(StreamOrder::default()))
    }

    /// What is recorded so far, as it will be read.
    #[must_use]
    pub fn so_far(&self) -> Recording {
        let tape = &self.tape;
        let mut recording = tape.seen.clone();
        tape.state(&mut recording.meta);
        if let Some(logged) = &tape.logged {
            recording.samples.log(recording::Logged {
                name: logged.name.into(),
                values: tape.beside.clone(),
            });
        }
        recording
    }

    /// What the recording states.
    #[must_use]
    pub fn meta(&self) -> &Meta {
        &self.tape.seen.meta
    }

    /// Time from the first sample to the last, s.
    #[must_use]
    pub fn seconds(&self) -> f64 {
        let t_s = self.tape.seen.samples.t_s();
        t_s.last()
            .zip(t_s.first())
            .map_or(0.0, |(last, first)| last - first)
    }

    /// Ends the recording; it is in its folder then.
    ///
    /// # Errors
    /// The folder cannot be written.
    pub fn finish(self) -> Result<Recorded> {
        let recorded = Recorded {
            samples: self.tape.samples,
            lost: self.wanted - self.tape.samples.min(self.wanted),
            noise: self.tape.noise,
        };
        self.tape.finish()?;
        Ok(recorded)
    }
}
